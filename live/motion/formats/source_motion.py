"""The content of a motion file of any format before retargeting, and forward kinematics on its own skeleton (T164)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from live.base.arrays import Float, Float64, Int32
from live.motion import quaternion

UpAxis = Literal["Y", "Z"]
OffsetUse = Literal["zero", "add", "replace"]


@dataclass(frozen=True, slots=True)
class FileWarning:
    """An anomaly in a motion file that does not prevent its use."""

    what: str
    line: int | None = None
    """Line in the file, from 1, where there is one."""
    frame: int | None = None
    """Frame, from 0, where there is one."""


@dataclass(frozen=True, slots=True, eq=False)
class SourceMotion:
    """J joints (End Sites are not joints) over T frames, in file units and axes; the result of every reader."""

    file: str
    names: tuple[str, ...]
    parents: Int32
    """Parent of each joint, parents first; -1 for the root, shape (J,)."""
    offsets: Float64
    """From the parent to the joint in the rest pose, in the parent's rest axes [file units], shape (J, 3)."""
    end_parents: Int32
    """Parent joint of each of the E End Sites, shape (E,)."""
    end_offsets: Float64
    """From that joint to the End Site [file units], shape (E, 3)."""
    translation: Float64
    """From the parent to the joint, in the parent's axes [file units], (T, J, 3); of the root its position."""
    rotation: Float64
    """Rotation of each joint relative to its parent, unit quaternions, shape (T, J, 4)."""
    rest_rotation: Float64 | None
    """The same in the rest pose, (J, 4), if the format has one other than the identity (glTF)."""
    frame_time: float
    """Seconds per frame as the file states them (may be wrong)."""
    frames_declared: int
    """Number of frames as the file states it (may be wrong)."""
    channel_count: int
    """Numbers per frame in the file."""
    unit_m: float | None = None
    """Metres per unit if the format fixes it (glTF: 1); None if it must be detected."""
    up: UpAxis | None = None
    """The up axis if the format fixes it; None if it must be detected."""
    root_offset: OffsetUse | None = None
    """How the OFFSET of the root was used; None if undecided (then it was added)."""
    warnings: tuple[FileWarning, ...] = ()

    @property
    def joint_count(self) -> int:
        """Number of joints J."""
        return len(self.names)

    @property
    def frame_count(self) -> int:
        """Number of frames T in the file."""
        return int(self.rotation.shape[0])

    @property
    def header_fps(self) -> float:
        """Frames per second as the file states them."""
        return 1.0 / self.frame_time


@dataclass(frozen=True, slots=True, eq=False)
class LocalPose:
    """Every joint relative to its parent over T frames, in file units and axes."""

    translation: Float
    """From the parent to the joint, in the parent's axes, shape (T, J, 3); of the root its world position."""
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
    return WorldPose(*quaternion.chain(parents, local.translation.swapaxes(0, 1), local.rotation))


def end_positions(motion: SourceMotion, world: WorldPose) -> Float:
    """Return the world positions of the End Sites [file units], shape (T, E, 3)."""
    turned = quaternion.rotate(world.rotations[:, motion.end_parents], motion.end_offsets)
    return np.asarray(world.positions[:, motion.end_parents] + turned)


def rest_pose(motion: SourceMotion) -> WorldPose:
    """Return the rest pose as one frame, the root at the origin [file units]."""
    translation = np.array(motion.offsets, np.float64)[None]
    translation[:, 0] = 0.0
    if motion.rest_rotation is not None:
        rotation = motion.rest_rotation[None]
    else:
        rotation = np.zeros((1, motion.joint_count, 4))
        rotation[..., 0] = 1.0
    return world_pose(motion.parents, LocalPose(translation, rotation))
