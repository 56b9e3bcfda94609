"""Files that a person or another user may have replaced, and files in memory; the same calls on every system."""

import os
import stat
import sys
import tempfile
from pathlib import Path
from typing import Final

_BINARY: Final = getattr(os, "O_BINARY", 0)
"""Without it Windows changes line ends."""
_CAREFUL: Final = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | _BINARY
_UNFOLLOWED: Final = getattr(os, "O_NOFOLLOW", 0)


def open_to_read(path: Path, *, follow: bool = True) -> int:
    """Return a descriptor of a file, which a pipe does not delay; OSError if it cannot be read.

    `follow`: whether it may be a link; if not, a link is refused with ELOOP where the system can.
    """
    return os.open(path, os.O_RDONLY | _CAREFUL | (0 if follow else _UNFOLLOWED))


def create_private(path: Path) -> int:
    """Return a descriptor of a new file that this user alone can read; OSError if there is one already."""
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _CAREFUL | _UNFOLLOWED, 0o600)


def user_number() -> int | None:
    """Return the number of this user; None on a system that has none."""
    return os.getuid() if sys.platform != "win32" else None


def is_private(facts: os.stat_result) -> bool:
    """Whether a file is this user's, and no other's to read; on Windows the home folder sees to that."""
    user = user_number()
    if user is None:
        return True
    return facts.st_uid == user and not stat.S_IMODE(facts.st_mode) & 0o077


def memory_folder() -> Path:
    """Return the folder of files that stay in memory: /dev/shm on Linux, else that of temporary files."""
    memory = Path("/dev/shm")
    return memory if memory.is_dir() else Path(tempfile.gettempdir())
