"""From BVH channels to joints in the world: offsets, rotation orders and position channels applied (T164)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.bvh import BvhMotion
from live.motion.euler import euler_to_quaternion

Float = npt.NDArray[np.floating]
OffsetUse = Literal["add", "replace"]


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


def local_pose(motion: BvhMotion, root_offset: OffsetUse = "add") -> LocalPose:
    """Channels as rotations and translations.

    By the format (T164: A = O_A + T_A) position channels are added to OFFSET. Some programs write the whole place
    into them instead: for the root `root_offset` says which it is, for the other joints it is seen from the values
    (whether they lie about zero or about OFFSET).
    """
    frames, joints = motion.frame_count, motion.joint_count
    rotation = np.zeros((frames, joints, 4))
    rotation[..., 0] = 1.0
    translation = np.broadcast_to(motion.offsets, (frames, joints, 3)).copy()
    columns: dict[str, list[tuple[int, list[int]]]] = {}
    first = 0
    for joint, letters in enumerate(motion.channels):
        turns = [first + place for place, letter in enumerate(letters) if letter.isupper()]
        columns.setdefault("".join(filter(str.isupper, letters)), []).append((joint, turns))
        moves = {"xyz".index(letter): first + place for place, letter in enumerate(letters) if letter.islower()}
        if moves:
            moved = motion.values[:, list(moves.values())]
            axes = list(moves)
            replace = root_offset == "replace" if joint == 0 else _holds_offset(moved, motion.offsets[joint, axes])
            translation[:, joint, axes] = moved if replace else moved + motion.offsets[joint, axes]
        first += len(letters)
    for order, places in columns.items():
        if order:
            turned = [joint for joint, _ in places]
            angles = np.radians(motion.values[:, [turns for _, turns in places]])
            rotation[:, turned] = euler_to_quaternion(angles, order)
    return LocalPose(translation, rotation)


def _holds_offset(moved: Float, offset: Float) -> bool:
    """Whether position channels of an inner joint hold the whole offset (then it must not be added again)."""
    return bool(np.median(np.linalg.norm(moved - offset, axis=-1)) < np.median(np.linalg.norm(moved, axis=-1)))


def world_pose(motion: BvhMotion, local: LocalPose) -> WorldPose:
    """Forward kinematics on the file's own skeleton: B = A + O_B R_A and so on (T164), over all frames at once."""
    frames, joints = local.rotation.shape[:2]
    positions, rotations = np.empty((joints, frames, 3)), np.empty((joints, frames, 4))
    for joint, parent in enumerate(motion.parents):
        move, turn = local.translation[:, joint], local.rotation[:, joint]
        if parent < 0:
            positions[joint], rotations[joint] = move, turn
        else:
            positions[joint] = positions[parent] + quaternion.rotate(rotations[parent], move)
            rotations[joint] = quaternion.mul(rotations[parent], turn)
    return WorldPose(np.ascontiguousarray(positions.swapaxes(0, 1)), np.ascontiguousarray(rotations.swapaxes(0, 1)))


def end_positions(motion: BvhMotion, world: WorldPose) -> Float:
    """World positions of the End Sites [file units], shape (T, E, 3)."""
    turned = quaternion.rotate(world.rotations[:, motion.end_parents], motion.end_offsets)
    return np.asarray(world.positions[:, motion.end_parents] + turned)


def rest_positions(motion: BvhMotion) -> Float:
    """Joints in the rest pose (no channel applied), the root at the origin [file units], shape (J, 3)."""
    positions = np.array(motion.offsets)
    positions[0] = 0.0
    for joint, parent in enumerate(motion.parents):
        if parent >= 0:
            positions[joint] += positions[parent]
    return positions
