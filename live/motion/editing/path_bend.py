"""Path bends: a step that goes shorter and turns on its way, with planted feet (motion path editing).

Gleicher (2001, "Motion path editing") bends the path of a recorded motion. Here the feet keep what makes a stance:
each stance is moved as a whole, by the transform of the path at its middle, and a swing leads from one transform to the
next. So planted feet stay planted, and turns are danced over the supports (T048-T050), a little in every step.
"""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.curve import smoothstep
from live.motion.editing.foot_correction import (
    ANKLES,
    LEG_LENGTH,
    MAX_LEG_SHARE,
    UPPER_LEGS,
    bend_swings,
    lower_hips,
    solve_legs,
)
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import unmirrored_name
from live.motion.quality.metrics import velocity_changes
from live.motion.step_clip import StepClip, measured_direction, measured_distance, travel

MARK: Final = ", path "
TREND_S: Final = 0.3
"""Width [s] of the Gaussian that separates the path from the sway of the hips, which is neither stretched nor bent."""
LONG_TRAVEL: Final = 1.2
SHORT_TRAVEL: Final = 0.6
"""A measure that travels farther than this [m] gets two shorter paths, or one, besides its own."""
LONG_SCALES: Final = (1.0, 0.6, 0.25)
SHORT_SCALES: Final = (1.0, 0.5)
MIN_SWING: Final = 0.1
"""A foot that swings less far [m] is led by the time that has passed, not by the way."""
MAX_JERK: Final = 1.5
"""A bent path is not used if a joint's velocity changes more than so many times as much as in the recording ..."""
MIN_JERK: Final = 0.3
"""... or as this [m/s], if it hardly changes there."""
BEND: Final = math.radians(50.0)
"""Turn of the bent paths of a step that goes straight on [rad per measure]."""
STRAIGHT: Final = math.radians(60.0)
"""A step that turns more than this [rad] gets paths that turn half as far, and not at all, instead."""


def path_variants(step: StepClip) -> list[StepClip]:
    """Return copies of a step that travels, on shorter and bent paths; none of one that stays in place."""
    away = float(np.hypot(*travel(step))) / step.measures
    if away < SHORT_TRAVEL:
        return []
    own = _turn(step)
    turns = (0.0, -0.5 * own, -own) if abs(own) > STRAIGHT else (0.0, -BEND * step.measures, BEND * step.measures)
    scales = LONG_SCALES if away > LONG_TRAVEL else SHORT_SCALES
    bent = [
        bend_path(step, scale=scale, turn=turn) for scale in scales for turn in turns if (scale, turn) != (1.0, 0.0)
    ]
    usual = np.maximum(_jerks(step.clip), MIN_JERK)
    return [one for one in bent if (_jerks(one.clip) / usual).max() <= MAX_JERK]


def source_name(name: str) -> str:
    """Return the name of the clip whose path was changed to that of the clip called `name`."""
    plain = unmirrored_name(name)
    return plain.partition(MARK)[0] + name[len(plain) :]


def bend_path(step: StepClip, *, scale: float, turn: float) -> StepClip:
    """Return the step with its path scaled, and turned by `turn` [rad] evenly from its beginning to its end.

    The place and heading at which it begins stay.
    """
    from scipy.ndimage import gaussian_filter1d

    clip = step.clip
    root, rotation = clip.root_position.astype(np.float64), clip.rotation.astype(np.float64)
    position, world = forward_kinematics(root, rotation)
    at = np.arange(clip.sample_count)
    angle = turn * smoothstep((at - step.first) / (step.measures * step.samples_per_measure))
    path = gaussian_filter1d(root[:, (0, 2)], TREND_S * clip.sample_rate, axis=0, mode="nearest")
    middle = 0.5 * (angle[1:] + angle[:-1])
    moved = np.concatenate([np.zeros((1, 2)), np.cumsum(scale * _turned(np.diff(path, axis=0), middle), axis=0)])
    start = min(int(step.first), clip.sample_count - 1)
    moved += path[start] - moved[start]
    new_root: Float = root.copy()
    new_root[:, (0, 2)] = moved + _turned(root[:, (0, 2)] - path, angle)
    turned = rotation.copy()
    turned[:, 0] = quaternion.mul(_about_up(angle), rotation[:, 0])
    ankles: Float = position[:, ANKLES].copy()
    feet = world[:, ANKLES].copy()
    for foot in range(2):
        pivot = _pivots(clip.contact[:, foot], ankles[:, foot, ::2])
        own, new, yaw = (_at(values, pivot) for values in (path, moved, angle))
        ankles[:, foot, ::2] = new + _turned(ankles[:, foot, ::2] - own, yaw)
        feet[:, foot] = quaternion.mul(_about_up(yaw), feet[:, foot])
    leg = np.linalg.norm(position[:, UPPER_LEGS] - position[:, ANKLES], axis=-1)
    longest = np.where(clip.contact, np.maximum(leg, MAX_LEG_SHARE * LEG_LENGTH), np.inf)
    new_root = lower_hips(new_root, turned, ankles, longest, clip.sample_rate)
    ankles = bend_swings(new_root, turned, ankles, clip.contact, clip.sample_rate)
    legs = quaternion.align_signs(solve_legs(new_root, turned, ankles, feet))
    plain = unmirrored_name(clip.name)
    name = f"{plain}{MARK}{scale:.0%}, turned {math.degrees(turn):+.0f}{clip.name[len(plain) :]}"
    bent = replace(
        step,
        clip=Clip(
            name, np.ascontiguousarray(new_root, np.float32), np.ascontiguousarray(legs, np.float32),
            clip.sample_rate, clip.contact,
        ),
    )  # fmt: skip
    return replace(bent, direction=measured_direction(bent), distance_m=measured_distance(bent))


def _jerks(clip: Clip) -> Float:
    """Return the largest changes of each joint's velocity, but for two in a thousand [m/s], (J,)."""
    position, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    return np.asarray(np.percentile(velocity_changes(position, clip.sample_rate), 99.8, axis=0))


def _turn(step: StepClip) -> float:
    """Return how far the hips turn from the first to the last measure line [rad], -π to π."""
    ends = np.array((step.first, step.first + step.measures * step.samples_per_measure)).astype(np.int64)
    ends = np.minimum(ends, step.clip.sample_count - 1)
    ahead = quaternion.rotate(step.clip.rotation[ends, 0].astype(np.float64), np.array((0.0, 0.0, 1.0)))
    one, other = np.arctan2(ahead[:, 0], ahead[:, 2])
    return float(np.arctan2(np.sin(other - one), np.cos(other - one)))


def _turned(vectors: Float, yaw: Float) -> Float:
    c, s = np.cos(yaw), np.sin(yaw)
    x, z = vectors[:, 0], vectors[:, 1]
    return np.stack([x * c + z * s, z * c - x * s], axis=1)


def _about_up(yaw: Float) -> Float:
    return quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), yaw)


def _at(values: Float, at: Float) -> Float:
    """Return `values` (T, ...) at fractional samples `at` (n,)."""
    low = np.minimum(at.astype(np.int64), len(values) - 2)
    part = (at - low).reshape(-1, *(1,) * (values.ndim - 1))
    return np.asarray(values[low] + part * (values[low + 1] - values[low]))


def _pivots(stands: Bool, place: Float) -> Float:
    """Return for each sample of `stands` (T,) the sample whose transform moves the foot, (T,): the middle of its
    stance, in a swing as far between the middles before and after as the foot at `place` (T, 2) [m] has come."""
    at = np.arange(len(stands), dtype=np.float64)
    edges = np.flatnonzero(np.diff(stands.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    if not len(edges):
        return at
    pivot = at.copy()
    middle = 0.5 * (edges[:, 0] + edges[:, 1] - 1)
    for (begin, end), own in zip(edges, middle, strict=True):
        pivot[begin:end] = own
    pivot[: edges[0, 0]], pivot[edges[-1, 1] :] = middle[0], middle[-1]
    for k in range(len(edges) - 1):
        off, on = edges[k, 1] - 1, edges[k + 1, 0]
        share = smoothstep((at[off : on + 1] - off) / (on - off))
        way = place[on] - place[off]
        if np.hypot(*way) > MIN_SWING:
            share = np.clip((place[off : on + 1] - place[off]) @ way / (way @ way), 0.0, 1.0)
        pivot[off : on + 1] = middle[k] + share * (middle[k + 1] - middle[k])
    return np.clip(pivot, 0.0, len(stands) - 1.0)
