"""A cut takes footstep plans away: feet go on from where the plans had them, and are not thrown."""

import numpy as np

from live.clock.ticks import TICK
from live.motion.pose.foot_lock_kernels import HELD, SHIFT_X, SHIFT_Z
from live.motion.pose.gather_kernels import shift_feet
from tests.show.made_show import made_show

OFFSET = 0.07
"""How far the plans have all feet from their clips, along z [m]."""


def shifts_after_release(contact):
    """Shifts (T, 9, 2, 2) [m] of feet that stood with a plan, in the ticks after a cut, `contact` or not."""
    show = made_show()
    for tick in range(100):
        show.tick((tick + 1) * TICK)
    dancers, everybody = show.dancers, np.arange(9, dtype=np.int32)
    position = dancers._legs.position.copy()
    planned, offset = position.copy(), np.zeros((9, 2, 3), np.float32)
    offset[..., 1] = OFFSET
    shift_feet(planned, offset)
    dancers.lock.state[:] = 0.0
    nobody, held = np.zeros((9, 2), np.bool_), np.ones((9, 2), np.bool_)
    for _ in range(20):
        dancers.lock.tick(planned, held, TICK, nobody)
    assert (dancers.lock.state[:, :, HELD] == 1.0).all()
    dancers._foot_offset[:] = offset
    dancers.release_planned_feet(everybody)
    found = []
    for _ in range(30):
        dancers.lock.tick(position, held if contact else nobody, TICK, nobody)
        found.append(dancers.lock.state[:, :, SHIFT_X : SHIFT_Z + 1].copy())
    return np.array(found)


def test_released_feet_return_without_a_throw():
    shift = shifts_after_release(False)
    assert np.abs(shift[0, ..., 1] - OFFSET).max() < 0.015
    assert shift[..., 1].max() < OFFSET + 0.002
    assert np.abs(shift[-1]).max() < 0.03


def test_standing_feet_stay():
    shift = shifts_after_release(True)
    np.testing.assert_allclose(shift[..., 1], OFFSET, atol=2e-3)
    np.testing.assert_allclose(shift[..., 0], 0.0, atol=2e-3)
