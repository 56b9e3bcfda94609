"""Ring: sound between two threads: the callback writes, the analysis reads; nobody waits, nothing is allocated."""

from typing import Final

import numpy as np
import numpy.typing as npt

STAMPS: Final = 512
"""Blocks whose times are kept; half of them can be read."""


class Ring:
    """Frames of sound, and when each block was there.

    Thread: `write` from the callback only, all else from one other thread. Each side moves only its own counters.
    """

    def __init__(self, frames: int, channels: int) -> None:
        self._sound = np.zeros((frames, channels), np.float32)
        self._out = np.zeros((frames // 2, channels), np.float32)
        self._stamp_frame = np.zeros(STAMPS, np.int64)
        self._stamp_time = np.zeros(STAMPS)
        self.longest = frames // 2
        """Frames that one `read` gives at most."""
        self.written = 0
        """Frames written since the start."""
        self.read_frames = 0
        """Frames read (or given up) since the start."""
        self.overrun = 0
        """Frames that were overwritten before anybody read them."""
        self._stamps = 0
        self._stamps_read = 0

    def write(self, block: npt.NDArray[np.float32], time: float) -> None:
        """Copy a block, shape (n, channels), that was complete at `time` [s]; of one too long the end is kept."""
        size = self._sound.shape[0]
        if block.shape[0] > size:
            self.written += block.shape[0] - size
            block = block[-size:]
        start = self.written % size
        first = min(size - start, block.shape[0])
        self._sound[start : start + first] = block[:first]
        self._sound[: block.shape[0] - first] = block[first:]
        self.written += block.shape[0]
        slot = self._stamps % STAMPS
        self._stamp_frame[slot], self._stamp_time[slot] = self.written, time
        self._stamps += 1

    def stamp(self) -> tuple[int, float] | None:
        """(frames written by then, time [s]) of the next block whose time was not read yet; None if there is none."""
        until = self._stamps
        if self._stamps_read >= until:
            return None
        self._stamps_read = max(self._stamps_read, until - STAMPS // 2)
        slot = self._stamps_read % STAMPS
        self._stamps_read += 1
        return int(self._stamp_frame[slot]), float(self._stamp_time[slot])

    def read(self) -> npt.NDArray[np.float32]:
        """All frames not yet read, shape (n, channels), valid until the next call.

        At most half a ring: the writer may already be at work in the older half; what is lost counts as `overrun`.
        """
        size, until = self._sound.shape[0], self.written
        late = until - self.read_frames - self.longest
        if late > 0:
            self.overrun += late
            self.read_frames += late
        start, count = self.read_frames % size, until - self.read_frames
        first = min(size - start, count)
        self._out[:first] = self._sound[start : start + first]
        self._out[first:count] = self._sound[: count - first]
        self.read_frames = until
        return self._out[:count]
