"""Crossing over (T110): every dancer changes sides once, and no dancer stays on the line."""

import numpy as np
import pytest

from live.agents.elements import crossing_kernels as kernels
from live.agents.elements.element import Element
from live.base.element_kinds import CROSSING
from tests.agents.elements.made_stage import StageHarness


def tilted_line(x, z, angle):
    """The line through (x, z) [m] at `angle` [rad] from the direction to the audience."""
    dx, dz = np.sin(angle), np.cos(angle)
    return (x - dx, z - dz), (x + dx, z + dz)


def scatter_points(count, seed, size=(12.0, 8.0), apart=0.8):
    chance = np.random.default_rng(seed)
    half = np.array(size) / 2 - 0.5
    found = [chance.uniform(-half, half)]
    while len(found) < count:
        place = chance.uniform(-half, half)
        if min(np.hypot(*(np.array(found) - place).T)) > apart:
            found.append(place)
    return np.array(found)


def signed_distance(position, points):
    (ax, az), (bx, bz) = points
    along = np.array([bx - ax, bz - az]) / np.hypot(bx - ax, bz - az)
    return (position[:, 0] - ax) * along[1] - (position[:, 1] - az) * along[0]


@pytest.mark.parametrize("line", [tilted_line(0.0, 0.0, 0.0), tilted_line(1.5, 0.5, 0.7), ((-3.0, 0.0), (3.0, 0.0))])
def test_all_dancers_cross_without_overlap(line):
    start = scatter_points(24, 3)
    stage = StageHarness(start, Element(CROSSING, line, start_beat=-9.0))
    kept = stage.run(20.0)
    assert (np.sign(signed_distance(kept[-1], line)) == -np.sign(signed_distance(start, line))).all()
    assert np.abs(signed_distance(kept[-1], line)).min() > 0.4
    pairs = np.triu_indices(24, 1)
    gaps = np.hypot(*(kept[:, pairs[0]] - kept[:, pairs[1]]).transpose(2, 0, 1))
    assert gaps.min() > 0.495
    assert np.abs(np.diff(kept[-16:], axis=0)).max() < 0.05  # the dancers stay there


def test_symmetric_crowd_ends_mirrored():
    start = scatter_points(20, 1)
    start[:, 0] = np.sign(start[:, 0]) * np.maximum(np.abs(start[:, 0]), 0.9)
    stage = StageHarness(start, Element(CROSSING, ((0.0, -1.0), (0.0, 1.0)), start_beat=-9.0))
    assert stage.run(16.0)[-1] == pytest.approx(start * [-1.0, 1.0], abs=0.35)


def test_dancer_that_crossed_stays_until_next_crossing():
    bar = Element(CROSSING, ((0.0, -1.0), (0.0, 1.0)), start_beat=-9.0)
    stage = StageHarness([[-2.0, 0.0]], bar)
    assert stage.wish(8.0)[0, 0] == pytest.approx(1.0)
    stage.state.position[0] = (2.0, 0.0)
    assert stage.wish(9.0)[0] == pytest.approx([0.0, 0.0], abs=1e-6)
    stage.field.add(Element(CROSSING, ((0.0, -1.0), (0.0, 1.0)), start_beat=9.0))
    assert stage.wish(10.0)[0, 0] == pytest.approx(-1.0)


def test_flow_is_normal_to_line_in_both_directions():
    line = tilted_line(0.0, 0.0, 0.3)
    stage = StageHarness([[-2.0, 0.3], [2.0, -0.2], [1.5, 1.0]], Element(CROSSING, line))
    normal = np.array([np.cos(0.3), -np.sin(0.3)])
    wish = stage.wish()
    side = np.sign(stage.state.position @ normal)
    assert wish == pytest.approx(-side[:, np.newaxis] * normal, abs=0.02)


def test_crossing_goals_are_separated_and_on_stage():
    stage = StageHarness(np.zeros((6, 2)), Element(CROSSING, ((4.0, -1.0), (4.0, 1.0))))
    stage.wish()
    goal = stage.field._memory[:, kernels.GOAL_X :]
    assert (goal[:, 0] >= 4.0 + 0.7).all()
    assert (np.abs(goal) <= [5.56, 3.56]).all()
    gaps = np.hypot(*(goal[:, None] - goal[None]).transpose(2, 0, 1))[np.triu_indices(6, 1)]
    assert gaps.min() > 0.7
    on_it = StageHarness([[0.0, 1.0]], Element(CROSSING, ((0.0, -1.0), (0.0, 1.0))))
    assert abs(on_it.wish()[0, 0]) > 0.5
