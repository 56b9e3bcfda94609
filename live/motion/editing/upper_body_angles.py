"""Angles of the upper body by which a variation of a step differs from it, and how free each is at every moment.

Trunk, upper arms and hands turn about three axes, elbows about their hinge. The head keeps its direction in the world
but for its own angles, so it goes on looking where it looked. Angles fade out where they would spoil the step: those of
an elbow where the arm is nearly straight or folded, those of an arm near the trunk, the head and the other arm, so that
a clap or a hand on the hip stays one.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.curve import smoothstep
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quality.body_contact import segment_distances, trunk_scale
from live.motion.skeleton import SKELETON

SPREAD_DEG: Final = {
    "spine": 1.6, "chest": 1.6, "upperChest": 2.0, "head": 3.0, "UpperArm": 9.0, "LowerArm": 10.0, "Hand": 8.0
}  # fmt: skip
"""Spread of the angles about each axis of a joint [degrees]: angles are in spreads."""
ELBOW_ROOM: Final = np.radians(((4.0, 34.0), (150.0, 120.0)))
"""Bends of an elbow between which its angle fades in: from nearly straight, and from folded."""
TRUNK_ROOM: Final = (1.15, 2.0)
"""The same for the distance of a forearm from the trunk's axis, as in `trunk_scale` (1: on its surface), ..."""
HEAD_ROOM_M: Final = (0.14, 0.30)
HANDS_ROOM_M: Final = (0.10, 0.35)
"""... of a wrist from the middle of the head, and of the forearms with their hands from each other [m]."""

UPPER_BODY: Final = tuple(
    joint for joint, name in enumerate(SKELETON.names) if joint and not name.endswith(("Leg", "Foot", "Toes"))
)
"""Joints above the hips."""
HEAD: Final = SKELETON.index("head")
_NECK_CHAIN: Final = tuple(SKELETON.index(name) for name in ("spine", "chest", "upperChest", "neck"))
_ARMS: Final = tuple(
    tuple(SKELETON.index(side + part) for part in ("UpperArm", "LowerArm", "Hand")) for side in ("left", "right")
)
_HEAD_MIDDLE: Final = np.array((0.0, 0.1, 0.02))
_FINGERS: Final = np.array(((0.1, 0.0, 0.0), (-0.1, 0.0, 0.0)))


def _columns() -> tuple[dict[int, slice], Float64]:
    columns: dict[int, slice] = {}
    spreads: list[float] = []
    for joint in sorted(UPPER_BODY, key=lambda joint: SKELETON.names[joint].endswith("Hand")):
        name = SKELETON.names[joint].removeprefix("left").removeprefix("right")
        if name in SPREAD_DEG:
            axes = 1 if name == "LowerArm" else 3
            columns[joint] = slice(len(spreads), len(spreads) + axes)
            spreads += [float(np.radians(SPREAD_DEG[name]))] * axes
    return columns, np.array(spreads)


COLUMNS, _SPREADS = _columns()
"""Which of the D angles are those of each joint; the hands' come last."""
ANGLES: Final = len(_SPREADS)
"""Their number D."""
HEAVY_ANGLES: Final = ANGLES - 6
"""The first of them move more than the hands, which have a hundredth of the mass."""
_PLACES: Final = {joint: place for place, joint in enumerate(COLUMNS)}


def _turned_by(joint: int) -> list[int]:
    found = [joint]
    for child in range(joint + 1, SKELETON.joint_count):
        if SKELETON.parents[child] in found and child != HEAD:
            found.append(child)
    return found


TURNED_BY: Final = {joint: _turned_by(joint) for joint, own in COLUMNS.items() if own.stop <= HEAVY_ANGLES}
"""By joint with heavy angles, the joints whose direction in the world they change."""


@dataclass(frozen=True, slots=True, eq=False)
class UpperBodyAngles:
    """T poses of a step, of which the angles of the upper body can be changed."""

    position: Float
    """Joints [m], shape (T, J, 3)."""
    world: Float
    """Rotations in the world, shape (T, J, 4)."""
    axes: Float
    """Axis of each angle in the axes of its joint, as long as its spread [rad] times how free it is, (T, 3, D)."""
    matrix: Float
    """The rotations as matrices, shape (T, J, 3, 3)."""

    @classmethod
    def of(cls, clip: Clip) -> "UpperBodyAngles":
        """Return all poses of a clip."""
        position, world = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
        return cls(position, world, _axes(position, world), quaternion.to_matrix(world))

    def part(self, first: int, last: int) -> "UpperBodyAngles":
        """Return the poses from `first` to `last` - 1."""
        part = slice(first, last)
        return UpperBodyAngles(self.position[part], self.world[part], self.axes[part], self.matrix[part])

    def turned(self, angles: Float) -> Float:
        """Return rotation matrices in the world (n, T, J, 3, 3) with `angles` (n, T, D), in spreads."""
        turns = quaternion.to_matrix(self._turns(angles))
        found = np.broadcast_to(self.matrix, (len(angles), *self.matrix.shape)).copy()
        for joint in UPPER_BODY:
            before = int(SKELETON.parents[joint])
            if joint == HEAD:
                found[:, :, joint] = self.matrix[:, joint] @ turns[_PLACES[joint]]
                continue
            local = self.matrix[:, before].swapaxes(-1, -2) @ self.matrix[:, joint]
            if joint in COLUMNS:
                local = local @ turns[_PLACES[joint]]
            found[:, :, joint] = found[:, :, before] @ local
        return found

    def positions(self, angles: Float) -> Float:
        """Return the joints (n, T, J, 3) [m] with `angles` (n, T, D), in spreads."""
        matrix = self.turned(angles)
        found = np.broadcast_to(self.position, (len(angles), *self.position.shape)).copy()
        for joint in UPPER_BODY:
            before = int(SKELETON.parents[joint])
            found[:, :, joint] = found[:, :, before] + matrix[:, :, before] @ SKELETON.offsets[joint].astype(np.float64)
        return found

    def local_turned(self, rotation: Float, angles: Float) -> Float:
        """Return the local `rotation` (T, J, 4) of these poses with `angles` (n, T, D), in spreads, (n, T, J, 4)."""
        turns = self._turns(angles)
        found = np.broadcast_to(rotation, (len(angles), *rotation.shape)).copy()
        for joint, place in _PLACES.items():
            found[:, :, joint] = quaternion.mul(rotation[:, joint], turns[place])
        neck = self.world[:, 0]
        for joint in _NECK_CHAIN:
            neck = quaternion.mul(neck, found[:, :, joint])
        head = quaternion.mul(quaternion.inverse(neck), quaternion.mul(self.world[:, HEAD], turns[_PLACES[HEAD]]))
        opposite = (head * rotation[:, HEAD]).sum(axis=-1, keepdims=True) < 0.0
        found[:, :, HEAD] = np.where(opposite, -head, head)
        return quaternion.unit(found)

    def world_axes(self, joint: int) -> Float:
        """Return the axes of a joint's angles in the world, (T, 3, axes)."""
        return self.matrix[:, joint] @ self.axes[..., COLUMNS[joint]]

    def _turns(self, angles: Float) -> Float:
        """Return the rotations that the joints of COLUMNS make by `angles` (n, T, D), (joints, n, T, 4)."""
        starts = [own.start for own in COLUMNS.values()]
        vectors = np.add.reduceat(self.axes * angles[..., None, :], starts, axis=-1)
        return quaternion.from_rotation_vector(np.ascontiguousarray(np.moveaxis(vectors, -1, 0)))


def _axes(position: Float, world: Float) -> Float:
    """Return the axes of joints at `position` (T, J, 3) [m] with rotations `world` (T, J, 4)."""
    axes = np.zeros((len(position), 3, ANGLES))
    for own in COLUMNS.values():
        axes[..., own] = np.eye(3)[:, : own.stop - own.start] * _SPREADS[own]
    shoulder, elbow, wrist = np.moveaxis(position[:, _ARMS], 2, 0)  # (T, side, 3) each
    across = np.cross(elbow - shoulder, wrist - elbow)
    bend = np.arctan2(np.linalg.norm(across, axis=-1), ((elbow - shoulder) * (wrist - elbow)).sum(axis=-1))
    room = _fade(bend, *ELBOW_ROOM[0]) * _fade(bend, *ELBOW_ROOM[1])
    free = _arm_room(position, world)
    for side, arm in enumerate(_ARMS):
        for joint in arm:
            axes[..., COLUMNS[joint]] *= free[:, side, None, None]
        hinge = quaternion.rotate(quaternion.inverse(world[:, arm[1]]), quaternion.unit(across[:, side]))
        place = COLUMNS[arm[1]].start
        axes[..., place] = hinge * (_SPREADS[place] * (room * free)[:, side, None])
    return axes


def _arm_room(position: Float, world: Float) -> Float:
    """Return how free the left and the right arm are, 0 to 1, (T, 2)."""
    _, elbow, wrist = np.moveaxis(position[:, _ARMS], 2, 0)
    fore = elbow[:, :, None] + np.linspace(0.25, 1.0, 4)[:, None] * (wrist - elbow)[:, :, None]
    near = trunk_scale(position, fore.reshape(len(fore), -1, 3)).reshape(len(fore), 2, -1).min(axis=-1)
    head = position[:, HEAD] + quaternion.rotate(world[:, HEAD], _HEAD_MIDDLE)
    fingers = wrist + quaternion.rotate(world[:, [arm[2] for arm in _ARMS]], _FINGERS)
    apart = segment_distances(elbow[:, 0], fingers[:, 0], elbow[:, 1], fingers[:, 1])
    free = _fade(near, *TRUNK_ROOM) * _fade(np.linalg.norm(wrist - head[:, None], axis=-1), *HEAD_ROOM_M)
    return np.asarray(free * _fade(apart, *HANDS_ROOM_M)[:, None])


def _fade(value: Float, none: float, full: float) -> Float:
    """Return 0 at `none`, 1 at `full`, eased."""
    return np.asarray(smoothstep((value - none) / (full - none)))
