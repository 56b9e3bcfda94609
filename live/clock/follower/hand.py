"""HandSource: a grid that a person made: the internal clock's tempo, or taps."""

import math
from typing import Final

from live.clock.follower.source import Lines, State
from live.clock.grid import Grid

RULE: Final = 8.0
"""Seconds after the last tap, or tempo set by hand, in which the ear is not asked."""


class HandSource:
    """Keeps its grid until it is given another one."""

    def __init__(self, name: str, grid: Grid | None = None) -> None:
        self.name = name
        self.state: State = "absent" if grid is None else "locked"
        self.confidence = 0.0 if grid is None else 1.0
        self.jumped = False
        self._grid = grid
        self.rules_until = -math.inf
        """Until then the hand's word stands over what is heard [s]."""

    @property
    def ready(self) -> bool:
        """Whether it has a grid."""
        return self._grid is not None

    def grid(self) -> Grid | None:
        """Its beats."""
        return self._grid

    def lines(self) -> Lines | None:
        """A hand says where the measures begin by other means."""
        return None

    def watch(self, now: float) -> None:
        """A hand does not go away; when its rule is over it is no longer sure."""
        if self.name == "tap" and self.ready:
            self.state = "locked" if now < self.rules_until else "following"

    def take(self, grid: Grid, now: float) -> None:
        """These are the beats, and for the next seconds nothing heard contradicts them."""
        self._grid, self.confidence = grid, 1.0
        self.state = "locked"
        self.rules_until = now + RULE

    def keep(self, grid: Grid) -> None:
        """The same beats a little elsewhere; how long they rule stays as it was."""
        self._grid = grid
