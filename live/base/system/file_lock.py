"""Advisory locks on open files: flock(2), or a byte of the file beyond its end on Windows.

A lock ends when the file is closed or its process ends. On file systems without locks all is as if there were none.
"""

import contextlib
import errno
import sys
import time
from typing import IO, Any, Final

_RETRY_S: Final = 0.02
_FAR: Final = 1 << 30
"""Byte that is locked on Windows, where a lock forbids others to read what it covers."""
_WITHOUT_LOCKS: Final = {errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.ENOLCK}
"""Errors of a file system that has no locks."""

if sys.platform == "win32":
    import msvcrt

    def _lock(file: IO[Any], *, shared: bool, wait: bool) -> None:
        """There are no shared locks here: one that may be shared takes one of 64 bytes, an exclusive one all."""
        places = [(_FAR + n, 1) for n in range(64)] if shared else [(_FAR, 64)]
        here = file.tell()
        try:
            while True:
                for first, count in places:
                    file.seek(first)
                    with contextlib.suppress(PermissionError):
                        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, count)
                        return
                if not wait:
                    raise BlockingIOError
                time.sleep(_RETRY_S)
        finally:
            file.seek(here)

else:
    import fcntl

    def _lock(file: IO[Any], *, shared: bool, wait: bool) -> None:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | (0 if wait else fcntl.LOCK_NB))


def lock_file(file: IO[Any], *, shared: bool = False, within: float | None = 0.0) -> None:
    """Lock a file until it is closed; BlockingIOError if another process still holds it after `within` seconds, another
    OSError if the system refuses.

    `shared`: others may hold a shared lock, too; `within`: None waits for as long as it takes.
    """
    deadline = time.monotonic() + (within or 0.0)
    while True:
        try:
            _lock(file, shared=shared, wait=within is None)
            return
        except BlockingIOError:
            if time.monotonic() >= deadline:
                raise
        except OSError as error:
            if error.errno not in _WITHOUT_LOCKS:
                raise
            return
        time.sleep(_RETRY_S)
