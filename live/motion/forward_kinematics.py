"""Forward kinematics in numpy over the samples of a clip, for offline work (metrics, tools, tests)."""

import numpy as np

from live.base.arrays import Float
from live.motion import quaternion
from live.motion.skeleton import SKELETON, Skeleton


def forward_kinematics(root_position: Float, rotation: Float, skeleton: Skeleton = SKELETON) -> tuple[Float, Float]:
    """Return world positions [m] (T, J, 3) and world rotations (T, J, 4) of all joints.

    `root_position` (T, 3) [m] is the world position of the root, `rotation` (T, J, 4) holds local unit quaternions. The
    results have the wider of the two dtypes.
    """
    offsets = skeleton.offsets.astype(np.result_type(root_position, rotation))
    return quaternion.chain(skeleton.parents, [root_position, *offsets[1:]], rotation)


def local_rotations(world: Float, skeleton: Skeleton = SKELETON) -> Float:
    """Return local unit rotations (T, J, 4), float64, from world rotations (T, J, 4)."""
    return quaternion.unchain(skeleton.parents, world)
