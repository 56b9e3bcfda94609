"""Tests of forward kinematics: the rest pose, a raised arm, and constant bone lengths."""

import numpy as np
from scipy.spatial.transform import Rotation

from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import JOINT_COUNT, SKELETON


def test_identity_rotations_give_rest_pose() -> None:
    rotation = np.zeros((1, JOINT_COUNT, 4))
    rotation[..., 0] = 1.0
    position, _ = forward_kinematics(SKELETON.offsets[:1].astype(float), rotation)
    assert np.allclose(position[0], SKELETON.rest_positions(), atol=1e-6)


def test_lifted_arm_points_up() -> None:
    rotation = np.zeros((1, JOINT_COUNT, 4))
    rotation[..., 0] = 1.0
    rotation[0, SKELETON.index("leftUpperArm")] = np.array((1.0, 0.0, 0.0, 1.0)) / np.sqrt(2.0)  # a quarter about z
    position, world = forward_kinematics(SKELETON.offsets[:1].astype(float), rotation)
    arm = position[0, SKELETON.index("leftHand")] - position[0, SKELETON.index("leftUpperArm")]
    assert np.allclose(arm, (0.0, 0.51, 0.0), atol=1e-6)
    assert np.allclose(world[0, SKELETON.index("leftHand")], rotation[0, SKELETON.index("leftUpperArm")])


def test_bones_keep_their_lengths() -> None:
    random = np.random.default_rng(3)
    rotation = Rotation.random(20 * JOINT_COUNT, random).as_quat()[:, [3, 0, 1, 2]].reshape(20, JOINT_COUNT, 4)
    position, _ = forward_kinematics(random.normal(size=(20, 3)), rotation)
    bones = np.linalg.norm(position[:, 1:] - position[:, SKELETON.parents[1:]], axis=2)
    assert np.allclose(bones, np.linalg.norm(SKELETON.offsets[1:], axis=1), atol=1e-6)
