"""Read the picture that `live play --share shm:NAME` hands over. Needs numpy; copy it into your own program.

python read_ring.py NAME            # says what comes, once a second
python read_ring.py NAME out.ppm    # writes the next picture and ends
"""

import sys
import time
from pathlib import Path

import numpy as np


class Ring:
    """The ring of pictures of a running show; see docs/how-to/picture/share.md for its header."""

    def __init__(self, name):
        memory = Path("/dev/shm")
        self.bytes = np.memmap(memory / name, np.uint8, "r")
        head = self.bytes[:32].tobytes()
        if head[:8] != b"CGLPIC01":
            raise ValueError(f"{name} is no ring of pictures")
        self.header, self.width, self.height, channels, self.places = np.frombuffer(head, "<u4", 5, 8).tolist()
        self.shape = self.places, self.height, self.width, channels
        self.pixels = self.bytes[self.header :].reshape(self.shape)

    @property
    def open(self):
        """Whether the show runs; when it has ended, make a new Ring (another show may have begun)."""
        return bool(self.bytes[28])

    def newest(self):
        """Number of the newest picture, 0: none yet."""
        return int(self.bytes[32:40].view("<u8")[0])

    def read(self):
        """The newest picture: number, seconds of the show, pixels (height, width, 3) in sRGB; None if there is none."""
        while number := self.newest():
            place = (number - 1) % self.places
            note = self.bytes[64 + 64 * place : 80 + 64 * place]
            picture, seconds = self.pixels[place].copy(), float(note[8:].view("<f8")[0])
            if int(note[:8].view("<u8")[0]) == number:  # it was not written over meanwhile
                return number, seconds, picture
        return None


if __name__ == "__main__":
    ring = Ring(sys.argv[1])
    while ring.open:
        found = ring.read()
        if found and len(sys.argv) > 2:
            size = f"P6 {ring.width} {ring.height} 255\n".encode()
            Path(sys.argv[2]).write_bytes(size + found[2].tobytes())
            break
        if found:
            print(f"picture {found[0]} at {found[1]:.3f} s, mean {found[2].mean():.1f}", flush=True)
        time.sleep(1.0 if found else 0.05)
