"""Programs that a bench runs beside ours. They are the extra `bench` of this project; `make bench` installs them."""

from importlib.util import find_spec
from typing import Final

PACKAGES: Final = {"pybvh": "pybvh", "pyrvo": "pyrvo", "upc-pymotion": "pymotion"}
"""Package that is imported for each peer."""
PARTLY: Final = {"pyrvo": "; it has wheels for x86-64 up to Python 3.13 only"}


def installed(peer: str) -> bool:
    """Whether a peer can be run here."""
    return find_spec(PACKAGES[peer]) is not None


def absence(peer: str) -> str:
    """Return the note of a row without its peer: that it is not installed, and the remedy; empty if it is there."""
    return "" if installed(peer) else f"{peer} is not installed: make bench{PARTLY.get(peer, '')}"
