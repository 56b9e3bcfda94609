"""Pacing: one frame every 1/fps seconds, whether or not the display makes the program wait."""

from collections.abc import Callable

SPIN = 0.001
"""The last part of a wait [s] that is not slept through: sleeping ends late by about as much."""
LATE = 1.5
"""A frame counts as late when it starts more than so many periods after the one before it."""


class Pacer:
    """Waits for the time of the next frame and counts the frames that came late.

    A late frame is not made up for: the frames after it keep their distance instead of coming in a burst. While
    frames come in time they stay on the grid of 1/fps, so that the rate is exact on average.

    `clock_now()` gives seconds that never go back, `sleep(seconds)` waits about so long. Where the display paces the
    loop by itself (vertical synchronisation), give a rate a little above the display's: then its own wait comes
    first, and this one only guards against a display that does not wait.
    """

    def __init__(self, fps: float, clock_now: Callable[[], float], sleep: Callable[[float], None]) -> None:
        if not 1.0 <= fps <= 1000.0:
            raise ValueError(f"{fps:g} frames/s: 1 to 1000 are possible")
        self.period = 1.0 / fps
        self._now = clock_now
        self._sleep = sleep
        self._due: float | None = None
        self._last: float | None = None
        self.frames = 0
        self.late = 0

    def wait(self) -> float:
        """Wait until the next frame is due and return the time at which it starts [s]; the first one starts at once."""
        now = self._now()
        if self._due is not None:
            if self._due - now > SPIN:
                self._sleep(self._due - now - SPIN)
                now = self._now()
            while now < self._due:
                self._sleep(0.0)  # lets other threads run, comes back at once
                now = self._now()
            if now - self._due < 0.5 * self.period:
                self._due += self.period
            else:
                self._due = now + self.period
        else:
            self._due = now + self.period
        if self._last is not None and now - self._last > LATE * self.period:
            self.late += 1
        self._last = now
        self.frames += 1
        return now
