"""Where the time of frames goes, part by part, and which part made a frame late."""

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
