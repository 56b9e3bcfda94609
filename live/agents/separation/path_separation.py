"""Separation of the dancers' paths through a measure, and of the places where the measures end."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.crowd.obstacles import Surroundings
from live.agents.separation.obstacle_clearance_kernels import clear_moves, clear_paths
from live.agents.separation.path_separation_kernels import (
    push_apart,
    separate_paths,
    slow_down_near,
)
from live.agents.separation.separation_kernels import NEIGHBOUR_RANGE, cell_count, separate_positions
from live.base.arrays import Float32, Float64


class PlaceSeparation:
    """Keeps places apart, so that the next measures of two dancers do not end on one spot."""

    ROUNDS = 6

    def __init__(self, count: int, gap: float, *, half_width: float, half_depth: float, seed: int) -> None:
        """`gap` [m]: minimum distance of two of `count` dancers; half the stage's sizes [m]."""
        self._gap, self._seed = gap, seed
        self._half_width, self._half_depth = half_width, half_depth
        cells = cell_count(2.0 * half_width, NEIGHBOUR_RANGE) * cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
        self._cell_start = np.zeros(cells + 1, np.int32)
        self._order = np.zeros(count, np.int32)

    def resize(self, fresh: "PlaceSeparation") -> None:
        """Take the stage's size from `fresh`, which was made for the same dancers."""
        self._half_width, self._half_depth = fresh._half_width, fresh._half_depth
        self._cell_start = fresh._cell_start

    def __call__(self, position: Float32, anchor: Float32, most: float) -> None:
        """Move `position` (A, 2) apart in place, each at most `most` [m] from its `anchor` (A, 2)."""
        separate_positions(
            position,
            anchor,
            self._gap,
            most,
            self._half_width,
            self._half_depth,
            self.ROUNDS,
            self._seed,
            self._cell_start,
            self._order,
        )


MOMENTS: Final = 17
"""Moments of a measure at which paths are sampled, the first at its beginning, the last at its end."""
MARGIN: Final = 0.0
"""Minimum gap between bodies on their paths [m]. Planned paths may touch: each further centimetre sends dancers of a
dense group away from where they should be. Pushes (`ContactResolver`) keep the gap that moments and blends need."""


class Paths:
    """The uncorrected paths of A dancers through one measure."""

    def __init__(self, count: int) -> None:
        self.path: Float32 = np.zeros((count, MOMENTS, 2), np.float32)
        """Hips [m], shape (A, MOMENTS, 2)."""
        self.share: Float32 = np.zeros((count, MOMENTS), np.float32)
        """Share of a correction applied at each moment, shape (A, MOMENTS)."""


class PathSeparation:
    """Keeps A dancers apart on their paths through a measure."""

    def __init__(
        self,
        radius: Float32,
        responsibility: Float32,
        *,
        gap_at_end: float,
        half_width: float,
        half_depth: float,
        seed: int,
        surroundings: Surroundings | None = None,
    ) -> None:
        """`radius` (A,) [m] of bodies, `responsibility` (A,): 0 for dancers to whom others give way.

        `gap_at_end` [m]: minimum distance of two dancers of usual size at the end of a measure; half the stage's sizes
        [m]; `surroundings`: walls and obstacles that corrections must avoid.
        """
        count = len(radius)
        self._radius, self._responsibility = radius, responsibility
        self._margin_at_end = max(gap_at_end - 2.0 * float(np.median(radius)), MARGIN)
        self._stage = half_width, half_depth, seed
        self._surroundings = surroundings
        cells = cell_count(2.0 * half_width, NEIGHBOUR_RANGE) * cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
        self._cells = np.zeros(cells + 1, np.int32), np.zeros(count, np.int32)
        self._middle, self._extent = np.zeros((count, 2), np.float32), np.zeros(count, np.float32)
        self._yields = responsibility.copy()
        self._speed, self._moved = np.zeros((count, 2)), np.zeros((count, 2))
        self.shortfall: Float32 = np.full(count, -1.0, np.float32)
        """Largest missing distance of each dancer [m] in the last round of `part`; below 0: none, shape (A,)."""

    def resize(self, fresh: "PathSeparation") -> None:
        """Take the stage's size from `fresh`, which was made for the same dancers."""
        self._stage, self._cells = fresh._stage, fresh._cells

    def set_present(self, state: npt.NDArray[np.int8], present_state: int) -> None:
        """Restrict separation to the dancers whose `state` (A,) is `present_state`."""
        self._yields[:] = np.where(state == present_state, self._responsibility, np.float32(-1.0))

    def separate(
        self, paths: Paths, goal: Float64, aim_origin: Float64, max_correction: Float64, *, place: float = 0.0
    ) -> None:
        """Do one round: change `goal` (A, 2) [m], each by at most `max_correction` (A,) [m], to separate the paths.

        Only the part of the measure from `place` (0 to 1) on counts.
        """
        first = min(int(place * (MOMENTS - 1)), MOMENTS - 2)
        separate_paths(
            paths.path, paths.share, goal, aim_origin, first, self._radius, self._yields, max_correction, MARGIN,
            self._margin_at_end, *self._stage, self._middle, self._extent, *self._cells[:2], self.shortfall,
        )  # fmt: skip
        things = self._surroundings
        if things is not None and things.wall_count + things.obstacle_count:
            clear_paths(
                paths.path, paths.share, goal, aim_origin, first, self._radius, self._yields, max_correction,
                things.walls, things.wall_count, things.obstacles, things.obstacle_count,
            )  # fmt: skip

    def push_apart(self, now: Float32, soon: Float32, *, margin: float, stiffness: float, dt: float) -> Float64 | None:
        """Return this tick's emergency moves (A, 2) [m] of dancers who touch or soon will, None if there are none.

        `now` (A, 2) and `soon`, (A, 2) or at several moments (K, A, 2) [m], are their places; see `push_apart`.
        """
        pushed = push_apart(
            now, soon.reshape(-1, *now.shape), self._radius, self._yields, margin, stiffness, dt, *self._stage,
            *self._cells, self._speed, self._moved,
        )  # fmt: skip
        if pushed:
            self.slow_down(now, self._speed, self._moved, margin=margin)
        things = self._surroundings
        if pushed and things is not None and things.wall_count + things.obstacle_count:
            clear_moves(
                now, self._moved, self._radius, things.walls, things.wall_count, things.obstacles, things.obstacle_count
            )
        return self._moved if pushed else None

    def slow_down(self, now: Float32, speed: Float64, moved: Float64, *, margin: float) -> None:
        """Take from `speed` and `moved` (A, 2), in place, what leads two dancers nearer than `margin` [m] together.

        Called after `push_apart`, which sorts the dancers at `now` (A, 2) [m].
        """
        slow_down_near(now, self._radius, self._yields, margin, *self._stage[:2], *self._cells, speed, moved)
