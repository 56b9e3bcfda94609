"""The air around garments: drag across a surface, and bodies that fall faster than gravity."""

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.motion.cloth.air_kernels import face_air, follow_falls
from live.motion.cloth.fabric import FABRICS
from live.motion.cloth.garment_catalogue import PATTERNS
from live.motion.cloth.limb_kernels import LANES
from live.motion.cloth.pattern import compile_pattern
from tests.fixtures.mostly_long import mostly_long
from tests.motion.cloth.cloth_bodies import STILL, dressed, grid, posed

SKIRT = compile_pattern(PATTERNS["skirt"], FABRICS["cotton"])
ROWS, COLUMNS = SKIRT.pattern.rows, SKIRT.pattern.columns


def braked(places, speed, facing, wind=STILL):
    """The speeds of a skirt at `places` (rows, columns, 3) after the air has braked it from `speed` likewise."""
    x, v = np.zeros((2, 3, SKIRT.pattern.count, LANES), np.float32)
    for flat, values in ((x, places), (v, speed)):
        flat[:, SKIRT.order.ravel()] = values.reshape(-1, 3).T[:, :, None]
    face_air(x.reshape(3, -1), v.reshape(3, -1), SKIRT.rings, wind, np.float32(facing))
    return v[:, SKIRT.order.ravel(), 3].T.reshape(ROWS, COLUMNS, 3)


def tube(flat):
    """A tube about the vertical, or a disc that lies flat."""
    angle = 2.0 * np.pi * np.arange(COLUMNS) / COLUMNS
    out = np.zeros((ROWS, COLUMNS, 3))
    radius = (0.1 + 0.05 * np.arange(ROWS))[:, None] if flat else np.full((ROWS, 1), 0.3)
    out[..., 0], out[..., 2] = radius * np.sin(angle), radius * np.cos(angle)
    out[..., 1] = 1.0 if flat else 1.0 - 0.05 * np.arange(ROWS)[:, None]
    return out


def test_tube_that_falls_along_itself_is_not_braked():
    speed = np.zeros((ROWS, COLUMNS, 3))
    speed[..., 1] = -3.0
    assert np.abs(braked(tube(flat=False), speed, 0.1) - speed).max() < 1e-5


@pytest.mark.parametrize("down", [0.5, 4.0])
def test_disc_is_braked_by_the_square_of_its_speed_through_the_wind(down):
    """An implicit step of dv/dt = -k v |v|; the first row stays on the body."""
    speed = np.zeros((ROWS, COLUMNS, 3))
    speed[..., 1] = -down
    wind = np.array([0.0, 1.0, 0.0], np.float32)
    through = down + 1.0
    out = braked(tube(flat=True), speed, 0.1, wind)
    assert np.allclose(out[1:, :, 1], 1.0 - through / (1.0 + 0.1 * through), atol=1e-4)
    assert np.abs(out[1:, :, [0, 2]]).max() < 1e-4
    assert np.array_equal(out[0], speed[0].astype(np.float32))


def test_only_what_exceeds_gravity_is_followed():
    """Lanes whose joints fall freely, at twice gravity, are braked, and twice gravity without a past."""
    fall = np.array([-9.81, -2 * 9.81, 9.81, -2 * 9.81, 0, 0, 0, 0])
    now, last, before = np.zeros((7, 2, LANES), np.float32), np.zeros((7, 2, LANES), np.float32), np.zeros((7, LANES))
    now[1, 0], last[1, 0], before[1] = (0.5 * fall * (t * TICK) ** 2 for t in (2, 1, 0))
    fresh, v = np.zeros(LANES, np.uint8), np.zeros((3, 4, LANES), np.float32)
    fresh[3] = 1
    follow_falls(v, now, last, before.astype(np.float32), fresh, np.float32(9.81), np.float32(0.5), np.float32(TICK))
    assert np.allclose(v[1], [0.0, -0.5 * 9.81 * TICK, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], atol=2e-4)
    assert not v[[0, 2]].any()


@mostly_long("fabric", ["silk", "cotton", "wool", "tulle"], quick=[])
def test_skirt_does_not_turn_over_in_jumps_at_180_bpm(fabric):
    """Up and down by half a metre in two beats, at up to 2.2 times gravity."""
    batch, high = dressed("skirt", fabric=fabric), []
    for tick in range(256):
        beat = tick * TICK * 3.0
        position, rotation = posed(lift=0.25 * np.sin(np.pi * beat) - 0.05)
        batch.tick(position, rotation, STILL, 3, TICK)
        places = grid(batch, position, rotation)[0]
        high.append(float(places[-1, :, 1].mean() - places[0, :, 1].mean()))
    assert max(high[64:]) < -0.25
