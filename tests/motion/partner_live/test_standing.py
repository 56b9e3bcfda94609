"""Feet that stand stay where they stand, though who stands on them is moved; nobody else is touched."""

import numpy as np

from live.clock.ticks import TICK
from live.motion.partner_live.stage_partner import FollowerFootLock
from live.motion.skeleton import JOINT_COUNT, SKELETON

FEET = [SKELETON.index("leftFoot"), SKELETON.index("rightFoot")]


def stood(place: float) -> tuple[np.ndarray, np.ndarray]:
    """Three dancers with their knees a little bent, all `place` [m] to the right."""
    rotation = np.zeros((3, JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    position = np.tile(SKELETON.rest_positions(), (3, 1, 1))
    position[..., 0] += np.float32(place)
    return position, rotation


def test_who_is_moved_over_a_standing_foot_bends_her_legs() -> None:
    standing, rows = FollowerFootLock(3), np.array([1], np.int32)
    seen, knees = [], []
    for tick in range(1, 40):
        position, rotation = stood(0.2 * tick * TICK)
        standing.tick(rows, position[rows], np.array([[True, False]]), TICK)
        before = position.copy()
        standing.apply(rows, position, rotation, 0.0)
        assert np.array_equal(position[[0, 2]], before[[0, 2]])
        seen.append(position[1, FEET, 0])
        knees.append(position[1, 0, 0])
    feet = np.array(seen)
    assert np.abs(np.diff(feet[1:, 0])).max() < 0.1 * np.diff(feet[1:, 1]).min()  # one stands, one goes along
    assert np.allclose(np.diff(knees), 0.2 * TICK, atol=1e-4)
    none = np.zeros(0, np.int32)
    for _ in range(64):
        position, rotation = stood(0.2 * 40 * TICK)
        standing.tick(none, np.zeros((0, JOINT_COUNT, 3), np.float32), np.zeros((0, 2), np.bool_), TICK)
    position, rotation = stood(0.0)
    before = position.copy()
    standing.apply(rows, position, rotation, 0.0)
    assert np.abs(position - before).max() < 0.01  # let go, her feet are where her dance has them
