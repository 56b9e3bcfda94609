"""Amplitude variation of the upper body (T058-T060), and combination of lower and upper body from two clips (T044)."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.base.scalar_kernels import ease
from live.motion.clip import Clip, read_clip
from live.motion.editing.turn_insertion import BLEND_WINDOW
from live.motion.quaternion import mean_rotation, scale_about_mean
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip, check_same_step, corresponding_samples

LOWER: Final = tuple(
    joint
    for joint, name in enumerate(SKELETON.names)
    if name == "hips" or name.endswith(("UpperLeg", "LowerLeg", "Foot", "Toes"))
)
"""Joints of the lower body: hips and legs."""
UPPER: Final = tuple(joint for joint in range(SKELETON.joint_count) if joint not in LOWER)
"""Joints of the upper body: the spine and all joints above."""


def combine(lower: StepClip, upper: StepClip) -> StepClip:
    """Return the step `lower` with the rotations of all joints from the spine upwards taken from `upper` (T044).

    Both are the same step, so they are aligned by the measure. Structure, path, contacts and samples are those of
    `lower`. ValueError for clips of different steps.
    """
    check_same_step(lower, upper)
    rotation = lower.clip.rotation.copy()
    if lower.first == upper.first and lower.samples_per_measure == upper.samples_per_measure:
        count = min(lower.clip.sample_count, upper.clip.sample_count)
        rotation[:count, UPPER] = upper.clip.rotation[:count, UPPER]
        rotation[count:, UPPER] = upper.clip.rotation[count - 1, UPPER]
    else:
        rotation[:, UPPER] = np.asarray(read_clip(upper.clip, corresponding_samples(upper, lower))[1], np.float32)[
            :, UPPER
        ]
    name = f"{lower.clip.name}, upper body of {upper.clip.name}"
    return replace(lower, clip=replace(lower.clip, name=name, rotation=rotation))


R_MAX: Final = 0.2
"""Half of the range of the factor; more looks unnatural (T058)."""
SPACING: Final = 1.0
"""Measures between the sparse points of a sequence (T059)."""


def draw_factors(rng: np.random.Generator, count: int, *, r_max: float = R_MAX) -> Float64:
    """Factors (count,), each 1 - r_max, 1 or 1 + r_max with equal chance: one for each measure (T060 as corrected).

    Only these three, because values between are hardly visible. ValueError unless 0 <= r_max < 1.
    """
    if not 0.0 <= r_max < 1.0:
        raise ValueError(f"r_max {r_max}: 0 to 1 expected")
    return rng.choice((1.0 - r_max, 1.0, 1.0 + r_max), count)


def draw_sequence_factors(
    rng: np.random.Generator, measures: float, *, spacing: float = SPACING, r_max: float = R_MAX
) -> tuple[Float64, Float64]:
    """Positions [measures] and factors, (K,) each: sparse points from 0 to beyond the end, factors in pairs (T059)."""
    if not (measures >= 0.0 and spacing > 0.0):
        raise ValueError(f"measures {measures}, spacing {spacing}: too small")
    pairs = int(np.ceil((measures / spacing + 1.0) / 2.0)) + 1
    return spacing * np.arange(2.0 * pairs), np.repeat(draw_factors(rng, pairs, r_max=r_max), 2)


def factor_at(places: Float64, factors: Float64, x: npt.ArrayLike) -> Float64:
    """Return r(x): PCHIP through the points, constant beyond the ends; it never leaves their range (T059)."""
    from scipy.interpolate import PchipInterpolator

    held = np.clip(np.asarray(x, np.float64), places[0], places[-1])
    return np.asarray(PchipInterpolator(places, factors)(held))


def scale_clip(clip: Clip, factor: npt.ArrayLike, segment: slice = slice(None)) -> Clip:
    """Return the clip with q' = q_mean (q_mean⁻¹ q)^r in all joints from the spine upwards (T058).

    `factor` is r, a single value or one per sample (T,); q_mean is each joint's mean over `segment`. Hips, legs, root
    and contacts stay: scaled legs would slide, sink or float (T051).
    """
    upper = clip.rotation[:, UPPER].astype(np.float64)
    mean = mean_rotation(upper[segment])
    rotation = clip.rotation.copy()
    r = np.broadcast_to(np.asarray(factor, np.float64), (clip.sample_count,))
    rotation[:, UPPER] = scale_about_mean(mean, upper, r[:, None])
    return replace(clip, rotation=rotation)


def scale_step(step: StepClip, factors: float | Sequence[float] | Float64, *, window: float = BLEND_WINDOW) -> StepClip:
    """Return the step scaled by one factor, or one per measure (T060); the mean is taken over its measures.

    Between two measures of different factors r changes with easing during the blend `window` (share of a measure)
    before the measure line, like the blend between two clips of a graph. ValueError unless there is one factor per
    measure.
    """
    values = np.atleast_1d(np.asarray(factors, np.float64))
    if values.size == 1:
        values = np.repeat(values, step.measures)
    if values.shape != (step.measures,):
        raise ValueError(f"{values.size} factors for the {step.measures} measures of the step {step.step!r}")
    place = (np.arange(step.clip.sample_count) - step.first) / step.samples_per_measure
    measure = np.clip(np.floor(place).astype(np.int64), 0, step.measures - 1)
    following = np.minimum(measure + 1, step.measures - 1)
    into = np.clip((place - measure - 1.0) / max(window, 1e-9) + 1.0, 0.0, 1.0)
    share = np.array([ease(float(value)) for value in into])
    r = (1.0 - share) * values[measure] + share * values[following]
    return replace(step, clip=scale_clip(step.clip, r, _measures(step)))


def scale_sequence(step: StepClip, places: Float64, factors: Float64) -> StepClip:
    """Return the step scaled by r(x) of `factor_at`, x in measures from its first downbeat (T059)."""
    place = (np.arange(step.clip.sample_count) - step.first) / step.samples_per_measure
    return replace(step, clip=scale_clip(step.clip, factor_at(places, factors, place), _measures(step)))


def _measures(step: StepClip) -> slice:
    """Return the samples of the step's measures, without lead-in and tail."""
    return slice(round(step.first), round(step.first + step.measures * step.samples_per_measure))
