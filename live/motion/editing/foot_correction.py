"""Foot positions of clips, leg IK to given foot placements, and floor correction.

Floor correction lifts feet whose soles would go below the floor, smoothly in time.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float, Float64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.forward_kinematics import forward_kinematics
from live.motion.pose.two_bone_ik import two_bone
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

ANKLES: Final = (SKELETON.index("leftFoot"), SKELETON.index("rightFoot"))
BALLS: Final = (SKELETON.index("leftToes"), SKELETON.index("rightToes"))
"""The toe joints: the balls of the feet, which are pivots and stay planted when a heel rises."""


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """World positions [m] of the left and the right foot at T samples, float64."""

    ankle: Float
    """Ankle joints, shape (T, 2, 3)."""
    ball: Float
    """Toe joints, shape (T, 2, 3)."""

    @property
    def height(self) -> Float:
        """Height of each sole above the floor [m]: the lower of heel and ball, shape (T, 2)."""
        heel = self.ankle[..., 1] - SOLE_BELOW_ANKLE
        return np.asarray(np.minimum(heel, self.ball[..., 1] - TOES_OVER_SOLE))


def find_feet(clip: Clip) -> Feet:
    """Return the foot positions of a clip, computed in float64."""
    positions, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    return Feet(positions[:, ANKLES], positions[:, BALLS])


UPPER_LEGS: Final = (SKELETON.index("leftUpperLeg"), SKELETON.index("rightUpperLeg"))
"""The hip joints."""
LEG_LENGTH: Final = float(
    sum(np.linalg.norm(SKELETON.offsets[SKELETON.index(name)]) for name in ("leftLowerLeg", "leftFoot"))
)
"""Length of a leg from hip to ankle [m]."""
MAX_LEG_SHARE: Final = 0.992
"""Share of its length beyond which a leg looks stretched."""
_SOFTNESS: Final = 0.002
"""IK softness: recorded legs are often nearly straight and may stay so, within a few tenths of a percent."""
_FORWARD: Final = np.array((0.0, 0.0, 1.0))
_LEGS: Final = tuple(
    tuple(SKELETON.index(side + joint) for joint in ("UpperLeg", "LowerLeg", "Foot")) for side in ("left", "right")
)


def solve_legs(root: Float, rotation: Float, ankles: Float, feet: Float) -> Float:
    """Return local rotations (T, J, 4) with ankles at `ankles` and feet with the world rotations `feet` (T, 2, 4).

    `root` (T, 3) and `rotation` (T, J, 4) are the initial pose, to which knees and thighs stay close; `ankles`
    (T, 2, 3) [m]. Only the legs change. Bones keep their lengths; a leg points towards a target out of reach.
    """
    position, world = forward_kinematics(root, rotation)
    result = rotation.copy()
    for side, (upper, lower, foot) in enumerate(_LEGS):
        hip, knee, ankle = position[:, upper], position[:, lower], position[:, foot]
        pole = knee - 0.5 * (hip + ankle) + 0.05 * quaternion.rotate(world[:, upper], _FORWARD)
        new_knee, new_ankle = two_bone(
            hip, ankles[:, side], pole, upper=_length(lower), lower=_length(foot), softness=_SOFTNESS
        )
        thigh = quaternion.mul(quaternion.from_two_vectors(knee - hip, new_knee - hip), world[:, upper])
        shin = quaternion.mul(quaternion.from_two_vectors(ankle - knee, new_ankle - new_knee), world[:, lower])
        result[:, upper] = quaternion.mul(quaternion.inverse(world[:, 0]), thigh)
        result[:, lower] = quaternion.mul(quaternion.inverse(thigh), shin)
        result[:, foot] = quaternion.mul(quaternion.inverse(shin), feet[:, side])
    return result


def _length(joint: int) -> float:
    return float(np.linalg.norm(SKELETON.offsets[joint].astype(np.float64)))


LIFT_SMOOTHING: Final = 0.1
"""Seconds over which a lift fades in and out."""


@dataclass(frozen=True, slots=True, eq=False)
class FloorCorrection:
    """A corrected clip, and the lift of each foot [m], left and right, shape (T, 2)."""

    clip: Clip
    lift: Float64


def correct_floor(clip: Clip, *, soft: float = LIFT_SMOOTHING) -> FloorCorrection:
    """Lift each foot by at least the depth of its sole below y = 0, bending the leg; the rest of the body stays.

    The lift is a smooth upper bound: the maximum depth within `soft` seconds to both sides, averaged over as many.
    Positions on the floor (x, z) and foot directions stay, so planted feet stay planted. A clip without soles below
    the floor is returned unchanged.
    """
    root, rotation = clip.root_position.astype(np.float64), clip.rotation.astype(np.float64)
    position, world = forward_kinematics(root, rotation)
    depth = np.maximum(-Feet(position[:, ANKLES], position[:, BALLS]).height, 0.0)
    lift = smooth_upper_bound(depth, max(1, round(soft * clip.sample_rate)))
    if not lift.any():
        return FloorCorrection(clip, lift)
    ankles = position[:, ANKLES].copy()
    ankles[..., 1] += lift
    moved = lift.max(axis=1) > 0.0
    rotation[moved] = solve_legs(root, rotation, ankles, world[:, ANKLES])[moved]
    return FloorCorrection(replace(clip, rotation=np.ascontiguousarray(rotation, np.float32)), lift)


def smooth_upper_bound(depth: Float64, half: int) -> Float64:
    """Return a smooth upper bound (T, n) of `depth` (T, n) in time; 0 beyond 2 · `half` samples from it."""
    windows = np.lib.stride_tricks.sliding_window_view
    padded = np.pad(depth, ((2 * half, 2 * half), (0, 0)), mode="edge")
    most = windows(padded, 2 * half + 1, axis=0).max(axis=-1)
    weights = np.hanning(2 * half + 3)[1:-1]
    return np.asarray(windows(most, 2 * half + 1, axis=0) @ (weights / weights.sum()))


SWING_REACH: Final = 0.95
"""Share of its length from which a swinging leg is stretched less and less."""
SWING_FADE_S: Final = 0.06
"""Seconds next to a stance over which that sets in."""


def bend_swings(root: Float, rotation: Float, ankles: Float, contact: Bool, rate: float) -> Float:
    """Return ankles (T, 2, 3) [m] that no swinging leg has to be straight for: its knee would snap.

    `contact` (T, 2): feet that stand stay. A leg that is longer in the pose `root` (T, 3), `rotation` (T, J, 4) may
    stay so.
    """
    position, _ = forward_kinematics(root, rotation)
    hips = position[:, UPPER_LEGS]
    own = np.linalg.norm(position[:, ANKLES] - hips, axis=-1)
    way = ankles - hips
    length = np.linalg.norm(way, axis=-1)
    easy, room = SWING_REACH * LEG_LENGTH, (1.0 - SWING_REACH) * LEG_LENGTH
    beyond = np.maximum(length - easy, 0.0) / room
    short = np.minimum(length, np.maximum(np.minimum(length, easy) + room * beyond / np.sqrt(1.0 + beyond**2), own))
    free = 1.0 - smooth_upper_bound(contact.astype(np.float64), max(1, round(0.5 * SWING_FADE_S * rate)))
    share = 1.0 + free * (short / np.maximum(length, 1e-9) - 1.0)
    return np.asarray(hips + way * share[..., None])


def lower_hips(root: Float, rotation: Float, ankles: Float, longest: Float, rate: float) -> Float:
    """Return the hips lowered, smoothly in time, so that no leg is longer than `longest` (T, 2) [m]."""
    for _ in range(2):
        position, _ = forward_kinematics(root, rotation)
        way = position[:, UPPER_LEGS] - ankles
        flat = way[..., 0] ** 2 + way[..., 2] ** 2
        highest = np.sqrt(np.maximum(longest**2 - flat, 0.0))
        depth = np.maximum(way[..., 1] - highest, 0.0).max(axis=1, keepdims=True)
        if not depth.any():
            return root
        root = root - np.array((0.0, 1.0, 0.0)) * smooth_upper_bound(depth, max(1, round(0.08 * rate)))
    return root
