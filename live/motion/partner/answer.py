"""Follower's motion from a reading: units copied from the examples, joined, with foot and hand constraints.

Units are sampled from the source clips, time-scaled, rotated and moved as their clouds were (H013). Contacts and holds
are copied too (H014) and enforced with IK. Where two units meet, each is bent halfway towards the other (H015):
linearly over the whole unit as published, or eased, so that velocities match as well.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64
from live.motion import quaternion
from live.motion.clip import Clip, read_clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.partner.decoder import Reading
from live.motion.partner.units import Hold, Units
from live.motion.pose.foot_lock import lock_feet
from live.motion.pose.two_bone_ik import two_bone
from live.motion.skeleton import SKELETON

Smoothing = Literal["none", "linear", "eased"]

SETTLE_S: Final = 0.2
"""Time from a boundary in which the difference of velocities is removed (eased) [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """A follower's motion for an input."""

    clip: Clip
    source_sample: Float64
    """For each sample its source sample in the unit's recording, (T,)."""
    unit: npt.NDArray[np.int64]
    """Index of each sample's unit in the reading, (T,)."""
    holds: tuple[Hold, ...]
    """Hand holds, in samples of the clip."""
    boundaries: npt.NDArray[np.int64]
    """Samples at which units meet, (L - 1,)."""


def answer(reading: Reading, units: Units, count: int, smoothing: Smoothing = "eased", name: str = "answer") -> Answer:
    """Return `count` samples of the follower at the rate of the reading, which is that of the clips.

    Before the first unit and after the last one their recordings continue.
    """
    parts = [_unit_motion(reading, units, n, count) for n in range(reading.count)]
    if smoothing != "none":
        _join(parts, reading.rate, smoothing)
    root = np.concatenate([part.root[: part.kept] for part in parts])
    rotation = np.concatenate([part.rotation[: part.kept] for part in parts])
    clip = Clip(
        name,
        np.ascontiguousarray(root, np.float32),
        np.ascontiguousarray(quaternion.align_signs(quaternion.unit(rotation)), np.float32),
        reading.rate,
        np.concatenate([part.contact[: part.kept] for part in parts]),
    )
    which = np.concatenate([np.full(part.kept, n) for n, part in enumerate(parts)])
    source = np.concatenate([part.source[: part.kept] for part in parts])
    return Answer(clip, source, which, _holds(reading, units, count), reading.start[1:])


@dataclass(slots=True, eq=False)
class _Part:
    """The samples of one unit, including the first of the next one, which both share."""

    root: Float64
    rotation: Float64
    contact: Bool
    source: Float64
    kept: int
    begin: int
    """Samples before the unit begins (only in the first part)."""
    stop: int
    """Index of the sample at which the unit ends."""


def _unit_motion(reading: Reading, units: Units, n: int, count: int) -> _Part:
    unit, start, frames = int(reading.unit[n]), int(reading.start[n]), int(reading.duration[n])
    first = 0 if n == 0 else start
    last = count - 1 if n == reading.count - 1 else start + frames
    step = float(units.length[unit]) / frames
    source = np.asarray(float(units.start[unit]) + (np.arange(first, last + 1) - start) * step, np.float64)
    clip = units.examples[int(units.example[unit])].follower
    raw_root, raw_rotation, contact = read_clip(clip, source)
    root, rotation = np.asarray(raw_root, np.float64), np.asarray(raw_rotation, np.float64)
    turn, shift = reading.turn[n], reading.shift[n]
    place = turn * (root[:, 2] + 1j * root[:, 0]) + shift
    root = np.stack((place.imag, root[:, 1], place.real), axis=1)
    half = 0.5 * np.angle(turn)
    yaw = np.array((np.cos(half), 0.0, np.sin(half), 0.0))
    rotation[:, 0] = quaternion.mul(yaw, rotation[:, 0])
    kept = len(source) - (n < reading.count - 1)
    return _Part(root, rotation, contact, source, kept, start - first, start + frames - first)


def _join(parts: list[_Part], rate: float, smoothing: Smoothing) -> None:
    """Bend neighbours halfway towards each other, in place."""
    joints = parts[0].rotation.shape[1]
    bend = [np.zeros((2, 2, 1 + joints, 3)) for _ in parts]  # begin/end, offset/velocity, root and joints
    for n, (one, other) in enumerate(pairwise(parts)):
        gap = _difference(one, one.stop, other, other.begin)
        bend[n][1, 0], bend[n + 1][0, 0] = 0.5 * gap, -0.5 * gap
        speed = rate * (_step(other, other.begin) - _step(one, one.stop - 1))
        bend[n][1, 1], bend[n + 1][0, 1] = 0.5 * speed, -0.5 * speed
    for part, ends in zip(parts, bend, strict=True):
        frames = max(part.stop - part.begin, 1)
        at = np.arange(len(part.source)) - part.begin
        w = np.clip(at / frames, 0.0, 1.0)[:, None, None]
        if smoothing == "linear":
            offset = (1.0 - w) * ends[0, 0] + w * ends[1, 0]
        else:
            w = w * w * (3.0 - 2.0 * w)
            seconds = at / rate
            offset = (1.0 - w) * ends[0, 0] + w * ends[1, 0]
            offset += _velocity_ramp(seconds) * ends[0, 1] - _velocity_ramp((frames - at) / rate) * ends[1, 1]
        part.root += offset[:, 0]
        turned = quaternion.mul(part.rotation, quaternion.from_rotation_vector(offset[:, 1:]))
        part.rotation = np.asarray(turned, np.float64)


def _velocity_ramp(seconds: Float64) -> Float64:
    """Return a curve that starts at 0 with slope 1 and is 0 with slope 0 after SETTLE_S; [s], (T, 1, 1)."""
    t = np.clip(seconds / SETTLE_S, 0.0, 1.0)
    return np.asarray(SETTLE_S * t * (1.0 - t) ** 2)[:, None, None]


def _difference(one: _Part, i: int, other: _Part, j: int) -> Float64:
    """Return the difference from sample i of `one` to sample j of `other`: root and rotation vectors, (1 + J, 3)."""
    turn = quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(one.rotation[i]), other.rotation[j]))
    return np.concatenate((other.root[j : j + 1] - one.root[i : i + 1], turn))


def _step(part: _Part, at: int) -> Float64:
    """Return the difference from sample `at` to the next one."""
    at = min(max(at, 0), len(part.root) - 2)
    return _difference(part, at, part, at + 1) if len(part.root) > 1 else np.zeros((1 + part.rotation.shape[1], 3))


def _holds(reading: Reading, units: Units, count: int) -> tuple[Hold, ...]:
    """Return the holds of the units in samples of the answer. Holds that continue over a boundary are merged."""
    found: list[Hold] = []
    for n, unit in enumerate(reading.unit.tolist()):
        start, length = float(units.start[unit]), float(units.length[unit])
        scale, at = float(reading.duration[n]) / length, float(reading.start[n])
        for hold in units.examples[int(units.example[unit])].holds:
            begin, end = max(hold.begin, start), min(hold.end, start + length)
            if begin >= end:
                continue
            begin, end = at + (begin - start) * scale, min(at + (end - start) * scale, count - 1.0)
            same = [
                m for m, one in enumerate(found)
                if (one.leader_hand, one.follower_hand) == (hold.leader_hand, hold.follower_hand)
                and one.end >= begin - 1.5
            ]  # fmt: skip
            if same:
                begin = found[same[-1]].begin
                del found[same[-1]]
            found.append(Hold(hold.leader_hand, hold.follower_hand, begin, end))
    return tuple(found)


PALM_OFFSET: Final = 0.09
"""Distance from the wrist to the middle of the palm [m]."""
REACH_S: Final = 0.15
"""Time to reach for the hand before the hold and to release it after [s]."""
MAX_OVERREACH: Final = 0.25
"""A hand does not reach for a target that is farther than this beyond the arm's reach [m]."""
_ARMS: Final = tuple(
    tuple(SKELETON.index(side + joint) for joint in ("UpperArm", "LowerArm", "Hand")) for side in ("left", "right")
)


def enforce_feet(clip: Clip) -> Clip:
    """Return the clip with feet locked while they are in contact."""
    return lock_feet(clip)


def palms(clip: Clip) -> Float64:
    """Return the middles of the left and right palm [m], (T, 2, 3)."""
    positions, rotations = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    hands = [arm[2] for arm in _ARMS]
    tip = quaternion.rotate(rotations[:, hands], np.array(((PALM_OFFSET, 0.0, 0.0), (-PALM_OFFSET, 0.0, 0.0))))
    return np.asarray(positions[:, hands] + tip)


def enforce_holds(follower: Clip, leader: Clip, holds: tuple[Hold, ...]) -> Clip:
    """Return the follower with palms moved to the leader's during `holds`; the leader is unchanged.

    Both clips have the same rate and count. Arms bend in the plane in which the clip has them.
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
    fade = REACH_S * follower.sample_rate
    for hold in holds:
        share = np.clip(np.minimum(samples - hold.begin + fade, hold.end + fade - samples) / fade, 0.0, 1.0)
        share = share * share * (3.0 - 2.0 * share)
        rows = np.flatnonzero(share > 0.0)
        upper, lower, _ = _ARMS[hold.follower_hand]
        shoulder, elbow, palm = positions[rows, upper], positions[rows, lower], own[rows, hold.follower_hand]
        reach = (
            float(np.linalg.norm(SKELETON.offsets[lower])),
            _forearm_length(positions, own, lower, hold.follower_hand),
        )
        target = wanted[rows, hold.leader_hand]
        missing = np.linalg.norm(target - shoulder, axis=-1) - sum(reach)
        weight = share[rows] * np.clip(1.0 - missing / MAX_OVERREACH, 0.0, 1.0)
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
    return replace(follower, rotation=np.ascontiguousarray(quaternion.align_signs(rotation), np.float32))


def _forearm_length(positions: npt.NDArray[np.floating], palm: Float64, lower: int, side: int) -> float:
    """Return the largest distance from elbow to palm in the clip [m]."""
    return float(np.linalg.norm(palm[:, side] - positions[:, lower], axis=-1).max())


def hold_error(follower: Clip, leader: Clip, holds: tuple[Hold, ...]) -> float | None:
    """Return the mean distance of palms that should hold each other [m], None without holds."""
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
