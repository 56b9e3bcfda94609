"""Walls, and round obstacles that may move (set items, tracked real dancers) (T082, T107)."""

import math

import numpy as np

from live.agents.crowd.contact_kernels import CAPACITY
from live.agents.crowd.passage_kernels import PASSAGE_COLUMNS, PASSAGES, find_passages
from live.base.arrays import Float32


class _Rows:
    """Named rows of numbers, the first `count[0]` in use; adding and removing rows allocates nothing."""

    def __init__(self, rows: Float32, count: Float32) -> None:
        self.rows, self._count = rows, count
        self.names: list[str] = []
        self._place: dict[str, int] = {}

    def set(self, name: str, values: tuple[float, ...]) -> bool:
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
        if place < len(self.names):  # the last row moves into the gap
            self.names[place] = last
            self._place[last] = place
            self.rows[place] = self.rows[len(self.names)]
        return True


class Surroundings:
    """Walls and obstacles on the stage; may change at any time and take effect at the next tick.

    Entries that cannot be stored (capacity reached, invalid number) are counted in `refused_count`. No error is raised,
    since they may come from the network.
    """

    def __init__(self) -> None:
        self.flat: Float32 = np.zeros(9 * CAPACITY + 3 + PASSAGES * PASSAGE_COLUMNS, np.float32)
        """Array read by the kernels: rows of walls and of obstacles, the number of both and of the narrow passages
        between the walls, rows of passages."""
        walls, obstacles = self.flat[: 4 * CAPACITY], self.flat[4 * CAPACITY : 9 * CAPACITY]
        self._walls = _Rows(walls.reshape(CAPACITY, 4), self.flat[9 * CAPACITY :])
        self._obstacles = _Rows(obstacles.reshape(CAPACITY, 5), self.flat[9 * CAPACITY + 1 :])
        self.refused_count = 0
        """Number of walls and obstacles refused."""

    def set_wall(self, name: str, x1: float, z1: float, x2: float, z2: float) -> bool:
        """Add a wall from (x1, z1) to (x2, z2) [m], or move the wall of this name; False: refused."""
        taken = self._walls.set(name, (x1, z1, x2, z2))
        self._find_passages()
        return self._count_refused(taken)

    def set_obstacle(self, name: str, x: float, z: float, radius: float, vx: float = 0.0, vz: float = 0.0) -> bool:
        """Add a round obstacle of `radius` [m] at (x, z) [m] with velocity (vx, vz) [m/s], or update the one of this
        name.

        It stays at the given position; a tracker updates it with every measurement. False: refused.
        """
        return self._count_refused(radius > 0.0 and self._obstacles.set(name, (x, z, radius, vx, vz)))

    def remove(self, name: str) -> bool:
        """Remove the wall and the obstacle of this name; False: there is none."""
        wall = self._walls.remove(name)
        if wall:
            self._find_passages()
        return self._obstacles.remove(name) or wall

    def _find_passages(self) -> None:
        self.flat[9 * CAPACITY + 2] = find_passages(self.walls, self.wall_count, self._passage_rows)

    def _count_refused(self, taken: bool) -> bool:
        self.refused_count += not taken
        return taken

    @property
    def _passage_rows(self) -> Float32:
        return self.flat[9 * CAPACITY + 3 :].reshape(PASSAGES, PASSAGE_COLUMNS)

    @property
    def passages(self) -> Float32:
        """The narrow passages between walls, rows as in `passage_kernels`, shape (P, 6)."""
        return self._passage_rows[: int(self.flat[9 * CAPACITY + 2])]

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
        """Number of walls."""
        return len(self._walls.names)

    @property
    def obstacles(self) -> Float32:
        """x, z, radius [m], vx, vz [m/s] of each obstacle, shape (64, 5); the first `obstacle_count` are in use."""
        return self._obstacles.rows

    @property
    def obstacle_count(self) -> int:
        """Number of obstacles."""
        return len(self._obstacles.names)
