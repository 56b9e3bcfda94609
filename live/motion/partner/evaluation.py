"""Errors of an answer against the real follower, its timing (H022, motion quality), and detection of hand holds.

Holds are detected in recordings without annotations, by the distance of the palms. This is our addition; the paper has
manual annotations (H014). Retargeting to one skeleton shifts the hands a little, so the user sets the distance.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.partner.answer import palms
from live.motion.partner.units import Hold
from live.motion.quality.metrics import contact_slide_speeds, skating_frames


def joint_positions(clip: Clip) -> Float64:
    """Return the world positions of all joints [m], (T, J, 3)."""
    positions, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    return np.asarray(positions, np.float64)


@dataclass(frozen=True, slots=True)
class FollowerErrors:
    """Errors of a follower against the real one, with the same leader in the same world frame."""

    joint_m: float
    """Mean distance of the joints [m]."""
    aligned_m: float
    """The same after each pose is rotated about the vertical and moved over the floor to the best fit."""
    hip_distance_m: float
    """Mean difference of the distances between leader's and follower's hips [m]."""
    velocity_m_s: float
    """Mean difference of the joints' velocities [m/s]."""


def follower_errors(follower: Float64, truth: Float64, leader: Float64, rate: float) -> FollowerErrors:
    """Return the errors for joints (T, J, 3) [m] of all three at `rate` [Hz], cut to the shortest of them."""
    count = min(len(follower), len(truth), len(leader))
    follower, truth, leader = follower[:count], truth[:count], leader[:count]
    joint = float(np.linalg.norm(follower - truth, axis=-1).mean())
    apart = [np.linalg.norm(one[:, 0] - leader[:, 0], axis=-1) for one in (follower, truth)]
    velocity = np.diff(follower, axis=0) * rate - np.diff(truth, axis=0) * rate
    return FollowerErrors(
        joint,
        _aligned(follower, truth),
        float(np.abs(apart[0] - apart[1]).mean()),
        float(np.linalg.norm(velocity, axis=-1).mean()) if count > 1 else 0.0,
    )


def _aligned(one: Float64, other: Float64) -> float:
    a, b = (points[..., 2] + 1j * points[..., 0] for points in (one, other))
    a, b = a - a.mean(axis=1, keepdims=True), b - b.mean(axis=1, keepdims=True)
    product = (a.conj() * b).sum(axis=1)
    turn = np.where(np.abs(product) > 1e-12, product / np.maximum(np.abs(product), 1e-12), 1.0)
    left = np.abs(turn[:, None] * a - b) ** 2 + (one[..., 1] - other[..., 1]) ** 2
    return float(np.sqrt(left).mean())


def slide_metrics(positions: Float64, contact: npt.NDArray[np.bool_], rate: float) -> dict[str, float | None]:
    """Return foot_slide_mean, foot_slide_p99 [m/s] and skating_ratio of joints (T, J, 3) with contacts (T, 2)."""
    speeds = contact_slide_speeds(positions, contact, rate)
    found = skating_frames(positions, rate)
    return {
        "foot_slide_mean": float(speeds.mean()) if speeds.size else None,
        "foot_slide_p99": float(np.percentile(speeds, 99)) if speeds.size else None,
        "skating_ratio": float(found.mean()) if found.size else None,
    }


RELEASE_FACTOR: Final = 1.5
"""A hold ends when palms are this many times farther apart than its starting distance (hysteresis)."""


@dataclass(frozen=True, slots=True)
class HoldCriterion:
    """Criterion of a hold: palms come within `distance` [m] and stay near it for at least `min_seconds`."""

    distance: float
    min_seconds: float


def detect_holds(leader: Clip, follower: Clip, criterion: HoldCriterion) -> tuple[Hold, ...]:
    """Return the holds of two synchronized recordings, in temporal order, in samples.

    Each hand holds one hand at a time, the nearest free one, until the hold ends.
    """
    count = min(leader.sample_count, follower.sample_count)
    lead, own = palms(leader)[:count], palms(follower)[:count]
    apart = np.linalg.norm(lead[:, :, None] - own[:, None], axis=-1)  # (T, leader's hand, follower's hand)
    long = [
        one
        for one in _runs(apart, criterion.distance)
        if one.end - one.begin >= criterion.min_seconds * follower.sample_rate - 1e-6
    ]
    return tuple(sorted(long, key=lambda one: (one.begin, one.follower_hand)))


def _runs(apart: npt.NDArray[np.float64], distance: float) -> list[Hold]:
    """Return all holds of any length, from the distances of palms `apart` (T, 2, 2) [m]."""
    runs: list[Hold] = []
    begun: dict[tuple[int, int], int] = {}
    for sample, gaps in enumerate(apart.tolist()):
        for hands in [hands for hands in begun if gaps[hands[0]][hands[1]] > RELEASE_FACTOR * distance]:
            runs.append(Hold(*hands, float(begun.pop(hands)), sample - 1.0))
        for gap, hands in sorted((gaps[one][other], (one, other)) for one in range(2) for other in range(2)):
            if gap <= distance and not any(hands[0] == one or hands[1] == other for one, other in begun):
                begun[hands] = sample
    return runs + [Hold(*hands, float(first), len(apart) - 1.0) for hands, first in begun.items()]
