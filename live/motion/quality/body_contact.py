"""Contact of bodies in drawn joints: forearms inside the own trunk, arms at another's arms, hands in another's trunk.

Bodies are the capsules of `live.motion.pose.body_capsules`. Only penetration counts: a hand on the own hip touches the
surface, and the forearm's axis stays outside. Arms of a couple that hold each other by the hand are meant to touch.
"""

import numpy as np

from live.base.arrays import Bool, Float, Float64, Int32
from live.motion.pose.body_capsules import (
    ARM_CHAINS,
    ARMS_APART,
    HAND_TO_TRUNK,
    TRUNK_AXIS_SHARE,
    TRUNK_END,
    TRUNK_HALF_DEPTH,
    TRUNK_HALF_WIDTH,
    TRUNK_JOINTS,
)
from live.motion.pose.hand_hold import HeldArms

_SAMPLES = np.linspace(0.0, 1.0, 9)
"""Points along a forearm that are tested, 3 cm apart."""
_NEAR = 2.0
"""Hips farther apart than this [m] are out of each other's reach."""
_TINY = 1e-9


def trunk_scale(position: Float, points: Float) -> Float64:
    """Return how far points are from the axis of a trunk: 0 on it, 1 on the surface, shape (..., P).

    `position` (..., J, 3) are the joints, `points` (..., P, 3) [m].
    """
    joints = position[..., TRUNK_JOINTS, :].astype(np.float64)
    hips, chest, neck, left_leg, right_leg, left, right = np.moveaxis(joints, -2, 0)
    axis = TRUNK_AXIS_SHARE * (neck - hips)
    length = np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), _TINY)
    along = axis / length
    bend = chest - hips - ((chest - hips) * axis).sum(-1, keepdims=True) / length**2 * axis
    low, high = (_normal_to(side, along) for side in (left_leg - right_leg, left - right))
    from_hips = points - hips[..., None, :]
    t = np.clip((from_hips * along[..., None, :]).sum(-1) / length, 0.0, 1.0)[..., None]
    aside = from_hips - t * axis[..., None, :] - 4.0 * t * (1.0 - t) * bend[..., None, :]
    wide = _unit(low[..., None, :] + t * (high - low)[..., None, :])
    ahead = np.cross(along[..., None, :], wide)
    return np.asarray(
        np.sqrt(
            ((aside * wide).sum(-1) / TRUNK_HALF_WIDTH) ** 2
            + ((aside * ahead).sum(-1) / TRUNK_HALF_DEPTH) ** 2
            + ((aside * along[..., None, :]).sum(-1) / TRUNK_END) ** 2
        )
    )


def self_contacts(position: Float) -> Bool:
    """Return whether the axis of either forearm enters the own trunk, (...) from joints (..., J, 3) [m]."""
    arms = position[..., ARM_CHAINS, :].astype(np.float64)
    elbow, wrist = arms[..., 1, :], arms[..., 2, :]
    points = elbow[..., None, :] + _SAMPLES[:, None] * (wrist - elbow)[..., None, :]
    points = points.reshape(*position.shape[:-2], -1, 3)
    return np.asarray((trunk_scale(position, points) < 1.0).any(axis=-1), np.bool_)


def arm_distances(position: Float, first: Int32, second: Int32) -> Float64:
    """Return the distances between the axes of the arms of dancers `first` and `second` (n,) [m], (n, 2, 2).

    `position` is (A, J, 3); an arm goes from the shoulder over the elbow to the wrist.
    """
    arms = position[:, ARM_CHAINS].astype(np.float64)
    one, other = arms[first][:, :, None], arms[second][:, None]
    found = [
        segment_distances(one[..., a, :], one[..., a + 1, :], other[..., b, :], other[..., b + 1, :])
        for a in range(2)
        for b in range(2)
    ]
    return np.asarray(np.min(found, axis=0))


def neighbour_contacts(position: Float, held: HeldArms | None = None) -> tuple[bool, bool]:
    """Return whether in one picture (A, J, 3) arms of two dancers are within 6 cm, and whether a wrist is within 12 cm
    of the line between another's hips and neck.

    In a couple, an arm in a hold (`held`) does not count against the partner.
    """
    first, second = _near_pairs(position)
    if not len(first):
        return False, False
    arms = arm_distances(position, first, second) < ARMS_APART
    hands = []
    for one, other in ((first, second), (second, first)):
        line = position[other][:, TRUNK_JOINTS[[0, 2]]].astype(np.float64)[:, None]
        wrist = position[one][:, ARM_CHAINS[:, 2]].astype(np.float64)
        hands.append(segment_distances(wrist, wrist, line[..., 0, :], line[..., 1, :]) < HAND_TO_TRUNK)
    if held is not None:
        closed = held.share > 0.0
        couple = ((held.partner[first] == second) | (held.partner[second] == first))[:, None]
        arms &= ~(couple[..., None] & (closed[first][:, :, None] | closed[second][:, None]))
        hands = [found & ~(couple & closed[one]) for found, one in zip(hands, (first, second), strict=True)]
    return bool(arms.any()), bool(hands[0].any() or hands[1].any())


def segment_distances(a: Float64, b: Float64, c: Float64, d: Float64) -> Float64:
    """Return the distances between segments a-b and c-d [m], (...) from (..., 3), which broadcast.

    The closest points are either inside both segments or at an end of one of them.
    """
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = (u * u).sum(-1), (u * v).sum(-1), (v * v).sum(-1)
    uw, vw = (u * w).sum(-1), (v * w).sum(-1)
    scale = np.maximum(uu * vv - uv * uv, _TINY)
    s = np.clip((uv * vw - vv * uw) / scale, 0.0, 1.0)
    found = []
    for s_at in (s, np.zeros_like(s), np.ones_like(s)):
        t = np.clip((uv * s_at + vw) / np.maximum(vv, _TINY), 0.0, 1.0)
        again = np.clip((uv * t - uw) / np.maximum(uu, _TINY), 0.0, 1.0)
        found.append(np.linalg.norm(w + again[..., None] * u - t[..., None] * v, axis=-1))
    return np.asarray(np.min(found, axis=0))


class ContactRecorder:
    """Counts contacts picture by picture."""

    def __init__(self) -> None:
        self._dancers = self._inside = self._pictures = self._arms = self._hands = 0

    def add(self, position: Float, held: HeldArms | None = None, visible: Bool | None = None) -> None:
        """Add a picture: joints of all dancers (A, J, 3) [m]; those not `visible` (A,) do not count."""
        rows = np.arange(len(position)) if visible is None else np.flatnonzero(visible)
        if not len(rows):
            return
        shown = position[rows]
        self._dancers += len(rows)
        self._inside += int(self_contacts(shown).sum())
        arms, hands = neighbour_contacts(shown, None if held is None else held.of(rows))
        self._pictures += 1
        self._arms += arms
        self._hands += hands

    def ratios(self) -> dict[str, float | None]:
        """Return the shares: of dancers' frames with a forearm inside the own trunk, of pictures with arms of two
        dancers within 6 cm, and of pictures with a hand within 12 cm of another's trunk; None without any."""
        some = self._pictures > 0
        return {
            "self_contact_ratio": self._inside / self._dancers if some else None,
            "neighbour_contact_ratio": self._arms / self._pictures if some else None,
            "hand_contact_ratio": self._hands / self._pictures if some else None,
        }


def _near_pairs(position: Float) -> tuple[Int32, Int32]:
    """Return the pairs of dancers with hips within each other's reach, (n,) each."""
    hips = position[:, 0].astype(np.float64)
    order = np.argsort(hips[:, 0], kind="stable")
    x = hips[order, 0]
    last = np.searchsorted(x, x + _NEAR, side="right")
    count = last - np.arange(len(x)) - 1
    first = np.repeat(np.arange(len(x)), count)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(count) - count, count)
    near = np.abs(hips[order[first], 2] - hips[order[second], 2]) <= _NEAR
    return order[first[near]].astype(np.int32), order[second[near]].astype(np.int32)


def _unit(vector: Float64) -> Float64:
    return np.asarray(vector / np.maximum(np.linalg.norm(vector, axis=-1, keepdims=True), _TINY))


def _normal_to(vector: Float64, along: Float64) -> Float64:
    """Return the direction of `vector` normal to the unit vector `along`."""
    return _unit(vector - (vector * along).sum(-1, keepdims=True) * along)
