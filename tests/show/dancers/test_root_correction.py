"""Tests of consecutive slices, by which neighboring rows are corrected together."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from live.clock.ticks import TICK
from live.show.dancers.root_correction import consecutive_slices
from tests.show.made_show import made_show


@given(st.sets(st.integers(0, 60)))
def test_slices_contain_each_row_exactly_once(who):
    rows = np.array(sorted(who), np.int64)
    found = consecutive_slices(rows)
    assert [n for run in found for n in range(run.start, run.stop)] == sorted(who)
    assert all(one.stop < other.start for one, other in pairwise(found))


def test_frames_between_ticks_go_on_with_a_push():
    """A push moves dancers at ticks; without this, a frame after two ticks shows twice the way of its neighbours."""
    show = made_show("[motion]\nfoot_lock = false\narm_clearance = 0\n")
    for tick in range(1, 40):
        show.tick(tick * TICK)
    later, hips = show.time + 0.5 * TICK, []
    for velocity in (0.0, 1.6):
        show.dancers.push_velocity[:] = (velocity, 0.0)
        view = show.view()
        show.fill(view, later)
        hips.append(view.joint_position[:, 0].copy())
    np.testing.assert_allclose(hips[1] - hips[0], np.tile([0.8 * TICK, 0.0, 0.0], (len(hips[0]), 1)), atol=1e-5)
    at_tick = show.view()
    show.fill(at_tick, show.time)
    show.dancers.push_velocity[:] = 0.0
    still = show.view()
    show.fill(still, show.time)
    np.testing.assert_array_equal(at_tick.joint_position, still.joint_position)
