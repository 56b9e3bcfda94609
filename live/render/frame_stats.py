"""Where the time of frames goes, part by part, and which part made a frame late.

Pacing: one frame every 1/fps seconds, whether or not the display makes the program wait.
"""

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
import numpy.typing as npt

PARTS: Final = ("events", "simulation", "poses", "upload", "draw", "rest", "swap")
"""What a frame does, in this order. Where a graphics card draws, `draw` is the time to ask for it, and its own time
shows in `swap`, where the display's is, too."""
WAITING: Final = "waiting"
"""Blamed where the frame itself was as usual: the machine woke the show too late."""
KEPT: Final = 4096
"""Frames kept for the percentiles."""
SHOWN: Final = 240
"""Frames in the overlay's graph."""
_LEARN: Final = 0.02
"""How fast what is usual follows."""


class FrameTimes:
    """Times of the parts of the last frames [ms], in a preallocated ring. Thread: the show's."""

    def __init__(self, now: Callable[[], float]) -> None:
        """`now()`: seconds that never go back."""
        self._now = now
        self._ring: npt.NDArray[np.float32] = np.zeros((KEPT, len(PARTS)), np.float32)
        self._whole: npt.NDArray[np.float32] = np.zeros(KEPT, np.float32)
        self._place = {name: index for index, name in enumerate(PARTS)}
        self._usual = np.zeros(len(PARTS))
        self._count = 0
        self._began = self._since = now()
        self.blamed = dict.fromkeys((*PARTS, WAITING), 0)
        """How many late frames each part made late."""

    def begin(self) -> None:
        """A frame begins."""
        now = self._now()
        if self._count:
            self._whole[(self._count - 1) % KEPT] = (now - self._began) * 1e3
        self._began = self._since = now
        self._ring[self._count % KEPT] = 0.0

    def mark(self, part: str) -> None:
        """All since the last mark belonged to this part."""
        now = self._now()
        self._ring[self._count % KEPT, self._place[part]] += (now - self._since) * 1e3
        self._since = now

    def end(self) -> None:
        """The frame is over."""
        self._count += 1

    def judge(self, period: float, *, late: bool) -> str:
        """The frame after the last one came `late`, `period` [s] being due, or not: whose fault that was, counted.

        Frames in time say what is usual; whatever exceeds that most is blamed.
        """
        if not self._count:
            return ""
        row = self._ring[(self._count - 1) % KEPT]
        over = row - self._usual
        if not late:
            self._usual += _LEARN * over
            return ""
        worst = int(np.argmax(over))
        guilty = PARTS[worst] if row.sum() > period * 1e3 or over[worst] > 0.25 * period * 1e3 else WAITING
        self.blamed[guilty] += 1
        return guilty

    def load(self, period: float) -> float:
        """The share of `period` [s] that the last frame's parts took, `swap` left out, which may wait for a display."""
        if not self._count or period <= 0.0:
            return 0.0
        return float(self._ring[(self._count - 1) % KEPT, :-1].sum()) / (period * 1e3)

    def recent(self, out: npt.NDArray[np.float32]) -> int:
        """Fill `out` (SHOWN,) with the times from frame to frame [ms], oldest first; returns how many there are."""
        count = min(max(self._count - 1, 0), len(out))
        last = np.arange(self._count - 1 - count, self._count - 1) % KEPT
        out[:count] = self._whole[last]
        return count

    def facts(self) -> dict[str, Any]:
        """For the status: p50, p99 and p99.9 of each part [ms], and who was late how often."""
        kept = self._ring[: min(self._count, KEPT)]
        if not len(kept):
            return {"parts": {}, "late_by": {}}
        shares = np.percentile(kept, (50, 99, 99.9), axis=0)
        parts = {name: [round(float(value), 3) for value in shares[:, at]] for at, name in enumerate(PARTS)}
        return {"parts": parts, "late_by": {name: count for name, count in self.blamed.items() if count}}


SPIN = 0.001
"""The last part of a wait [s] that is not slept through: sleeping ends late by about as much."""
GRID_GAIN = 0.04
"""How much of what a frame's start strays from the grid moves the grid."""
ASTRAY = 0.02
"""A display's rate is at most this share off what it says."""
STALLED = 15
"""After a gap of more pictures than this the grid begins anew."""
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


class DisplayGrid:
    """Even times for frames, from the moments at which the display's swap came back, or at which they were let go.

    A frame begins when the machine happens to wake; its picture is seen at the display's next one. A dance sampled at
    the moments of waking would stutter by what they stray. So frames are counted on a grid whose step and place follow
    those moments slowly (a phase-locked loop of second order): steps of 1/59.94 s also where the display says 60. The
    grid lies where starts lie on average.
    """

    def __init__(self, fps: float) -> None:
        """`fps`: about how many pictures a second; 1 % off does no harm."""
        self._nominal = self.period = 1.0 / fps
        """Seconds from one picture to the next, as learnt."""
        self._at: float | None = None
        self._seen = 0

    def at(self, started: float) -> float:
        """The even time for the frame that begins then [s]; never before that of the last one."""
        if self._at is None:
            self._at = started
            return started
        # machines wake late, never early: only what is later than most of a step is the next one
        steps = max(math.floor((started - self._at) / self.period + 0.25), 1)
        expected = self._at + steps * self.period
        off = started - expected
        if abs(off) > self._nominal or steps > STALLED:  # a stall: begin anew here
            self._at, self._seen = max(started, self._at), 0
            return self._at
        # quick at first, then slow: what strays is averaged over about 1/gain frames
        self._seen += 1
        gain = max(2.0 / (self._seen + 1), GRID_GAIN)
        self._at = expected + gain * off
        if self._seen > 1:
            learnt = self.period + 0.25 * gain * gain * off / steps
            self.period = min(max(learnt, self._nominal * (1.0 - ASTRAY)), self._nominal * (1.0 + ASTRAY))
        return self._at
