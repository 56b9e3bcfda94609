"""Tests of answer blending kernels against numpy, at both ends and between."""

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.partner_live.stage_partner_kernels import (
    blend_answers,
    heading_difference,
    local_to_world,
    world_to_local,
)
from live.motion.skeleton import JOINT_COUNT, SKELETON

OFFSETS = np.array(SKELETON.offsets, np.float32)
PARENTS = np.array(SKELETON.parents, np.int32)


def random_poses(seed: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    chance = np.random.default_rng(seed)
    root = chance.uniform(-2.0, 2.0, (count, 3))
    rotation = quaternion.from_rotation_vector(chance.normal(0.0, 0.3, (count, JOINT_COUNT, 3)))
    yaw = chance.uniform(-3.0, 3.0, count)
    rotation[:, 0] = quaternion.mul(
        np.stack((np.cos(yaw / 2), 0 * yaw, np.sin(yaw / 2), 0 * yaw), axis=-1), rotation[:, 0]
    )
    return root, rotation


def blend_second_dancer(share: float, frames: float, turn: float = 0.0) -> tuple[np.ndarray, ...]:
    """Own poses, answers, and the blended pose of the second of two dancers."""
    root, rotation = random_poses(1, 2)
    position, world = (np.asarray(one, np.float32) for one in forward_kinematics(root, rotation))
    answer_root, answer_rotation = random_poses(2, 3)
    places, turned = forward_kinematics(answer_root, answer_rotation)
    out = position.copy(), world.copy()
    blend_answers(
        *out, np.array([1], np.int32), np.array([0], np.int32), np.array([frames]), np.array([share]),
        np.array([turn]), position[1:2, 0, ::2].astype(np.float64), answer_root[:1, ::2].copy(),
        answer_root[None].astype(np.float32), turned[None].astype(np.float32), OFFSETS, PARENTS,
    )  # fmt: skip
    assert np.array_equal(out[0][0], position[0])  # the other dancer is unchanged
    assert np.array_equal(out[1][0], world[0])
    return position, world, places, turned, *out


def test_full_share_shows_answer_at_own_position() -> None:
    position, _, places, turned, seen, rotation = blend_second_dancer(1.0, 0.0)
    assert np.allclose(np.abs((rotation[1] * turned[0]).sum(axis=-1)), 1.0, atol=1e-5)
    assert np.allclose(seen[1, 0, ::2], position[1, 0, ::2], atol=1e-6)
    assert np.allclose(seen[1] - seen[1, 0], places[0] - places[0, 0], atol=1e-5)
    _, _, places, turned, later, rotation = blend_second_dancer(1.0, 1.0)
    assert np.allclose(later[1, 0, ::2] - seen[1, 0, ::2], (places[2] - places[0])[0, ::2], atol=1e-5)
    assert np.isclose(later[1, 0, 1], places[2, 0, 1], atol=1e-5)


@pytest.mark.long
def test_blend_keeps_bone_lengths_and_turns_evenly() -> None:
    lengths = np.linalg.norm(OFFSETS[1:], axis=-1)
    headings = []
    for turn in (3.0, -3.0):
        for share in np.linspace(0.0, 1.0, 41):
            seen, rotation = blend_second_dancer(float(share), 0.0, turn)[4:]
            assert np.allclose(np.linalg.norm(seen[1, 1:] - seen[1, PARENTS[1:]], axis=-1), lengths, atol=1e-5)
            ahead = quaternion.rotate(rotation[1, 0], np.array((0.0, 0.0, 1.0)))
            headings.append(np.arctan2(ahead[0], ahead[2]))
    one, other = np.unwrap(headings[:41]), np.unwrap(headings[41:])
    assert np.abs(np.diff(one)).max() < 2.0 * abs(one[-1] - one[0]) / 40 + 0.03  # evenly, not all at once
    assert np.isclose(
        abs(one[-1] - one[0]) + abs(other[-1] - other[0]), 2.0 * np.pi, atol=1e-3
    )  # both directions of rotation


def test_zero_share_keeps_own_pose() -> None:
    position, world, _, _, seen, rotation = blend_second_dancer(0.0, 0.4)
    assert np.array_equal(seen, position)
    assert np.array_equal(rotation, world)


def test_joint_rotations_match_forward_kinematics() -> None:
    root, rotation = random_poses(3, 4)
    out = np.zeros((4, JOINT_COUNT, 4), np.float32)
    local_to_world(rotation, PARENTS, out)
    assert np.allclose(out, forward_kinematics(root, rotation)[1], atol=1e-5)
    back = np.empty_like(out)
    world_to_local(out, PARENTS, back)
    assert np.allclose(np.abs((back * rotation).sum(axis=-1)), 1.0, atol=1e-5)
    for before in (-6.0, 0.0, 6.0):
        turn = heading_difference(out[0, 0], out[1, 0], before)
        assert abs(turn - before) <= np.pi + 1e-6
        assert np.isclose(np.cos(turn), np.cos(heading_difference(out[0, 0], out[1, 0], 0.0)), atol=1e-6)
