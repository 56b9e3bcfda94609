"""The order of a tube's particles around the middle of their row."""

import numpy as np
import pytest

from live.motion.cloth.fabric import FABRICS
from live.motion.cloth.garment_catalogue import PATTERNS
from live.motion.cloth.limb_kernels import LANES, LIMB_ROWS
from live.motion.cloth.order_kernels import LEAST_AREA, keep_order
from live.motion.cloth.pattern import compile_pattern

NO_LIMBS = np.zeros((LIMB_ROWS, 1, LANES), np.float32)
SKIRT = compile_pattern(PATTERNS["skirt"], FABRICS["cotton"])


def cone(tilt=0.0):
    """The skirt as circles one below the other, on all lanes, (rows, columns, 3)."""
    pattern = SKIRT.pattern
    angle = 2.0 * np.pi * np.arange(pattern.columns) / pattern.columns
    radius = np.array(pattern.widths) * pattern.columns / (2.0 * np.pi)
    grid = np.stack(
        [
            radius[:, None] * np.sin(angle),
            np.repeat(-0.05 * np.arange(pattern.rows)[:, None], pattern.columns, 1),
            radius[:, None] * np.cos(angle),
        ],
        axis=-1,
    )
    c, s = np.cos(tilt), np.sin(tilt)
    return grid @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def kept(grid, times=1):
    flat = np.zeros((3, SKIRT.pattern.count, LANES), np.float32)
    flat[:, SKIRT.order.ravel()] = grid.reshape(-1, 3).T[:, :, None]
    before = flat.copy()
    for _ in range(times):
        keep_order(flat.reshape(3, -1), SKIRT.rings, SKIRT.areas, NO_LIMBS, 1)
    return flat[:, SKIRT.order.ravel(), 0].T.reshape(grid.shape), np.array_equal(before, flat)


def sectors(row):
    """Twice the area of each sector of a row, seen along the axis of the whole row."""
    own = row.astype(np.float64) - row.mean(axis=0)
    parts = np.cross(own, np.roll(own, -1, axis=0))
    return parts @ (parts.sum(axis=0) / np.linalg.norm(parts.sum(axis=0)))


@pytest.mark.parametrize("tilt", [0.0, 1.2, np.pi])
def test_what_is_in_order_does_not_move(tilt):
    assert kept(cone(tilt))[1]


@pytest.mark.parametrize("tilt", [0.0, 1.2])
@pytest.mark.parametrize("column", [4, 5, 19])
def test_neighbours_that_have_passed_each_other_return(tilt, column):
    """Upright or lying down, between even and odd columns and where the row closes."""
    grid, row, after = cone(tilt), 6, (column + 1) % 20
    grid[row, [column, after]] = grid[row, [after, column]]
    assert sectors(grid[row]).min() < 0.0
    out, _ = kept(grid, times=40)
    assert sectors(out[row]).min() > 0.8 * SKIRT.areas[row, LEAST_AREA] > 0.0
    assert np.array_equal(out[0], grid[0].astype(np.float32))


def test_waistband_does_not_move_even_if_it_is_crossed():
    grid = cone()
    grid[0, [3, 4]] = grid[0, [4, 3]]
    assert np.array_equal(kept(grid)[0][0], grid[0].astype(np.float32))
