"""MovedPoints: points in an output's window that are moved by mouse and keys, with everything undone again."""

from abc import ABC, abstractmethod
from typing import Final, Generic, TypeVar

import numpy as np

from live.render.outputs.output import Point

REACH: Final = 0.06
"""A point is taken hold of from so far away, as a share of the window's width."""
KEPT: Final = 200
"""Steps that can be undone."""

State = TypeVar("State")
"""What is changed by moving, as a value."""


class MovedPoints(ABC, Generic[State]):
    """Places are shares of the window. A move that cannot be is left out, and `problem` says why."""

    def __init__(self) -> None:
        self.chosen = 0
        """The point that keys move."""
        self.is_changed = False
        """Whether anything was moved that nobody has kept yet."""
        self.problem = ""
        """Why the last move was left out; empty if it was not."""
        self._before: list[State] = []
        self._held = False

    @property
    @abstractmethod
    def points(self) -> list[Point]:
        """The points that can be moved, in the window."""

    @abstractmethod
    def _move(self, place: Point) -> bool:
        """The chosen point goes there; False, and `problem`, if it cannot."""

    @abstractmethod
    def _now(self) -> State:
        """All as it is."""

    @abstractmethod
    def _restore(self, state: State) -> None:
        """All as it was."""

    def next(self, step: int = 1) -> None:
        """Choose the next point, or the one before."""
        self.chosen = (self.chosen + step) % len(self.points)

    def take_hold(self, place: Point, aspect: float) -> bool:
        """Choose the point at a place of the window, of that width by its height; False if there is none."""
        far = np.array(self.points) - place
        distance = np.hypot(far[:, 0], far[:, 1] / aspect)
        nearest = int(distance.argmin())
        if distance[nearest] > REACH:
            return False
        self.chosen, self._held = nearest, True
        self._keep()
        return True

    def let_go(self) -> None:
        """The point that was held stays where it is."""
        self._held = False

    def pull(self, place: Point) -> None:
        """The point that is held goes there; nothing if none is."""
        if self._held:
            self._move(place)

    def nudge(self, x: float, y: float) -> None:
        """The chosen point goes so far [shares of the window]."""
        self._keep()
        at = self.points[self.chosen]
        if not self._move((at[0] + x, at[1] + y)):
            self._before.pop()

    def undo(self) -> None:
        """As it was before the last move."""
        if self._before:
            self._restore(self._before.pop())
            self.is_changed, self.problem = True, ""

    def _keep(self) -> None:
        self.is_changed = True
        self._before.append(self._now())
        del self._before[:-KEPT]
