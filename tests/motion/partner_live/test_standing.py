"""Tests of the follower foot lock: standing feet stay while the body moves, and other dancers are unchanged."""

import numpy as np

from live.clock.ticks import TICK
from live.motion.partner_live.stage_partner import FollowerFootLock
from live.motion.skeleton import JOINT_COUNT, SKELETON

FEET = [SKELETON.index("leftFoot"), SKELETON.index("rightFoot")]


def standing_poses(place: float) -> tuple[np.ndarray, np.ndarray]:
    """Poses of three standing dancers, all `place` [m] to the right."""
    rotation = np.zeros((3, JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    position = np.tile(SKELETON.rest_positions(), (3, 1, 1))
    position[..., 0] += np.float32(place)
    return position, rotation


def test_standing_foot_stays_while_follower_moves() -> None:
    standing, rows = FollowerFootLock(3), np.array([1], np.int32)
    seen, knees = [], []
    for tick in range(1, 40):
        position, rotation = standing_poses(0.2 * tick * TICK)
        standing.tick(rows, position[rows], np.array([[True, False]]), TICK)
        before = position.copy()
        standing.apply(rows, position, rotation, 0.0)
        assert np.array_equal(position[[0, 2]], before[[0, 2]])
        seen.append(position[1, FEET, 0])
        knees.append(position[1, 0, 0])
    feet = np.array(seen)
    assert (
        np.abs(np.diff(feet[1:, 0])).max() < 0.1 * np.diff(feet[1:, 1]).min()
    )  # the left foot stands, the right one moves
    assert np.allclose(np.diff(knees), 0.2 * TICK, atol=1e-4)
    none = np.zeros(0, np.int32)
    for _ in range(64):
        position, rotation = standing_poses(0.2 * 40 * TICK)
        standing.tick(none, np.zeros((0, JOINT_COUNT, 3), np.float32), np.zeros((0, 2), np.bool_), TICK)
    position, rotation = standing_poses(0.0)
    before = position.copy()
    standing.apply(rows, position, rotation, 0.0)
    assert np.abs(position - before).max() < 0.01  # after release the feet are at their original positions
