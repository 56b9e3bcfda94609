"""Atomic writing of files."""

import os
from pathlib import Path

from live.base.errors import PersonError


def write_atomically(data: bytes, to: Path, option: str) -> int:
    """Write a temporary file next to `to` and rename it; return its size in bytes. PersonError names the option."""
    unfinished = to.with_name(f".{to.name}.{os.getpid()}.tmp")
    try:
        unfinished.write_bytes(data)
        unfinished.replace(to)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise PersonError(f"{option} {to}: cannot be written: {error.strerror}", "choose another folder") from None
    return len(data)
