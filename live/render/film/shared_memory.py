"""The picture for other programs of this machine: a ring of pictures in a file that lives in memory.

All numbers are little-endian. The file begins with a header of 4096 bytes:

| byte | type | what it is |
|---|---|---|
| 0 | 8 bytes | `CGLPIC01` |
| 8 | uint32 | bytes of the header: 4096 |
| 12, 16 | uint32 | width, height [pixels] |
| 20 | uint32 | bytes of a pixel: 3 (R, G, B as shown: sRGB) |
| 24 | uint32 | places for pictures: 4 |
| 28 | uint32 | 1 while the show runs, 0 when it has ended |
| 32 | uint64 | number of the newest whole picture, from 1; 0: none yet |
| 64 + 64 i | uint64 | number of the picture in place i; 0 while it is written |
| 72 + 64 i | float64 | when it was drawn [s of the show] |

Picture n lies in place (n - 1) mod 4, which begins at byte 4096 + ((n - 1) mod 4) * width * height * 3, top row first.
A reader copies the newest picture and then looks whether the number of its place is still n: if not, it was too slow
and takes the newest again. Writer and readers wait for nobody.
"""

import contextlib
import mmap
import os
import re
import tempfile
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

Picture = npt.NDArray[np.uint8]

MAGIC: Final = b"CGLPIC01"
HEADER: Final = 4096
PLACES: Final = 4
_HEAD: Final = np.dtype(
    [
        ("magic", "S8"), ("header", "<u4"), ("width", "<u4"), ("height", "<u4"), ("channels", "<u4"),
        ("places", "<u4"), ("open", "<u4"), ("newest", "<u8"),
    ]
)  # fmt: skip
_PLACE: Final = np.dtype({"names": ["number", "time"], "formats": ["<u8", "<f8"], "offsets": [0, 8], "itemsize": 64})


def ring_path(name: str) -> Path:
    """The file of a ring: in /dev/shm where there is one (`shm_open` calls it /NAME), else in the folder for
    temporary files. ValueError for a name that is none."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}", name):
        raise ValueError(f"{name!r}: letters, digits, dots and dashes expected")
    memory = Path("/dev/shm")
    return (memory if memory.is_dir() else Path(tempfile.gettempdir())) / name


class SharedRing:
    """Writes pictures of one size into a ring that other programs read. Thread: one.

    A ring of this name that is there is replaced: its readers see that it has ended and open the new one. Raises
    ValueError for a name that is none or a file that is no ring, OSError where it cannot be made.
    """

    def __init__(self, name: str, size: tuple[int, int]) -> None:
        self.path, self.size = ring_path(name), size
        self.pictures = 0
        if self.path.exists() and not _end(self.path):
            raise ValueError(f"{self.path} is there, and no ring of pictures")
        width, height = size
        fresh = self.path.with_name(f"{self.path.name}.{os.getpid()}.new")
        with fresh.open("w+b") as file:
            file.truncate(HEADER + PLACES * width * height * 3)
            self._memory = mmap.mmap(file.fileno(), 0)
            self._inode = os.fstat(file.fileno()).st_ino
        self._head = np.frombuffer(self._memory, _HEAD, 1)
        self._places = np.frombuffer(self._memory, _PLACE, PLACES, 64)
        self._pixels = np.frombuffer(self._memory, np.uint8, offset=HEADER).reshape(PLACES, height, width, 3)
        self._head[0] = (MAGIC, HEADER, width, height, 3, PLACES, 1, 0)
        fresh.replace(self.path)

    def write(self, picture: Picture, time: float) -> None:
        """Hand over one picture, uint8 RGB (height, width, 3), drawn at `time` [s of the show]."""
        number = self.pictures + 1
        place = (number - 1) % PLACES
        self._places["number"][place] = 0
        np.copyto(self._pixels[place], picture)
        self._places["time"][place] = time
        self._places["number"][place] = number
        self._head["newest"][0] = self.pictures = number

    def close(self) -> None:
        """Tell readers that the show has ended, and remove the file if it is still this one."""
        if self._memory.closed:
            return
        self._head["open"][0] = 0
        del self._head, self._places, self._pixels  # a mapping that is looked at cannot be closed
        self._memory.close()
        with contextlib.suppress(OSError):
            if self.path.stat().st_ino == self._inode:
                self.path.unlink()


def _end(path: Path) -> bool:
    """Tell the readers of a ring that it has ended; False if the file is none."""
    with path.open("r+b") as file:
        if file.read(len(MAGIC)) != MAGIC:
            return False
        file.seek(28)
        file.write(bytes(4))
    return True
