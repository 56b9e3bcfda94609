"""Drawn ways: paths that are drawn while they are walked, point by point, and who walks along them (H019)."""

from typing import Final

import numpy as np
import numpy.typing as npt

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]
Place = tuple[float, float]

MOST_POINTS: Final = 512
"""Points that wait at most; of a longer way the oldest are forgotten."""
REACHED: Final = 0.4
"""A point with another one after it is reached from so far [m]: who walks cuts corners by less than that."""
ARRIVED: Final = 0.15
"""The last point is reached from so far [m]."""
WAITS: Final = 8.0
"""Who has arrived waits so many beats for the next point, then goes wherever else she is asked to."""


class DrawnWay:
    """One way, and where on it some dancers are; each keeps the place that she had among them when it began."""

    def __init__(self, rows: list[int], place: Float32) -> None:
        """`rows` walk along it, who are now at `place` (A, 2) [m]."""
        self.rows = rows
        self._points: list[Place] = []
        self._gone = 0  # points that are forgotten
        self._next = dict.fromkeys(rows, 0)
        middle = place[rows].astype(np.float64).mean(axis=0)
        self._beside = {row: place[row] - middle for row in rows}
        self._waited = 0.0

    def add(self, point: Place) -> None:
        """It goes on to `point` [m]."""
        self._points.append(point)
        self._waited = 0.0
        if len(self._points) > MOST_POINTS:
            del self._points[0]
            self._gone += 1

    def tick(self, place: Float32, seeks: Bool, goal: Float64, beats: float) -> bool:
        """So many `beats` later: where everybody at `place` (A, 2) goes is written to `goal` (A, 2) where `seeks` (A,);
        False once all have arrived and waited."""
        if not self._points:
            return True
        here = True
        for row in self.rows:
            at = max(self._next[row] - self._gone, 0)
            wanted = self._points[at] + self._beside[row]
            while at < len(self._points) - 1 and np.hypot(*(wanted - place[row])) < REACHED:
                at += 1
                wanted = self._points[at] + self._beside[row]
            self._next[row] = at + self._gone
            seeks[row], goal[row] = True, wanted
            here &= at == len(self._points) - 1 and bool(np.hypot(*(wanted - place[row])) < ARRIVED)
        self._waited = self._waited + beats if here else 0.0
        return self._waited < WAITS
