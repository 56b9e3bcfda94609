"""Kernels that predict collisions of all dancers from their positions and clips, and rate escape paths."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.separation.separation_kernels import cell_count, cell_of, sort_into_cells
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

MAX_RANGE = 2.5
"""Dancers farther away than this [m] cannot be met within the look-ahead time."""
_CELL = MAX_RANGE + 0.01
"""Size of the cells in which neighbours are looked for [m]: whoever is in range is in the same cell or beside it."""


@kernel("f8(f8[:,:,::1], i8, f8[:,:,::1], i8, f8, i8)")
def first_collision(ways: Float64, one: int, others: Float64, other: int, gap: float, last: int) -> float:
    """Return the first moment of 1 to `last` at which two are nearer than `gap` [m] and still approaching; -1 if none.

    `ways` and `others` (K, A, 2) [m]: positions at each moment, the first one now.
    """
    x, z = ways[0, one, 0] - others[0, other, 0], ways[0, one, 1] - others[0, other, 1]
    nearest = math.sqrt(x * x + z * z)
    for k in range(1, last + 1):
        x, z = ways[k, one, 0] - others[k, other, 0], ways[k, one, 1] - others[k, other, 1]
        distance = math.sqrt(x * x + z * z)
        if distance < gap and distance < nearest - 0.01:
            return float(k)
        nearest = min(nearest, distance)
    return -1.0


@kernel("f8(f8[:,:,::1], i8, f8, f8)")
def _advance_towards(ways: Float64, one: int, x: float, z: float) -> float:
    """Return how far `one` moves until the first moment in the direction (x, z) [m]."""
    size = max(math.sqrt(x * x + z * z), 1e-9)
    way: float = ((ways[1, one, 0] - ways[0, one, 0]) * x + (ways[1, one, 1] - ways[0, one, 1]) * z) / size
    return way


@kernel("void(f8[:,:,::1], f4[::1], f4[::1], b1[::1], f8, f8, f8[:,:,::1], f4[::1], i8, f8, f8[::1])")
def predict_collisions(
    ways: Float64, radius: Float32, yields: Float32, present: Bool, half_width: float, half_depth: float,
    things: Float64, thing_radius: Float32, thing_count: int, slack: float, out: Float64,
) -> None:  # fmt: skip
    """Find the dancers who must evade: the moment of collision into `out` (A,); 0 for all others.

    `ways` (K, A, 2) [m] as in first_collision; `radius` (A,) [m]; `yields` (A,) 0 for dancers with the right of way;
    `present` (A,): on the stage, whose half sizes are given [m]; `things` (K, M, 2) [m] and `thing_radius` (M,): the
    first `thing_count` other objects. Two meet when they are `slack` [m] nearer than the sum of their radii: dancers at
    the first moment, things at any. Of two dancers, the one who moves farther towards the other evades.
    """
    columns, rows = cell_count(2.0 * half_width, _CELL), cell_count(2.0 * half_depth, _CELL)
    now, order = np.empty((out.shape[0], 2), np.float32), np.empty(out.shape[0], np.int32)
    cell_start = np.empty(columns * rows + 1, np.int32)
    for i in range(out.shape[0]):
        out[i] = 0.0
        now[i, 0], now[i, 1] = ways[0, i, 0], ways[0, i, 1]
    sort_into_cells(now, half_width, half_depth, _CELL, cell_start, order)
    for i in range(out.shape[0]):
        if not present[i]:
            continue
        for m in range(thing_count):
            k = first_collision(ways, i, things, m, radius[i] + thing_radius[m] - slack, ways.shape[0] - 1)
            if k > 0.0 and (out[i] == 0.0 or k < out[i]):
                out[i] = k
        home = cell_of(now[i, 0], now[i, 1], half_width, half_depth, _CELL, columns, rows)
        for row in range(max(home // columns - 1, 0), min(home // columns + 2, rows)):
            first = row * columns + max(home % columns - 1, 0)
            last = row * columns + min(home % columns + 1, columns - 1)
            for n in range(cell_start[first], cell_start[last + 1]):
                j = order[n]
                x, z = ways[0, j, 0] - ways[0, i, 0], ways[0, j, 1] - ways[0, i, 1]
                if x < 0.0 or (x == 0.0 and j <= i):  # the left one of a pair looks at the other
                    continue
                if not present[j] or x > MAX_RANGE or abs(z) > MAX_RANGE:
                    continue
                k = first_collision(ways, i, ways, j, radius[i] + radius[j] - slack, 1)
                if k < 0.0:
                    continue
                own = _advance_towards(ways, i, x, z) * yields[i]
                other = _advance_towards(ways, j, -x, -z) * yields[j]
                who = i if own > other else j
                if out[who] == 0.0 or k < out[who]:
                    out[who] = k


@kernel("void(f8[::1], f8[:,:,::1], f8[:,:,::1], f8)")
def escape_margins(out: Float64, ways: Float64, others: Float64, margin: float) -> None:
    """Compute how much `ways` (W, C, 2) lack of `margin` to the `others` (M, W, 3), x, z, nearest distance [m].

    The result `out` (C,) is the worst of the W moments plus their mean.
    """
    moments = ways.shape[0]
    for c in range(ways.shape[1]):
        worst, total = 0.0, 0.0
        for w in range(moments):
            lack = 0.0
            for m in range(others.shape[0]):
                away = math.hypot(ways[w, c, 0] - others[m, w, 0], ways[w, c, 1] - others[m, w, 1]) - others[m, w, 2]
                lack = max(lack, margin - away)
            worst = max(worst, lack)
            total += lack
        out[c] = worst + total / moments
