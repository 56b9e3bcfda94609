"""Tests of blending in captured poses: rotations take the counted direction without spinning."""

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.capture.capture_blend_kernels import blend_captured
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import JOINT_COUNT, MIRROR, SKELETON
from tests.motion.capture.made_memory import make_memory, request_row

OFFSETS, PARENTS = np.array(SKELETON.offsets), np.array(SKELETON.parents)
OTHER = np.array(MIRROR, np.int32)


def test_blend_rotates_to_captured_pose_in_counted_direction():
    root, turned, stamp = make_memory(4, 2)
    turned[1, 0] = np.cos(1.5), 0.0, np.sin(1.5), 0.0  # 3 rad
    own = np.zeros((1, JOINT_COUNT, 4))
    own[..., 0] = 1.0
    place = np.array([[5.0, 0.8, 1.0]])
    for counted, way in ((3.0, 3.0), (3.0 - 2.0 * np.pi, 3.0 - 2.0 * np.pi)):
        for share in (0.25, 0.5, 1.0):
            position, rotation = (each.astype(np.float32) for each in forward_kinematics(place, own))
            row = request_row(wanted=1.0, share=share, turned=counted)
            blend_captured(
                position,
                rotation,
                np.zeros(1, np.int64),
                row,
                root,
                turned,
                stamp,
                2,
                1.0,
                False,
                OFFSETS,
                PARENTS,
                OTHER,
            )
            np.testing.assert_allclose(position[0, 0], [5.0 - 4.0 * share, 0.8 + 0.1 * share, 1.0 - share], atol=1e-5)
            there = quaternion.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(share * way))
            assert abs(there @ rotation[0, 0]) == pytest.approx(1.0, abs=1e-5)
