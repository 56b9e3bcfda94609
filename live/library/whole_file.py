"""Atomic writing of files."""

import os
from pathlib import Path

from live.base.errors import PersonError


def write_atomically(data: bytes, to: Path, option: str, *, synced: bool = False) -> int:
    """Write a temporary file next to `to` and rename it; return its size in bytes. PersonError names the option.

    With `synced` the data is on the disk before the name changes: a power cut leaves the old file or the new one.
    """
    unfinished = to.with_name(f".{to.name}.{os.getpid()}.tmp")
    try:
        with unfinished.open("wb") as file:
            file.write(data)
            if synced:
                file.flush()
                os.fsync(file.fileno())
        unfinished.replace(to)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise PersonError(f"{option} {to}: cannot be written: {error.strerror}", "choose another folder") from None
    return len(data)


def write_with_folder(data: bytes, to: Path, option: str) -> int:
    """Make the folder of `to` if it is missing, then write as `write_atomically` does; return the size in bytes."""
    try:
        to.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PersonError(f"cannot make the folder {to.parent}: {error.strerror}") from None
    return write_atomically(data, to, option)
