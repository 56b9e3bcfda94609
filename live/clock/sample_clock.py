"""SampleClock: which time of the show belongs to which sample of a device (after Ableton Link's HostTimeFilter)."""

from typing import Final

import numpy as np

RATE_TOLERANCE: Final = 3e-4
"""How far a device's sample rate may truly be off: 300 ppm; real ones stay within 100."""

SPAN_FOR_RATE: Final = 8.0
"""Seconds of observations before the true rate is estimated; until then the nominal one holds."""

JUMP: Final = 0.060
"""When the last observations all lie this far [s] to one side, samples were lost and the line begins anew."""

JUMP_COUNT: Final = 12

REFIT: Final = 8
"""Observations between two fits, once there are some."""


class SampleClock:
    """A robust straight line through (frames counted, time of the callback that brought them).

    The time stamps that sound servers give are worthless (90 ms of scatter over PulseAudio), and callbacks come in
    bunches; medians over the last seconds do not mind either. Thread: one at a time.
    """

    def __init__(self, sample_rate: float, capacity: int = 1024) -> None:
        self.sample_rate = sample_rate
        self._frame = np.zeros(capacity)
        self._late = np.zeros(capacity)
        self._count = 0
        self._fitted = 0
        self._rate_error = 0.0
        self._offset = 0.0
        self._middle = 0.0
        self.jumps = 0
        """How often the line began anew because samples were lost."""

    def observe(self, frame: float, time: float) -> None:
        """Frame number `frame` was there at `time` [s]."""
        slot = self._count % self._frame.shape[0]
        self._frame[slot], self._late[slot] = frame, time - frame / self.sample_rate
        self._count += 1
        if self._count > 2 * JUMP_COUNT and self._jumped():
            last = [(self._count - 1 - back) % self._frame.shape[0] for back in range(JUMP_COUNT)]
            self._frame[:JUMP_COUNT], self._late[:JUMP_COUNT] = self._frame[last], self._late[last]
            self._count = JUMP_COUNT
            self._rate_error = 0.0
            self.jumps += 1
            self._fitted = 0
        if self._count < self._fitted + (REFIT if self._count > 2 * JUMP_COUNT else 1):
            return
        self._fitted = self._count
        self._fit()

    def time_of(self, frame: float) -> float:
        """Time of the show [s] that belongs to a frame number."""
        return frame / self.sample_rate + self._lateness(frame)

    def frame_at(self, time: float) -> float:
        """Frame number that belongs to a time of the show [s]."""
        guess = (time - self._offset) * self.sample_rate
        return (time - self._lateness(guess)) * self.sample_rate

    def _lateness(self, frame: float) -> float:
        return self._offset + self._rate_error * (frame - self._middle) / self.sample_rate

    def _jumped(self) -> bool:
        side = 0.0
        for back in range(JUMP_COUNT):
            slot = (self._count - 1 - back) % self._frame.shape[0]
            off = float(self._late[slot]) - self._lateness(float(self._frame[slot]))
            if abs(off) <= JUMP or off * side < 0.0:
                return False
            side = off
        return True

    def _fit(self) -> None:
        known = min(self._count, self._frame.shape[0])
        frame, late = self._frame[:known], self._late[:known]
        self._middle = float(np.median(frame))
        span = float(np.ptp(frame)) / self.sample_rate
        if span >= SPAN_FOR_RATE:
            newer = frame > self._middle
            rise = float(np.median(late[newer]) - np.median(late[~newer]))
            run = float(np.median(frame[newer]) - np.median(frame[~newer])) / self.sample_rate
            self._rate_error = min(max(rise / run, -RATE_TOLERANCE), RATE_TOLERANCE)
        self._offset = float(np.median(late - self._rate_error * (frame - self._middle) / self.sample_rate))
