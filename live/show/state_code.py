"""StateCode: by what code a state was written. Between two versions of the same number, attributes come and go."""

import hashlib
from functools import cache
from pathlib import Path
from typing import Final

_PACKAGE: Final = Path(__file__).resolve().parents[1]
_WRITES_STATE: Final = ("agents", "base", "clock", "control", "graph", "motion", "show")
"""The packages whose objects are part of a show's state."""


@cache
def state_code() -> str:
    """A short hash over the source of all that is in a show's state; worked out once, off the frame (some 30 ms)."""
    digest = hashlib.blake2b(digest_size=8)
    for name in _WRITES_STATE:
        for path in sorted((_PACKAGE / name).rglob("*.py")):
            digest.update(str(path.relative_to(_PACKAGE)).encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()
