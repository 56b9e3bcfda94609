"""The avoidance rule of the thesis with two distances (T108)."""

import numpy as np
import pytest

from live.agents.crowd.reynolds_avoidance_kernels import dodge
from tests.agents.crowd.made_crowd import CrowdHarness, smallest_distance


def test_receding_clear_or_distant_neighbors_cause_no_dodge():
    assert dodge(1.0, 0.0, 1.0, 0.0, 0.7) == (0.0, 0.0)
    assert dodge(2.0, 0.0, -1.0, 1.0, 0.7) == (0.0, 0.0)
    assert dodge(5.0, 0.0, -1.0, 0.0, 0.7) == (0.0, 0.0)


def test_pair_dodges_in_opposite_directions():
    mine, hers = dodge(1.5, 0.2, -1.0, 0.0, 0.7), dodge(-1.5, -0.2, 1.0, 0.0, 0.7)
    assert mine == pytest.approx((0.0, 1.0 - 1.5 / 2.0))
    assert hers == pytest.approx((-mine[0], -mine[1]))


def test_agent_closer_than_d_s_slows_down():
    # an agent walks up to a standing one; at d_s = 1 m it is limited to 40 % of its top speed
    crowd = CrowdHarness([[0, 0], [3, 0]], avoidance="thesis", d_s=1.0, d_f=2.0)
    crowd.wants.velocity[0] = (1.8, 0.0)
    speeds = []
    crowd.run(
        3.0, lambda state: speeds.append((np.hypot(*(state.position[1] - state.position[0])), state.velocity[0, 0]))
    )
    far = [speed for gap, speed in speeds if gap > 1.9]
    near = [speed for gap, speed in speeds[-10:] if gap < 0.9]
    assert max(far) > 1.5
    assert all(speed < 0.9 for speed in near)


def test_head_on_agents_pass_without_contact():
    crowd = CrowdHarness([[-4, 0], [4, 0]], [[4, 0], [-4, 0]], avoidance="thesis")
    track = crowd.run(12.0)
    assert np.abs(track[-1] - crowd.goal).max() < 0.3
    assert smallest_distance(track) > 0.495
