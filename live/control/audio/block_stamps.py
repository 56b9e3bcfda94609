"""Times of the blocks of an audio stream, handed from its callback to another thread."""

from typing import Final

import numpy as np

STAMPS: Final = 512
"""Number of stored block times; half of them can be read."""


class BlockStamps:
    """Lock-free ring of frame numbers and times. It allocates nothing.

    Thread: `add` from the callback only, `pop` from one other thread. Each side writes only its own counter.
    """

    def __init__(self) -> None:
        self._frame = np.zeros(STAMPS, np.int64)
        self._time = np.zeros(STAMPS)
        self._added = 0
        self.popped = 0
        """Stamps read or skipped so far."""

    def add(self, frame: int, time: float) -> None:
        """Add the stamp of a block: a frame number and the time [s] at which it was there."""
        slot = self._added % STAMPS
        self._frame[slot], self._time[slot] = frame, time
        self._added += 1

    def pop(self) -> tuple[int, float] | None:
        """Return the next unread stamp, (frame number, time [s]); None if there is none."""
        until = self._added
        if self.popped >= until:
            return None
        self.popped = max(self.popped, until - STAMPS // 2)
        slot = self.popped % STAMPS
        self.popped += 1
        return int(self._frame[slot]), float(self._time[slot])
