"""PassedBeats: the line through the last beats, for a tempo finer than whole frames."""

from typing import Final

import numpy as np

MOST: Final = 8
"""Beats through which the line goes."""

FEWEST: Final = 4

AGREES: Final = 0.02
"""Beats that are this much nearer or further apart now (ratio) than the line says: the tempo is changing."""


class PassedBeats:
    """Notes when beats pass; `interval` is what is kept in silence."""

    def __init__(self) -> None:
        self._time = np.zeros(MOST)
        self._count = 0
        self._frame = 0
        self._ahead = True
        self.interval = 0.0
        """Frames from beat to beat by the last beats; by the last word alone while they are few."""

    def step(self, since: float, interval: float, *, anew: bool) -> None:
        """One frame: the window of the present beat is such that the beat was `since` frames ago (negative: ahead)."""
        self._frame += 1
        if anew:
            self._count = 0
            self._ahead = since < 0.0
        elif self._ahead and since >= 0.0 and self._frame - since - float(self._time[-1]) > 0.5 * interval:
            self._time[:-1] = self._time[1:]
            self._time[-1] = self._frame - since
            self._count = min(self._count + 1, MOST)
        self._ahead = since < 0.0
        if self._count < FEWEST:
            self.interval = interval
            return
        known = self._time[MOST - self._count :]
        middle = 0.5 * (self._count - 1)
        rise = spread = 0.0
        for number in range(self._count):
            rise += (number - middle) * (float(known[number]) - float(known[0]))
            spread += (number - middle) ** 2
        slope = rise / spread
        self.interval = slope if abs(slope / interval - 1.0) < AGREES else interval
