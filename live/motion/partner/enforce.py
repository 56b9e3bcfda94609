"""What the examples' annotations demand of an answer: feet that stand, hands that hold (H014)."""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.partner.units import Hold
from live.motion.pose.foot_lock import lock_feet
from live.motion.skeleton import SKELETON
from live.motion.two_bone_ik import two_bone

Float64 = npt.NDArray[np.float64]

PALM: Final = 0.09
"""From the wrist to the middle of the palm [m]."""
TAKE: Final = 0.15
"""Seconds in which a hand finds the other, before the hold, and lets go, after it."""
OUT_OF_REACH: Final = 0.25
"""A hand that cannot come nearer to the other than this [m] is not stretched out for it."""
_ARMS: Final = tuple(
    tuple(SKELETON.index(side + joint) for joint in ("UpperArm", "LowerArm", "Hand")) for side in ("left", "right")
)


def enforce_feet(clip: Clip) -> Clip:
    """The clip with every foot held that its contacts say stands."""
    return lock_feet(clip)


def palms(clip: Clip) -> Float64:
    """Middles of the left and the right palm [m], (T, 2, 3)."""
    positions, rotations = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    hands = [arm[2] for arm in _ARMS]
    tip = quaternion.rotate(rotations[:, hands], np.array(((PALM, 0.0, 0.0), (-PALM, 0.0, 0.0))))
    return np.asarray(positions[:, hands] + tip)


def enforce_holds(follower: Clip, leader: Clip, holds: tuple[Hold, ...]) -> Clip:
    """The follower with her palms in the leader's while `holds` say so; the leader stays as recorded.

    Both clips have one rate and count. Arms bend in the plane in which the clip has them.
    """
    if not holds:
        return follower
    wanted = palms(leader)
    positions, world = forward_kinematics(
        follower.root_position.astype(np.float64), follower.rotation.astype(np.float64)
    )
    own = palms(follower)
    rotation = follower.rotation.astype(np.float64).copy()
    samples = np.arange(follower.sample_count)
    fade = TAKE * follower.sample_rate
    for hold in holds:
        share = np.clip(np.minimum(samples - hold.begin + fade, hold.end + fade - samples) / fade, 0.0, 1.0)
        share = share * share * (3.0 - 2.0 * share)
        rows = np.flatnonzero(share > 0.0)
        upper, lower, _ = _ARMS[hold.follower_hand]
        shoulder, elbow, palm = positions[rows, upper], positions[rows, lower], own[rows, hold.follower_hand]
        reach = float(np.linalg.norm(SKELETON.offsets[lower])), _length(positions, own, lower, hold.follower_hand)
        target = wanted[rows, hold.leader_hand]
        missing = np.linalg.norm(target - shoulder, axis=-1) - sum(reach)
        weight = share[rows] * np.clip(1.0 - missing / OUT_OF_REACH, 0.0, 1.0)
        target = palm + weight[:, None] * (target - palm)
        pole = (
            elbow - 0.5 * (shoulder + palm) + 0.03 * quaternion.rotate(world[rows, upper], np.array((0.0, 0.0, -1.0)))
        )
        new_elbow, new_palm = two_bone(shoulder, target, pole, upper=reach[0], lower=reach[1], softness=0.004)
        arm = quaternion.mul(quaternion.from_two_vectors(elbow - shoulder, new_elbow - shoulder), world[rows, upper])
        forearm = quaternion.mul(quaternion.from_two_vectors(palm - elbow, new_palm - new_elbow), world[rows, lower])
        above = world[rows, SKELETON.parents[upper]]
        rotation[rows, upper] = quaternion.mul(quaternion.inverse(above), arm)
        rotation[rows, lower] = quaternion.mul(quaternion.inverse(arm), forearm)
    return replace(follower, rotation=np.ascontiguousarray(quaternion.continuous(rotation), np.float32))


def _length(positions: npt.NDArray[np.floating], palm: Float64, lower: int, side: int) -> float:
    """From the elbow to the palm [m], with the wrist as the clip bends it at most."""
    return float(np.linalg.norm(palm[:, side] - positions[:, lower], axis=-1).max())


def hold_error(follower: Clip, leader: Clip, holds: tuple[Hold, ...]) -> float | None:
    """Mean distance of palms that should hold each other [m]; None without any hold."""
    own, other = palms(follower), palms(leader)
    samples = np.arange(follower.sample_count)
    apart = [
        np.linalg.norm(own[:, one.follower_hand] - other[:, one.leader_hand], axis=-1)[
            (samples >= one.begin) & (samples <= one.end)
        ]
        for one in holds
    ]
    whole = np.concatenate(apart) if apart else np.zeros(0)
    return float(whole.mean()) if whole.size else None
