"""Forward kinematics in numpy over the samples of a clip, for offline work (metrics, tools, tests)."""

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.skeleton import SKELETON, Skeleton

Float = npt.NDArray[np.floating]


def forward_kinematics(root_position: Float, rotation: Float, skeleton: Skeleton = SKELETON) -> tuple[Float, Float]:
    """Return world positions [m] (T, J, 3) and world rotations (T, J, 4) of all joints.

    `root_position` (T, 3) [m] is the world position of the root, `rotation` (T, J, 4) holds local unit quaternions. The
    results have the wider of the two dtypes.
    """
    positions = np.empty((*rotation.shape[:2], 3), np.result_type(root_position, rotation))
    rotations = np.empty(rotation.shape, positions.dtype)
    for joint, parent in enumerate(skeleton.parents):
        if parent < 0:
            positions[:, joint] = root_position
            rotations[:, joint] = rotation[:, joint]
        else:
            offset = skeleton.offsets[joint].astype(positions.dtype)
            positions[:, joint] = positions[:, parent] + quaternion.rotate(rotations[:, parent], offset)
            rotations[:, joint] = quaternion.mul(rotations[:, parent], rotation[:, joint])
    return positions, rotations


def local_rotations(world: Float, skeleton: Skeleton = SKELETON) -> Float:
    """Return local unit rotations (T, J, 4), float64, from world rotations (T, J, 4)."""
    world = np.asarray(world, np.float64)
    rotation = world.copy()
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            rotation[:, joint] = quaternion.mul(quaternion.inverse(world[:, parent]), world[:, joint])
    return quaternion.unit(rotation)
