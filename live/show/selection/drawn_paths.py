"""Paths drawn live, point by point, while dancers walk along them (H019)."""

from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64

Place = tuple[float, float]

MOST_POINTS: Final = 512
"""Most points that are kept; of a longer path the oldest are dropped."""
REACHED: Final = 0.4
"""Distance at which a point counts as reached, if another follows [m]: corners are cut by less than that."""
ARRIVED: Final = 0.15
"""Distance at which the last point counts as reached [m]."""
WAIT_BEATS: Final = 8.0
"""Beats that dancers wait at the last point before they leave the path."""


class DrawnPath:
    """One path, and the progress of its dancers along it. Each keeps the initial offset from their middle."""

    def __init__(self, rows: list[int], place: Float32) -> None:
        """The dancers `rows` walk along it; `place` (A, 2) [m] are the present positions."""
        self.rows = rows
        self._points: list[Place] = []
        self._gone = 0  # number of dropped points
        self._next = dict.fromkeys(rows, 0)
        middle = place[rows].astype(np.float64).mean(axis=0)
        self._offsets = {row: place[row] - middle for row in rows}
        self._waited = 0.0

    def add(self, point: Place) -> None:
        """Append `point` [m]."""
        self._points.append(point)
        self._waited = 0.0
        if len(self._points) > MOST_POINTS:
            del self._points[0]
            self._gone += 1

    def tick(self, place: Float32, seeks: Bool, goal: Float64, beats: float) -> bool:
        """Advance by `beats`: write the goals of the path's dancers to `goal` (A, 2) [m] and mark them in `seeks` (A,).

        `place` (A, 2) [m] are the present positions. Returns False once all have arrived and waited.
        """
        if not self._points:
            return True
        here = True
        for row in self.rows:
            at = max(self._next[row] - self._gone, 0)
            wanted = self._points[at] + self._offsets[row]
            while at < len(self._points) - 1 and np.hypot(*(wanted - place[row])) < REACHED:
                at += 1
                wanted = self._points[at] + self._offsets[row]
            self._next[row] = at + self._gone
            seeks[row], goal[row] = True, wanted
            here &= at == len(self._points) - 1 and bool(np.hypot(*(wanted - place[row])) < ARRIVED)
        self._waited = self._waited + beats if here else 0.0
        return self._waited < WAIT_BEATS
