"""Constant rotations from the engine's joints to a recording's, from a reference pose.

For each joint `world(engine) = world(source) · alignment` at every moment. The reference is the recording's rest pose
if that is a standing body (T-pose, A-pose, arms hanging), else the frame closest to plain standing: several programs
write rest poses in which every bone lies along one axis.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float
from live.motion import quaternion
from live.motion.retarget.source_body import SourceBody
from live.motion.skeleton import SKELETON

_X: Final = np.array((1.0, 0.0, 0.0))
_Y: Final = np.array((0.0, 1.0, 0.0))
_Z: Final = np.array((0.0, 0.0, 1.0))
SIDES: Final = (("left", 1.0), ("right", -1.0))
LIMB_BONES: Final = tuple(
    (side + joint, side + child)
    for side, _ in SIDES
    for joint, child in (
        ("UpperLeg", "LowerLeg"),
        ("LowerLeg", "Foot"),
        ("UpperArm", "LowerArm"),
        ("LowerArm", "Hand"),
    )
)
"""Joints whose bones keep the recording's directions exactly, each with the joint at the bone's end."""


def engine_direction(child: str) -> Float:
    """Return the rest-pose direction of the engine's bone that ends in `child`, unit (3,)."""
    return np.asarray(quaternion.unit(SKELETON.offsets[SKELETON.index(child)].astype(np.float64)))


@dataclass(frozen=True, slots=True, eq=False)
class SourcePoints:
    """The recording's body over T frames, Y up, in file units."""

    body: SourceBody
    positions: Float
    """World positions of the source joints, shape (T, J, 3)."""
    rotations: Float
    """World rotations of the source joints, shape (T, J, 4)."""
    ends: dict[str, Float]
    """Positions of the bone ends of hands (and feet, if known), by engine joint, shape (T, 3)."""

    def at(self, joint: str) -> Float:
        """Return world positions of the source joint mapped to an engine joint, shape (T, 3)."""
        source = self.body.joints[joint]
        return self.ends[joint] if source is None else self.positions[:, source]

    def has(self, joint: str) -> bool:
        """Whether the position of the engine joint is known."""
        return self.body.joints[joint] is not None or joint in self.ends

    def bone(self, joint: str, child: str) -> Float:
        """Return the unit direction from one engine joint to the next, shape (T, 3)."""
        return quaternion.unit(self.at(child) - self.at(joint))

    def middle(self, joint: str) -> Float:
        """Return the midpoint of the left and the right joint, shape (T, 3)."""
        return np.asarray(0.5 * (self.at("left" + joint) + self.at("right" + joint)))

    def across(self, joint: str) -> Float:
        """Return the unit direction from the right joint to the left one, shape (T, 3)."""
        return self.bone("right" + joint, "left" + joint)

    def trunk(self) -> Float:
        """Return the unit direction from the middle of the hips to the middle of the shoulders, shape (T, 3)."""
        return quaternion.unit(self.middle("UpperArm") - self.middle("UpperLeg"))


def body_frame(across: Float, up: Float) -> Float:
    """Return the rotation (..., 4) of a body whose left is (nearly) `across` and whose up is `up`, both (..., 3)."""
    forward = quaternion.unit(np.cross(across, up))
    return quaternion.from_columns(np.cross(up, forward), up, forward)


def standing_frame(points: SourcePoints, *, rest: bool) -> Float:
    """Return the rotation of the whole body in each frame, relative to the engine's axes, (T, 4).

    A rest pose is snapped to the axes within 20 degrees, because its hips are rarely exact. A recorded pose is taken as
    upright in the world, independent of the trunk.
    """
    if not rest:
        across = points.across("UpperLeg")
        return body_frame(across, np.broadcast_to(_Y, across.shape))
    frame = body_frame(points.across("UpperLeg"), points.trunk())
    columns = [quaternion.rotate(frame, axis) for axis in (_X, _Y)]
    snapped = [np.where(np.abs(c) > np.cos(np.radians(20.0)), np.sign(c), 0.0) for c in columns]
    exact = np.all([np.abs(c).sum(axis=-1) == 1.0 for c in snapped], axis=0)[..., None]
    safe = [np.where(exact, c, axis) for c, axis in zip(snapped, (_X, _Y), strict=True)]
    return np.where(exact, body_frame(*safe), frame)


def standing_cost(points: SourcePoints, frame: Float) -> tuple[Float, npt.NDArray[np.bool_]]:
    """Return each frame's deviation from plain standing (0 = straight) and whether it can be a reference; (T,) each.

    Legs must point down; arms must point sideways or down and not be folded, anywhere between T-pose and hanging.
    """
    inverse = quaternion.inverse(frame)
    cost = np.zeros(len(frame))
    usable = np.ones(len(frame), np.bool_)
    for side, sign in SIDES:
        for joint, child in (("UpperLeg", "LowerLeg"), ("LowerLeg", "Foot")):
            bone = quaternion.rotate(inverse, points.bone(side + joint, side + child))
            cost += 1.0 + bone[:, 1]
            usable &= bone[:, 1] < -0.75
        upper, lower = (points.bone(side + j, side + c) for j, c in (("UpperArm", "LowerArm"), ("LowerArm", "Hand")))
        arm = quaternion.rotate(inverse, upper)
        straight = np.sum(upper * lower, axis=-1)
        cost += np.maximum(arm[:, 1], 0.0) + np.abs(arm[:, 2]) + np.maximum(-sign * arm[:, 0], 0.0) + 1.0 - straight
        usable &= (arm[:, 1] < 0.4) & (np.abs(arm[:, 2]) < 0.5) & (sign * arm[:, 0] > -0.2) & (straight > 0.5)
    return cost, usable


def reference_rotations(points: SourcePoints, frame: Float, frame_index: int) -> dict[str, Float]:
    """Return the world rotation (4,) of each engine joint at `frame_index`, the reference pose; body `frame` (T, 4).

    Trunk, head and clavicles are as in the engine's rest pose, feet flat and pointing towards the toes; limbs are
    rotated the shortest way to the source's bones.
    """
    whole = frame[frame_index]
    rotations = dict.fromkeys(SKELETON.names, whole)
    for joint, child in LIMB_BONES:
        start = quaternion.rotate(whole, engine_direction(child))
        rotations[joint] = quaternion.mul(
            quaternion.from_two_vectors(start, points.bone(joint, child)[frame_index]), whole
        )
    for side, sign in SIDES:
        hand, foot, toes = side + "Hand", side + "Foot", side + "Toes"
        rotations[hand] = rotations[side + "LowerArm"]
        if hand + "End" in points.ends:
            direction = quaternion.unit(points.ends[hand + "End"][frame_index] - points.at(hand)[frame_index])
            start = quaternion.rotate(whole, sign * _X)
            rotations[hand] = quaternion.mul(quaternion.from_two_vectors(start, direction), whole)
        if points.has(toes):
            rotations[foot] = rotations[toes] = _flat_foot(points.bone(foot, toes)[frame_index], whole)
    return rotations


def _flat_foot(toes: Float, whole: Float) -> Float:
    up = quaternion.rotate(whole, _Y)
    level = toes - up * (toes @ up)
    if np.linalg.norm(level) < 0.3:  # it points down, so its heading is undefined
        return whole
    return body_frame(np.cross(up, quaternion.unit(level)), up)


def hinge_twist(upper: Float, lower: Float, rotation: Float, bone: Float, hinge: Float) -> float:
    """Return the angle [rad] to rotate `rotation` about its `bone` so that knee or elbow bend about the engine's hinge
    axis.

    `upper` and `lower` (T, 3) are directions of the two bones, `rotation` (T, 4) is of either, `bone` and `hinge` (3,)
    are the engine's bone and hinge axis in the joint's axes. 0 if the limb is never bent.
    """
    axes = quaternion.rotate(quaternion.inverse(rotation), np.cross(upper, lower))
    axis = axes.mean(axis=0)
    axis = axis - bone * (axis @ bone)
    if np.linalg.norm(axis) < 0.1:
        return 0.0
    return float(np.arctan2(np.cross(hinge, axis) @ bone, hinge @ axis))
