"""Frame timing: time of each part of a frame, the cause of late frames, and frame pacing."""

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
import numpy.typing as npt

PARTS: Final = ("events", "simulation", "poses", "upload", "draw", "rest", "swap")
"""Parts of a frame, in order. With a graphics card, `draw` is the time to submit commands; the card's own time is part
of `swap`, as is waiting for the display."""
WAITING: Final = "waiting"
"""Blamed if the frame's parts took their usual time: the machine woke the show too late."""
HISTORY_FRAMES: Final = 4096
"""Frames kept for the percentiles."""
GRAPH_FRAMES: Final = 240
"""Frames in the overlay's graph."""
_SMOOTHING: Final = 0.02
"""Smoothing factor of the usual times."""


class FrameTimes:
    """Times of the parts of the last frames [ms] in a ring buffer. Thread: the show's."""

    def __init__(self, now: Callable[[], float]) -> None:
        """`now()`: monotonic time [s]."""
        self._now = now
        self._ring: npt.NDArray[np.float32] = np.zeros((HISTORY_FRAMES, len(PARTS)), np.float32)
        self._frame_times: npt.NDArray[np.float32] = np.zeros(HISTORY_FRAMES, np.float32)
        self._place = {name: index for index, name in enumerate(PARTS)}
        self._usual = np.zeros(len(PARTS))
        self._count = 0
        self._frame_start = self._last_mark = now()
        self.late_causes = dict.fromkeys((*PARTS, WAITING), 0)
        """Number of late frames that each part caused."""

    def begin(self) -> None:
        """Begin a frame."""
        now = self._now()
        if self._count:
            self._frame_times[(self._count - 1) % HISTORY_FRAMES] = (now - self._frame_start) * 1e3
        self._frame_start = self._last_mark = now
        self._ring[self._count % HISTORY_FRAMES] = 0.0

    def mark(self, part: str) -> None:
        """Add the time since the last mark to this part."""
        now = self._now()
        self._ring[self._count % HISTORY_FRAMES, self._place[part]] += (now - self._last_mark) * 1e3
        self._last_mark = now

    def end(self) -> None:
        """End the frame."""
        self._count += 1

    def record_cause(self, period: float, *, late: bool) -> str:
        """Count and return the part that made the next frame late; empty if it was not.

        `period`: frame period [s]. Frames in time update the usual times; the part that exceeds its own most is blamed.
        """
        if not self._count:
            return ""
        row = self._ring[(self._count - 1) % HISTORY_FRAMES]
        over = row - self._usual
        if not late:
            self._usual += _SMOOTHING * over
            return ""
        worst = int(np.argmax(over))
        guilty = PARTS[worst] if row.sum() > period * 1e3 or over[worst] > 0.25 * period * 1e3 else WAITING
        self.late_causes[guilty] += 1
        return guilty

    def load(self, period: float) -> float:
        """Return the share of `period` [s] used by the last frame, without `swap`, which may wait for the display."""
        if not self._count or period <= 0.0:
            return 0.0
        return float(self._ring[(self._count - 1) % HISTORY_FRAMES, :-1].sum()) / (period * 1e3)

    def copy_recent(self, out: npt.NDArray[np.float32]) -> int:
        """Fill `out` (GRAPH_FRAMES,) with the times from frame to frame [ms], oldest first; return their number."""
        count = min(max(self._count - 1, 0), len(out))
        last = np.arange(self._count - 1 - count, self._count - 1) % HISTORY_FRAMES
        out[:count] = self._frame_times[last]
        return count

    def facts(self) -> dict[str, Any]:
        """Return the status: p50, p99 and p99.9 of each part [ms], and the number of late frames that each caused."""
        kept = self._ring[: min(self._count, HISTORY_FRAMES)]
        if not len(kept):
            return {"parts": {}, "late_by": {}}
        shares = np.percentile(kept, (50, 99, 99.9), axis=0)
        parts = {name: [round(float(value), 3) for value in shares[:, at]] for at, name in enumerate(PARTS)}
        return {"parts": parts, "late_by": {name: count for name, count in self.late_causes.items() if count}}


SPIN_S = 0.001
"""The last part of a wait [s] is a busy loop, because sleeping ends late by about as much."""
GRID_GAIN = 0.04
"""Gain of the phase-locked loop: share of a frame's deviation that moves the grid."""
MAX_RATE_ERROR = 0.02
"""A display's rate deviates from its nominal rate by at most this share."""
STALL_FRAMES = 15
"""After a gap of more frames than this the grid is reset."""
LATE_PERIODS = 1.5
"""A frame counts as late when it starts more than so many periods after the one before it."""


class Pacer:
    """Waits for the time of the next frame and counts the frames that came late.

    A late frame is not made up for: the frames after it keep their distance instead of coming in a burst. While
    frames come in time they stay on the grid of 1/fps, so the rate is exact on average.

    `clock_now()` returns monotonic time [s], `sleep(seconds)` waits about so long. With vertical synchronisation, pass
    a rate slightly above the display's: then the display paces the loop, and this class only limits the rate if the
    display does not wait.
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
        """Wait until the next frame is due and return its start time [s]; the first one starts at once."""
        now = self._now()
        if self._due is not None:
            if self._due - now > SPIN_S:
                self._sleep(self._due - now - SPIN_S)
                now = self._now()
            while now < self._due:
                self._sleep(0.0)  # lets other threads run
                now = self._now()
            if now - self._due < 0.5 * self.period:
                self._due += self.period
            else:
                self._due = now + self.period
        else:
            self._due = now + self.period
        if self._last is not None and now - self._last > LATE_PERIODS * self.period:
            self.late += 1
        self._last = now
        self.frames += 1
        return now


class DisplayGrid:
    """Even presentation times for frames, from the jittering times at which frames start.

    A frame starts when the process wakes up, but its picture appears at the display's next refresh. Sampling the dance
    at the wake-up times would make it stutter. A second-order phase-locked loop therefore follows period and phase of
    the starts slowly: it finds 1/59.94 s even if the display reports 60 Hz. The grid lies at the mean start time.
    """

    def __init__(self, fps: float) -> None:
        """`fps`: approximate frame rate; an error of 1 % is fine."""
        self._nominal = self.period = 1.0 / fps
        """Estimated time between frames [s]."""
        self._last_time: float | None = None
        self._frame_count = 0

    def align(self, started: float) -> float:
        """Return the even time for a frame that starts at `started` [s]; never before that of the last one."""
        if self._last_time is None:
            self._last_time = started
            return started
        # wake-ups are late, never early: a start counts as the next step only after most of a period
        steps = max(math.floor((started - self._last_time) / self.period + 0.25), 1)
        expected = self._last_time + steps * self.period
        off = started - expected
        if abs(off) > self._nominal or steps > STALL_FRAMES:  # a stall: reset the grid
            self._last_time, self._frame_count = max(started, self._last_time), 0
            return self._last_time
        # fast at first, then slow: jitter is averaged over about 1/gain frames
        self._frame_count += 1
        gain = max(2.0 / (self._frame_count + 1), GRID_GAIN)
        self._last_time = expected + gain * off
        if self._frame_count > 1:
            learnt = self.period + 0.25 * gain * gain * off / steps
            self.period = min(
                max(learnt, self._nominal * (1.0 - MAX_RATE_ERROR)), self._nominal * (1.0 + MAX_RATE_ERROR)
            )
        return self._last_time
