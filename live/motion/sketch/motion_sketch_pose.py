"""A pose of all samples at once while a sketch is turned into one, and what it rests on."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.skeleton import SKELETON
from live.motion.sketch.foot_trajectories import FootTrack

Float = npt.NDArray[np.floating]

X_AXIS, Y_AXIS, Z_AXIS = np.eye(3)


def joint_index(name: str) -> int:
    """Index of a joint of the engine's skeleton."""
    return SKELETON.index(name)


def offset_of(name: str) -> Float:
    """From the parent to the joint in the rest pose [m], (3,)."""
    return np.asarray(SKELETON.offsets[joint_index(name)], np.float64)


def about(axis: Float, angle: Float) -> Float:
    """Rotations (T, 4) by `angle` [rad] (T,) about a fixed axis (3,)."""
    return quaternion.from_axis_angle(axis, angle)


def turned(turn: Float, lean: Float, tilt: Float) -> Float:
    """Turn (left positive) about the vertical, lean forward, tilt to the left: angles (T,) → rotations (T, 4)."""
    return quaternion.mul(about(Y_AXIS, turn), quaternion.mul(about(X_AXIS, lean), about(Z_AXIS, -tilt)))


def share_of(rotation: Float, share: float) -> Float:
    """The given share of a rotation, (T, 4)."""
    return quaternion.slerp(
        np.broadcast_to(np.array(quaternion.IDENTITY), rotation.shape), rotation, np.full(len(rotation), share)
    )


@dataclass(slots=True, eq=False)
class Pose:
    """World positions and rotations of the joints while a pose is put together, (T, J, 3) and (T, J, 4)."""

    position: Float
    rotation: Float

    def attach(self, name: str, rotation: Float) -> Float:
        """Hang the joint on its parent with the given world rotation; its world position (T, 3)."""
        joint = joint_index(name)
        parent = int(SKELETON.parents[joint])
        offset = quaternion.rotate(self.rotation[:, parent], offset_of(name))
        self.position[:, joint] = self.position[:, parent] + offset
        self.rotation[:, joint] = rotation
        return self.position[:, joint]

    def of(self, name: str) -> tuple[Float, Float]:
        """World position and rotation of a joint."""
        return self.position[:, joint_index(name)], self.rotation[:, joint_index(name)]


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """What the feet give to the body over T samples."""

    beats: Float
    facing: Float
    balance: Float
    left: FootTrack
    right: FootTrack
    flights: list[tuple[float, float]]


def stride_of(ground: Ground) -> Float:
    """How far the left foot stands before the right one, as the dancer sees it [m], (T,)."""
    apart = ground.left.ground - ground.right.ground
    return np.asarray(apart[:, 0] * np.sin(ground.facing) + apart[:, 1] * np.cos(ground.facing))
