"""Parting: the ends of the dancers' next measures must not fall onto one spot."""

import numpy as np
import numpy.typing as npt

from live.agents.separation.separation_kernels import NEIGHBOUR_RANGE, cell_count, part_positions

Float32 = npt.NDArray[np.float32]


class Parting:
    """Keeps places apart from each other: the ends of the dancers' next measures must not fall onto one spot."""

    ROUNDS = 6

    def __init__(self, count: int, gap: float, *, half_width: float, half_depth: float, seed: int) -> None:
        """`gap` [m]: how far apart two of `count` dancers shall be; half the stage's sizes [m]."""
        self._gap, self._seed = gap, seed
        self._half_width, self._half_depth = half_width, half_depth
        cells = cell_count(2.0 * half_width, NEIGHBOUR_RANGE) * cell_count(2.0 * half_depth, NEIGHBOUR_RANGE)
        self._cell_start = np.zeros(cells + 1, np.int32)
        self._order = np.zeros(count, np.int32)

    def __call__(self, position: Float32, anchor: Float32, most: float) -> None:
        """Move `position` (A, 2) apart in place, nobody farther than `most` [m] from its `anchor` (A, 2)."""
        part_positions(
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
