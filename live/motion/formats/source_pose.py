"""A recording's joints in the world, on its own skeleton: forward kinematics in file units and axes (T164)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.formats.source_motion import Int32, SourceMotion

Float = npt.NDArray[np.floating]


@dataclass(frozen=True, slots=True, eq=False)
class LocalPose:
    """Every joint relative to its parent over T frames, in file units and axes."""

    translation: Float
    """From the parent to the joint, in the parent's axes, shape (T, J, 3); the root's is its place in the world."""
    rotation: Float
    """Unit quaternions, shape (T, J, 4)."""


@dataclass(frozen=True, slots=True, eq=False)
class WorldPose:
    """Every joint in the world over T frames, in file units and axes."""

    positions: Float
    """Shape (T, J, 3)."""
    rotations: Float
    """Unit quaternions, shape (T, J, 4)."""


def world_pose(parents: Int32, local: LocalPose) -> WorldPose:
    """Forward kinematics on the file's own skeleton: B = A + O_B R_A and so on (T164), over all frames at once."""
    frames, joints = local.rotation.shape[:2]
    positions, rotations = np.empty((joints, frames, 3)), np.empty((joints, frames, 4))
    for joint, parent in enumerate(parents):
        move, turn = local.translation[:, joint], local.rotation[:, joint]
        if parent < 0:
            positions[joint], rotations[joint] = move, turn
        else:
            positions[joint] = positions[parent] + quaternion.rotate(rotations[parent], move)
            rotations[joint] = quaternion.mul(rotations[parent], turn)
    return WorldPose(np.ascontiguousarray(positions.swapaxes(0, 1)), np.ascontiguousarray(rotations.swapaxes(0, 1)))


def end_positions(motion: SourceMotion, world: WorldPose) -> Float:
    """World positions of the End Sites [file units], shape (T, E, 3)."""
    turned = quaternion.rotate(world.rotations[:, motion.end_parents], motion.end_offsets)
    return np.asarray(world.positions[:, motion.end_parents] + turned)


def rest_pose(motion: SourceMotion) -> WorldPose:
    """The rest pose as one frame, the root at the origin [file units]."""
    translation = np.array(motion.offsets, np.float64)[None]
    translation[:, 0] = 0.0
    if motion.rest_rotation is not None:
        rotation = motion.rest_rotation[None]
    else:
        rotation = np.zeros((1, motion.joint_count, 4))
        rotation[..., 0] = 1.0
    return world_pose(motion.parents, LocalPose(translation, rotation))
