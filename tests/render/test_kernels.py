"""Dual quaternions of the pose texture against plain matrices."""

import numpy as np

from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.kernels import pose_texels
from tests.render.poses import ARABESQUE, LUNGE, pose


def _matrix(q: np.ndarray) -> np.ndarray:
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_texels_carry_each_rest_joint_to_its_place_and_turn_around_it() -> None:
    rest = SKELETON.rest_positions()
    poses = [pose(LUNGE, (1.0, -2.0), 30.0), pose(ARABESQUE, (-3.0, 0.5), -80.0), pose(LUNGE)]
    position = np.array([one[0] for one in poses])
    rotation = np.array([one[1] for one in poses])
    rows = 2  # three dancers in two rows: the third starts the second block
    out = np.zeros((rows, 2 * 2 * JOINT_COUNT, 4), np.float32)
    pose_texels(position, rotation, rest, out)
    offset = np.array([0.05, -0.10, 0.20])
    for dancer in range(3):
        for joint in range(JOINT_COUNT):
            texel = dancer // rows * 2 * JOINT_COUNT + 2 * joint
            real, dual = out[dancer % rows, texel].astype(float), out[dancer % rows, texel + 1].astype(float)
            turn = _matrix(np.array([real[3], *real[:3]]))
            move = 2.0 * (real[3] * dual[:3] - dual[3] * real[:3] + np.cross(real[:3], dual[:3]))
            carried = turn @ (rest[joint] + offset) + move
            expected = position[dancer, joint] + _matrix(rotation[dancer, joint].astype(float)) @ offset
            np.testing.assert_allclose(carried, expected, atol=2e-5)
