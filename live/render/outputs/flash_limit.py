"""Flash limit: no more than three flashes a second, whatever the show does, by letting no more light through.

A general flash is a pair of opposing changes of luminance by a tenth of the most there can be, or more, where the
darker one is below 0.8, on more than a quarter of the picture (W3C, WCAG 2.2, "general flash and red flash thresholds";
ITU-R BT.1702). Here the picture is told as cells; a rise that would be one too many is cut off just below that tenth.
Falls cannot be prevented, but each of them needs a rise before it.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

CHANGE: Final = 0.1
"""A change of luminance by so much counts ..."""
DARK: Final = 0.8
"""... where the darker one is below this."""
RED_CHANGE: Final = 20.0 / 320.0
"""A change of R - G - B of what is saturated red (R / (R + G + B) of 0.8 or more) by so much counts, however bright."""
ALLOWED: Final = 0.95
"""What a rise is cut off at, as a share of that change, so that it does not count."""
AREA: Final = 0.25
"""... on so much of the picture."""
TOGETHER: Final = 0.12
"""Cells that change within so many seconds change together."""
SECOND: Final = 1.0
MOST: Final = 3
"""Rises in a second: each flash has one."""
WATCHED: Final = 2
"""From so many on the luminance of this very picture must be known before it is shown."""


class FlashLimit:
    """Judges pictures in turn; the same pictures at the same times are always judged alike."""

    def __init__(self, cells: int, *, change: float = CHANGE, dark: float = DARK) -> None:
        """`cells`: into how many equal parts pictures are divided; `change` and `dark`: what counts."""
        self._change, self._dark = change, dark
        self._low, self._high = np.full(cells, np.inf), np.full(cells, -np.inf)
        self._rising, self._falling = np.zeros(cells, np.bool_), np.zeros(cells, np.bool_)
        self._rose, self._fell = np.full(cells, -np.inf), np.full(cells, -np.inf)
        self._rises: list[float] = []
        self._up: bool | None = None  # whether the last change was a rise
        self._turned = -np.inf  # when that was
        self._few = max(int(np.ceil(AREA * cells)) - 1, 0)
        self.held = 0
        """Pictures whose light was held back."""

    def rises(self, time: float) -> int:
        """Rises in the second before `time` [s]."""
        while self._rises and self._rises[0] <= time - SECOND + 1e-9:
            self._rises.pop(0)
        return len(self._rises)

    @property
    def is_watching(self) -> bool:
        """Whether so much has changed lately that each picture must be judged before it is shown."""
        return len(self._rises) >= WATCHED

    def judge(self, time: float, luminance: Float64, *, lifted: bool = False) -> float:
        """The share of light, 0 to 1, at which a picture may be shown at `time` [s].

        `luminance`: of its cells, 0 to 1, shape (cells,). `lifted`: it is shown as it is, and only counted.
        """
        left = 1.0 if lifted else self.most(time, luminance)
        self.show(time, luminance * left, held=left < 1.0)
        return left

    def most(self, time: float, luminance: Float64) -> float:
        """The most light, 0 to 1, at which a picture may be shown at `time` [s]."""
        return self._most(time, luminance) if self.rises(time) >= MOST else 1.0

    def show(self, time: float, shown: Float64, *, held: bool = False) -> None:
        """A picture is shown at `time` [s] with this luminance, its light held back or not."""
        self.held += held
        self._note(time, shown)

    def _most(self, time: float, luminance: Float64) -> float:
        """The most light at which too few cells rise for that to count."""
        if self._up:
            return 1.0  # it has risen already: more light is not another change
        free = max(self._few - int(np.count_nonzero(self._rose > time - TOGETHER)), 0)
        dark = (self._low < self._dark) & ~self._rising
        share = np.where(dark, (self._low + ALLOWED * self._change) / np.maximum(luminance, 1e-9), np.inf)
        place = min(free, len(share) - 1)
        return float(min(np.partition(share, place)[place], 1.0))

    def _note(self, time: float, shown: Float64) -> None:
        """Keep what was shown."""
        self._low, self._high = np.minimum(self._low, shown), np.maximum(self._high, shown)
        up = (shown - self._low >= self._change) & (self._low < self._dark) & ~self._rising
        down = (self._high - shown >= self._change) & (shown < self._dark) & ~self._falling
        for now, before, since, extreme in (
            (up, self._rising, self._rose, self._high),
            (down, self._falling, self._fell, self._low),
        ):
            before[now] = True
            since[now] = time
            extreme[now] = shown[now]
        self._falling[up], self._rising[down] = False, False
        self._turn(time)

    def _turn(self, time: float) -> None:
        """A change of the whole picture, if enough cells have changed together the other way than the last time, and
        since then: a fall just before a rise is not one after it."""
        for rises, since in ((True, self._rose), (False, self._fell)):
            lately = (since > time - TOGETHER) & (since >= self._turned)
            if self._up is not rises and np.count_nonzero(lately) > self._few:
                self._up, self._turned = rises, time
                if rises:
                    self._rises.append(time)
