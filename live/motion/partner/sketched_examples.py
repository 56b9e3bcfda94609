"""Examples for partner synthesis made from single sketched steps, without recordings of pairs.

Pairs: the follower of a step is the library step, forward or reversed in time, that matches it best when danced
opposite. A step to the left is answered to the other dancer's right, a walk forward by a walk backward. So both keep
their distance and their feet do not collide.

Walks along a path come from steps that go forward (H017, H019). A sketched walk is straight, at a few speeds. Strides
are blended and paths bent to cover other speeds and curves, with foot lock. Both are our additions; the paper has
recorded pairs and two minutes of a recorded walk.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.clip import Clip, read_clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.partner.answer import enforce_feet
from live.motion.partner.evaluation import HoldCriterion, detect_holds
from live.motion.partner.point_clouds import END_JOINTS, Cloud, cloud_of, ends_cloud, leader_cloud, path_cloud
from live.motion.partner.units import Example, Units, cut_units
from live.motion.step_clip import StepClip

PARTNER_DISTANCE: Final = 1.0
"""Distance of the two dancers [m]."""
REPETITIONS: Final = 2
"""Repetitions of each step: the follower continues the step until the next unit is decided."""
BLEND_SHARE: Final = 0.1
"""Length of the blend from the first pass to the second, as a share of a measure."""
FEET_WEIGHT: Final = 4.0
"""Weight of height differences of facing feet against distances of hips."""
OTHER_STEP_COST: Final = 0.004
"""Cost of choosing a different step as the follower [m²]."""
MOMENTS: Final = 16
"""Moments of a measure at which steps are compared."""


@dataclass(frozen=True, slots=True, eq=False)
class _StepMotion:
    """A step, repeated forward or reversed in time, with its features for comparison."""

    step: str
    clip: Clip
    ends: Cloud
    path: Float64
    """Path of the hips, with heading 0 at the beginning, (M, 2) [m]."""
    feet: Float64
    """Heights of left and right foot, (M, 2) [m]."""


def sketched_pairs(clips: Sequence[StepClip], *, unit_beats: int, hold_criterion: HoldCriterion | None = None) -> Units:
    """Return units of `unit_beats` from all `clips`, which share one metre and tempo; ValueError if none fits.

    Hands that meet the criterion `hold_criterion` hold each other. With None there are no holds.
    """
    found: list[Example] = []
    for measures in sorted({clip.measures for clip in clips}):
        steps = [clip for clip in clips if clip.measures == measures and clip.beats % unit_beats == 0]
        if not steps:
            continue
        follows = _step_motions(steps, [repeat_step(step, back=False) for step in steps])
        follows += _step_motions(steps, [repeat_step(step, back=True) for step in steps])
        best = np.argmin(_costs(follows, len(steps)), axis=1)
        pairs = zip(steps, follows[: len(steps)], best.tolist(), strict=True)
        found += [_pair(step, lead, follows[n], unit_beats, hold_criterion) for step, lead, n in pairs]
    if not found:
        raise ValueError(f"no step has a length that is a multiple of {unit_beats} beats")
    return cut_units(found)


def _pair(
    step: StepClip, lead: _StepMotion, best: _StepMotion, unit_beats: int, hold_criterion: HoldCriterion | None
) -> Example:
    beat = step.samples_per_measure / step.beats_per_measure
    cuts = np.asarray(np.arange(step.beats // unit_beats + 1) * beat * unit_beats, np.float64)
    beats = np.asarray(np.arange(REPETITIONS * step.beats + 1) * beat, np.float64)
    target = best.ends.transformed(complex(-1.0), complex(PARTNER_DISTANCE))
    follower = _place_opposite(best.clip)
    holds = () if hold_criterion is None else detect_holds(lead.clip, follower, hold_criterion)
    return Example(step.step, lead.ends, target, follower, cuts, beats, holds, leader_cloud(lead.clip))


def _costs(motions: Sequence[_StepMotion], count: int) -> Float64:
    """Return the cost of each of all n as the opposite follower of each of the first `count`, (count, n)."""
    way, feet = np.stack([one.path for one in motions]), np.stack([one.feet for one in motions])
    names = np.array([one.step for one in motions])
    found = OTHER_STEP_COST * (names[:count, None] != names[None])
    for row in range(count):
        apart = way[row] + way  # opposite dancers face each other, so the follower's path is negated
        amiss = feet[row] - feet[:, :, ::-1]
        found[row] += (apart**2).sum(axis=2).mean(axis=1) + FEET_WEIGHT * (amiss**2).mean(axis=(1, 2))
    return np.asarray(found, np.float64)


def _step_motions(steps: Sequence[StepClip], clips: Sequence[Clip]) -> list[_StepMotion]:
    """Return the features of the `clips` of `steps`, with one batched forward kinematics call."""
    root = np.concatenate([clip.root_position for clip in clips]).astype(np.float64)
    rotation = np.concatenate([clip.rotation for clip in clips]).astype(np.float64)
    ends = forward_kinematics(root, rotation)[0][:, END_JOINTS]
    parts = np.split(ends, np.cumsum([clip.sample_count for clip in clips])[:-1])
    found = []
    for step, clip, points in zip(steps, clips, parts, strict=True):
        count = step.measures * step.samples_per_measure
        at = np.linspace(0.0, count, MOMENTS * step.measures + 1).round().astype(np.int64)
        way = clip.root_position[at][:, (0, 2)].astype(np.float64)
        found.append(
            _StepMotion(
                step.step, clip, cloud_of(points, clip.sample_rate), way, np.asarray(points[at, 2:, 1], np.float64)
            )
        )
    return found


def repeat_step(step: StepClip, *, back: bool) -> Clip:
    """Return the measures of a step repeated PASSES times, from the origin, facing 0; `back` reverses time."""
    count = round(step.measures * step.samples_per_measure)
    read = read_clip(step.clip, step.first + np.arange(count + 1.0))
    root, rotation, contact = np.asarray(read[0], np.float64), np.asarray(read[1], np.float64), read[2]
    if back:
        root, rotation, contact = root[::-1], rotation[::-1], contact[::-1]
    roots, rotations, contacts = [root], [rotation], [contact]
    for _ in range(REPETITIONS - 1):
        turn, place = _heading(rotations[-1][-1, 0]) - _heading(rotation[0, 0]), roots[-1][-1]
        moved, turned = _rotate(root - root[0] * (1.0, 0.0, 1.0), rotation, turn)
        moved = moved + place * (1.0, 0.0, 1.0)
        w = _ramp(count + 1, BLEND_SHARE * step.samples_per_measure)
        turned = np.asarray(quaternion.slerp(rotations[-1][-1][None], turned, w[:, None]), np.float64)
        moved[:, 1] = (1.0 - w) * place[1] + w * moved[:, 1]
        roots, rotations, contacts = [*roots, moved[1:]], [*rotations, turned[1:]], [*contacts, contact[1:]]
    root, rotation = np.concatenate(roots), np.concatenate(rotations)
    root, rotation = _rotate(root - root[0] * (1.0, 0.0, 1.0), rotation, -_heading(rotation[0, 0]))
    rotation = np.asarray(quaternion.align_signs(quaternion.unit(rotation)), np.float64)
    return Clip(
        step.clip.name, np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32),
        step.clip.sample_rate, np.ascontiguousarray(np.concatenate(contacts)),
    )  # fmt: skip


def _ramp(count: int, size: float) -> Float64:
    """Return a smooth ramp from 0 at the first sample to 1 from `size` samples on."""
    t = np.clip(np.arange(count) / max(size, 1.0), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


def _place_opposite(clip: Clip) -> Clip:
    """Return the clip placed APART in front of a dancer at the origin, facing them."""
    root, rotation = _rotate(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64), np.pi)
    root[:, 2] += PARTNER_DISTANCE
    return Clip(
        clip.name, np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32),
        clip.sample_rate, clip.contact,
    )  # fmt: skip


def _rotate(root: Float, rotation: Float, yaw: float) -> tuple[Float64, Float64]:
    """Return root and rotations rotated about the vertical through the origin by `yaw` [rad]."""
    z = np.exp(1j * yaw) * (root[:, 2] + 1j * root[:, 0])
    turn = np.array((np.cos(0.5 * yaw), 0.0, np.sin(0.5 * yaw), 0.0))
    rotation = np.array(rotation, np.float64)
    rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
    return np.asarray(np.stack((z.imag, root[:, 1], z.real), axis=1), np.float64), np.asarray(rotation, np.float64)


def _heading(rotation: Float) -> float:
    """Return the heading of the hips' rotation [rad]."""
    ahead = quaternion.rotate(rotation, np.array((0.0, 0.0, 1.0)))
    return float(np.arctan2(ahead[0], ahead[2]))


BEND_ANGLES: Final = (0.0, 0.5, -0.5, 1.0, -1.0)
"""Turns of the path in a measure, towards +x [rad]."""
BLENDED_STRIDES: Final = 2
"""Number of strides from each sketched one up to the next longer one, including the first."""
EXTRAPOLATION: Final = 1.7
"""Extrapolation factor of the longest stride from the second longest sketched one, where 1 is the longest."""
MAX_SIDEWAYS: Final = 0.1
"""A step that goes this far sideways or backward in a measure is not a forward walk [m]."""


def sketched_walks(clips: Sequence[StepClip], *, unit_beats: int) -> Units:
    """Return units of forward walking from those `clips` that walk forward; ValueError if none does."""
    ahead: dict[str, list[tuple[float, StepClip, Clip]]] = {}
    for step in clips:
        clip = repeat_step(step, back=False)
        way = clip.root_position[round(step.measures * step.samples_per_measure)].astype(np.float64)
        if abs(way[0]) < MAX_SIDEWAYS * step.measures and way[2] > -MAX_SIDEWAYS * step.measures and not step.mirrored:
            ahead.setdefault(step.step, []).append((float(way[2]) / step.measures, step, clip))
    found = [one for name in sorted(ahead) for one in _walk_examples(name, ahead[name], unit_beats)]
    if not found:
        raise ValueError("no step walks forward")
    return cut_units(found)


def _walk_examples(name: str, known: list[tuple[float, StepClip, Clip]], unit_beats: int) -> list[Example]:
    """Return examples of one step from its `known` strides, with lengths [m] per measure."""
    if max(way for way, _, _ in known) < MAX_SIDEWAYS:
        return []
    known = sorted(known, key=lambda one: one[0])
    beat = known[0][1].samples_per_measure / known[0][1].beats_per_measure
    cuts = np.asarray(np.arange(REPETITIONS * known[0][1].beats // unit_beats) * beat * unit_beats, np.float64)
    strides = [known[-1][2]]
    for (_, _, one), (_, _, other) in pairwise(known):
        if one.sample_count == other.sample_count:
            strides += [_blend_clips(one, other, n / BLENDED_STRIDES) for n in range(BLENDED_STRIDES)]
    if len(known) > 1 and known[-2][2].sample_count == known[-1][2].sample_count:
        strides.append(_blend_clips(known[-2][2], known[-1][2], EXTRAPOLATION))
    bent = [_bend_path(clip, bend / (beat * known[0][1].beats_per_measure)) for clip in strides for bend in BEND_ANGLES]
    return [Example(name, path_cloud(clip), ends_cloud(clip), clip, cuts, np.zeros(0)) for clip in bent]


def _blend_clips(one: Clip, other: Clip, share: float) -> Clip:
    root = (1.0 - share) * one.root_position + share * other.root_position
    rotation = quaternion.slerp(one.rotation, other.rotation, np.full(one.rotation.shape[:2], share))
    return Clip(
        one.name, np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32), one.sample_rate,
        one.contact & other.contact,
    )  # fmt: skip


def _bend_path(clip: Clip, turn: float) -> Clip:
    """Return the clip on a path that turns by `turn` [rad] per sample, with planted feet locked."""
    if turn == 0.0:
        return clip
    yaw = turn * np.arange(clip.sample_count)
    root = clip.root_position.astype(np.float64)
    steps = np.diff(root[:, 2] + 1j * root[:, 0]) * np.exp(0.5j * (yaw[1:] + yaw[:-1]))
    place = np.concatenate(([0.0], np.cumsum(steps)))
    rotation = clip.rotation.astype(np.float64)
    zero = np.zeros_like(yaw)
    about = np.stack((np.cos(0.5 * yaw), zero, np.sin(0.5 * yaw), zero), axis=-1)
    rotation[:, 0] = quaternion.mul(about, rotation[:, 0])
    bent = Clip(
        clip.name, np.ascontiguousarray(np.stack((place.imag, root[:, 1], place.real), axis=1), np.float32),
        np.ascontiguousarray(rotation, np.float32), clip.sample_rate, clip.contact,
    )  # fmt: skip
    return enforce_feet(bent)
