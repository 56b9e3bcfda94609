"""Errors of an answer against the real follower, its timing (H022, motion quality), and detection of hand holds.

Holds are detected in recordings without annotations, by the distance of the palms. This is our addition; the paper has
manual annotations (H014). Retargeting to one skeleton shifts the hands a little, so the user sets the distance.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.motion import quaternion
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


HALF_TURN: Final = np.pi
"""A turn is at least this much [rad] ..."""
TURN_SECONDS: Final = 2.0
"""... within this time [s] ..."""
TURN_REVERSAL: Final = np.pi / 4.0
"""... and ends when the body turns back by this [rad]."""
TURN_TOLERANCE: Final = 0.5
"""Turns of two dancers are the same if their middles are at most so far apart [s]."""
NEAR_HAND: Final = 0.25
"""Hands are near each other at this distance of the palms [m]."""


def facing_of(clip: Clip) -> npt.NDArray[np.complex128]:
    """Return where the hips of a clip face, z + i x of length 1, (T,)."""
    front = quaternion.rotate(clip.rotation[:, 0].astype(np.float64), np.array((0.0, 0.0, 1.0)))
    facing = front[:, 2] + 1j * front[:, 0]
    return np.asarray(facing / np.maximum(np.abs(facing), 1e-9))


def wrong_facing(facing: npt.NDArray[np.complex128], truth: npt.NDArray[np.complex128]) -> float:
    """Return the share of the time in which a facing is more than 90 degrees from the true one."""
    count = min(len(facing), len(truth))
    return float(np.mean((facing[:count] * truth[:count].conj()).real < 0.0))


def find_turns(facing: npt.NDArray[np.complex128], rate: float) -> list[tuple[float, int]]:
    """Return all turns: the time at which half of each is done [s], and its direction.

    A turn is the way from one reversal of the facing, by more than TURN_REVERSAL, to the next, if it covers HALF_TURN
    within TURN_SECONDS somewhere. A double turn is one turn.
    """
    angle = np.unwrap(np.angle(facing))
    reversals, way, high, low = [0], 0, 0, 0
    for n in range(1, len(angle)):
        high = n if angle[n] > angle[high] else high
        low = n if angle[n] < angle[low] else low
        if way >= 0 and angle[high] - angle[n] > TURN_REVERSAL:
            reversals.append(high)
            way, low = -1, high + int(np.argmin(angle[high : n + 1]))
            high = low
        elif way <= 0 and angle[n] - angle[low] > TURN_REVERSAL:
            reversals.append(low)
            way, high = 1, low + int(np.argmax(angle[low : n + 1]))
            low = high
    found, window = [], round(TURN_SECONDS * rate)
    for begin, end in pairwise([*reversals, len(angle) - 1]):
        leg = np.abs(angle[begin : end + 1] - angle[begin])
        fast = len(leg) <= window or float((leg[window:] - leg[:-window]).max()) >= HALF_TURN
        if end > begin and leg[-1] >= HALF_TURN and fast:
            middle = begin + int(np.argmax(leg >= 0.5 * leg[-1]))
            found.append((middle / rate, int(np.sign(angle[end] - angle[begin]))))
    return found


def same_turns(turns: list[tuple[float, int]], truth: list[tuple[float, int]]) -> int:
    """Return how many turns are the same as a true one: at most TURN_TOLERANCE apart, in one direction, one each."""
    left, same = list(truth), 0
    for time, way in turns:
        near = [one for one in left if one[1] == way and abs(one[0] - time) <= TURN_TOLERANCE]
        if near:
            left.remove(min(near, key=lambda one: abs(one[0] - time)))
            same += 1
    return same


def hands_near(palm: Float64, leader: Float64, holds: tuple[Hold, ...]) -> float | None:
    """Return the share of the time of the real `holds` in which these palms (T, 2, 3) are near each other, None for no
    holds."""
    count = min(len(palm), len(leader))
    near = [
        np.linalg.norm(palm[rows, one.follower_hand] - leader[rows, one.leader_hand], axis=-1) < NEAR_HAND
        for one in holds
        for rows in (slice(int(one.begin), min(int(one.end) + 1, count)),)
    ]
    whole = np.concatenate(near) if near else np.zeros(0)
    return float(whole.mean()) if whole.size else None


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
