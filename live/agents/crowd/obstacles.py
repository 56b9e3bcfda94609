"""Surroundings: walls, and round obstacles that may move (set items, real dancers who are tracked) (T082, T107)."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.crowd.contact_kernels import CAPACITY

Float32 = npt.NDArray[np.float32]


class _Rows:
    """Named rows of numbers, the first `count[0]` in use; nothing is allocated while they come and go."""

    def __init__(self, rows: Float32, count: Float32) -> None:
        self.rows, self._count = rows, count
        self.names: list[str] = []
        self._place: dict[str, int] = {}

    def put(self, name: str, values: tuple[float, ...]) -> bool:
        if not all(math.isfinite(value) and abs(value) < 1e4 for value in values):
            return False
        place = self._place.get(name)
        if place is None:
            if len(self.names) == CAPACITY:
                return False
            place = self._place[name] = len(self.names)
            self.names.append(name)
            self._count[0] = len(self.names)
        self.rows[place] = values
        return True

    def remove(self, name: str) -> bool:
        place = self._place.pop(name, None)
        if place is None:
            return False
        last = self.names.pop()
        self._count[0] = len(self.names)
        if place < len(self.names):  # the last one moves into the gap
            self.names[place] = last
            self._place[last] = place
            self.rows[place] = self.rows[len(self.names)]
        return True


class Surroundings:
    """What stands or moves on the stage besides the agents; changed at any time, seen at the next tick.

    What cannot be taken (no place left, a number that is none) is counted in `refused`, never raised: it may come over
    the network.
    """

    def __init__(self) -> None:
        self.flat: Float32 = np.zeros(9 * CAPACITY + 2, np.float32)
        """All that the kernels see: rows of walls, rows of obstacles, the numbers of both."""
        walls, obstacles = self.flat[: 4 * CAPACITY], self.flat[4 * CAPACITY : 9 * CAPACITY]
        self._walls = _Rows(walls.reshape(CAPACITY, 4), self.flat[9 * CAPACITY :])
        self._obstacles = _Rows(obstacles.reshape(CAPACITY, 5), self.flat[9 * CAPACITY + 1 :])
        self.refused = 0
        """How many walls and obstacles were not taken."""

    def put_wall(self, name: str, x1: float, z1: float, x2: float, z2: float) -> bool:
        """Put up a wall from (x1, z1) to (x2, z2) [m], or move the one of this name; False: refused."""
        return self._counted(self._walls.put(name, (x1, z1, x2, z2)))

    def put_obstacle(self, name: str, x: float, z: float, radius: float, vx: float = 0.0, vz: float = 0.0) -> bool:
        """Put a round obstacle of `radius` [m] at (x, z) [m] that moves at (vx, vz) [m/s], or change the one so named.

        It is where it was put last: whoever tracks it puts it again with every measurement. False: refused.
        """
        return self._counted(radius > 0.0 and self._obstacles.put(name, (x, z, radius, vx, vz)))

    def remove(self, name: str) -> bool:
        """Take away the wall and the obstacle of this name; False: there is none."""
        wall = self._walls.remove(name)
        return self._obstacles.remove(name) or wall

    def _counted(self, taken: bool) -> bool:
        self.refused += not taken
        return taken

    @property
    def wall_names(self) -> tuple[str, ...]:
        """Names of the walls, in the order of their rows."""
        return tuple(self._walls.names)

    @property
    def obstacle_names(self) -> tuple[str, ...]:
        """Names of the obstacles, in the order of their rows."""
        return tuple(self._obstacles.names)

    @property
    def walls(self) -> Float32:
        """x1, z1, x2, z2 [m] of each wall, shape (64, 4); the first `wall_count` are in use."""
        return self._walls.rows

    @property
    def wall_count(self) -> int:
        """How many walls there are."""
        return len(self._walls.names)

    @property
    def obstacles(self) -> Float32:
        """x, z, radius [m], vx, vz [m/s] of each obstacle, shape (64, 5); the first `obstacle_count` are in use."""
        return self._obstacles.rows

    @property
    def obstacle_count(self) -> int:
        """How many obstacles there are."""
        return len(self._obstacles.names)
