"""Ring buffer of frames in shared memory, for other programs on this machine.

All numbers are little-endian. The file begins with a header of 4096 bytes:

| byte | type | content |
|---|---|---|
| 0 | 8 bytes | `CGLPIC01` |
| 8 | uint32 | bytes of the header: 4096 |
| 12, 16 | uint32 | width, height [pixels] |
| 20 | uint32 | bytes of a pixel: 3 (R, G, B as shown: sRGB) |
| 24 | uint32 | slots for frames: 4 |
| 28 | uint32 | 1 while the show runs, 0 when it has ended |
| 32 | uint64 | number of the newest complete frame, from 1; 0: none yet |
| 40 | uint32 | 1 if the writer locks the file (flock, exclusive) for as long as it lives |
| 64 + 64 i | uint64 | number of the frame in slot i; 0 while it is written |
| 72 + 64 i | float64 | when it was drawn [s of the show] |

Frame n is in slot (n - 1) mod 4, which begins at byte 4096 + ((n - 1) mod 4) * width * height * 3, top row first.
A reader copies the newest frame and then checks that the number of its slot is still n: if not, the reader was too slow
and reads the newest frame again. Writer and readers never wait for each other. A writer that was killed leaves its
file with 1 at byte 28; where byte 40 is 1, too, a reader that gets the lock knows that nobody writes any more.
"""

import contextlib
import mmap
import os
import re
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.system.file_lock import lock_file
from live.base.system.files import create_private, memory_folder

Picture = npt.NDArray[np.uint8]

MAGIC: Final = b"CGLPIC01"
HEADER_SIZE: Final = 4096
SLOTS: Final = 4
_HEADER_TYPE: Final = np.dtype(
    [
        ("magic", "S8"), ("header", "<u4"), ("width", "<u4"), ("height", "<u4"), ("channels", "<u4"),
        ("places", "<u4"), ("open", "<u4"), ("newest", "<u8"), ("locked", "<u4"),
    ]
)  # fmt: skip
_SLOT_TYPE: Final = np.dtype(
    {"names": ["number", "time"], "formats": ["<u8", "<f8"], "offsets": [0, 8], "itemsize": 64}
)


def ring_path(name: str) -> Path:
    """Return the file of a ring buffer: in /dev/shm where it exists (`shm_open` calls the file /NAME), else in the
    folder for temporary files. Raises ValueError for an invalid name."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}", name):
        raise ValueError(f"{name!r}: letters, digits, dots and dashes expected")
    return memory_folder() / name


class FrameRing:
    """Writes frames of one size into a ring buffer that other programs read. Thread: one.

    `private`: only programs of this user may read it. An existing ring buffer of this name is replaced: its readers see
    that it has ended and open the new one. Raises ValueError for an invalid name or an existing file that is no ring
    buffer, OSError if it cannot be created.
    """

    def __init__(self, name: str, size: tuple[int, int], *, private: bool = False) -> None:
        self.path, self.size = ring_path(name), size
        self.frames = 0
        if self.path.exists() and not _mark_ended(self.path):
            raise ValueError(f"{self.path} exists and is no ring buffer of frames")
        width, height = size
        fresh = self.path.with_name(f"{self.path.name}.{os.getpid()}.new")
        if private:
            fresh.unlink(missing_ok=True)
            os.close(create_private(fresh))
        self._file = fresh.open("r+b" if private else "w+b")
        try:
            length = HEADER_SIZE + SLOTS * width * height * 3
            self._file.truncate(length)
            if hasattr(os, "posix_fallocate"):  # else a full memory would kill the writer later
                os.posix_fallocate(self._file.fileno(), 0, length)
            self._memory = mmap.mmap(self._file.fileno(), 0)
            lock_file(self._file)
        except OSError:
            self._file.close()
            fresh.unlink(missing_ok=True)
            raise
        self._inode = os.fstat(self._file.fileno()).st_ino
        self._header = np.frombuffer(self._memory, _HEADER_TYPE, 1)
        self._slots = np.frombuffer(self._memory, _SLOT_TYPE, SLOTS, 64)
        self._pixels = np.frombuffer(self._memory, np.uint8, offset=HEADER_SIZE).reshape(SLOTS, height, width, 3)
        self._header[0] = (MAGIC, HEADER_SIZE, width, height, 3, SLOTS, 1, 0, 1)
        fresh.replace(self.path)

    def write(self, picture: Picture, time: float) -> None:
        """Write one frame, uint8 RGB (height, width, 3), drawn at `time` [s of the show]."""
        number = self.frames + 1
        place = (number - 1) % SLOTS
        self._slots["number"][place] = 0
        np.copyto(self._pixels[place], picture)
        self._slots["time"][place] = time
        self._slots["number"][place] = number
        self._header["newest"][0] = self.frames = number

    def close(self) -> None:
        """Mark the ring buffer as ended, and remove the file if no other show has replaced it."""
        if self._memory.closed:
            return
        self._header["open"][0] = 0
        del self._header, self._slots, self._pixels  # a mapping with views on it cannot be closed
        self._memory.close()
        self._file.close()
        with contextlib.suppress(OSError):
            if self.path.stat().st_ino == self._inode:
                self.path.unlink()


class FrameRingReader:
    """Reads the newest frames of a ring buffer that another program writes. Thread: one.

    Raises OSError if there is none of this name, if it is no ring buffer of frames, or if its writer was killed.
    """

    def __init__(self, name: str) -> None:
        self._memory: mmap.mmap | None = None
        self._file = ring_path(name).open("rb")
        try:
            self._memory = mmap.mmap(self._file.fileno(), 0, access=mmap.ACCESS_READ)
        except (OSError, ValueError):  # ValueError: an empty file
            self._file.close()
            raise OSError(f"{name} is no ring buffer of frames") from None
        size = len(self._memory)
        if size < HEADER_SIZE or self._memory[: len(MAGIC)] != MAGIC:
            self.close()
            raise OSError(f"{name} is no ring buffer of frames")
        header = np.frombuffer(self._memory[: _HEADER_TYPE.itemsize], _HEADER_TYPE)[0]
        width, height, self._places = int(header["width"]), int(header["height"]), int(header["places"])
        known = (int(header["header"]), int(header["channels"]), self._places) == (HEADER_SIZE, 3, SLOTS)
        if not known or not width * height or size < HEADER_SIZE + SLOTS * width * height * 3:
            self.close()
            raise OSError(f"{name} is a ring buffer of another kind, or cut off")
        self.size = width, height
        """Width and height of the frames [pixels]."""
        self._read_number = 0
        self._is_left = False
        if self._number(28, 4) == 1 and not self.is_open:
            self.close()
            raise OSError(f"{name} was left by a program that was killed")

    @property
    def is_open(self) -> bool:
        """Whether the writer still runs."""
        if self._memory is None or self._is_left or self._number(28, 4) != 1:
            return False
        if self._number(40, 4) == 1:
            with contextlib.suppress(BlockingIOError):
                lock_file(self._file, shared=True)
                self._is_left = True
        return not self._is_left

    def _number(self, at: int, length: int) -> int:
        assert self._memory is not None
        return int.from_bytes(self._memory[at : at + length], "little")

    def read(self) -> Picture | None:
        """Return the newest frame, (height, width, 3), or None if there is no newer one than that read last."""
        number = self._number(32, 8)
        if number == 0 or number == self._read_number:
            return None
        place = (number - 1) % SLOTS
        width, height = self.size
        begin = HEADER_SIZE + place * width * height * 3
        assert self._memory is not None
        data = self._memory[begin : begin + width * height * 3]
        if self._number(64 + 64 * place, 8) != number:  # it was overwritten meanwhile: the next one is whole
            return None
        self._read_number = number
        return np.frombuffer(data, np.uint8).reshape(height, width, 3)

    def close(self) -> None:
        """Free the memory."""
        self._file.close()
        if self._memory is not None:
            self._memory.close()
            self._memory = None


def _mark_ended(path: Path) -> bool:
    """Mark a ring buffer as ended for its readers; False if the file is no ring buffer."""
    with path.open("r+b") as file:
        if file.read(len(MAGIC)) != MAGIC:
            return False
        file.seek(28)
        file.write(bytes(4))
    return True
