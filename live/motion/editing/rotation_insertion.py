"""Rotation insertion: a step is turned while one foot carries, and that foot holds its place (T048-T050)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.editing.feet import Feet, find_feet
from live.motion.editing.support import find_supports
from live.motion.editing.support_turns import MAX_SEGMENTS, SupportTurns, soft_progress
from live.motion.step_clip import StepClip
from live.motion.step_figures import measured_direction, measured_distance

Float = npt.NDArray[np.floating]

BLEND_WINDOW: Final = 0.2
"""Share of a measure before its end that takes no rotation, because the blend into the next one lies there (T050):
the thesis' 20 frames (T036) of 100 for a measure."""
_STILL: Final = 0.02
"""Speed [m/s] that is added to the feet's, so that the angle is spread evenly where no foot moves at all."""


@dataclass(frozen=True, slots=True, eq=False)
class _Stretch:
    """The samples `start` to `stop` (exclusive), over which `weight` of the angle is turned about `pivot` (n, 2)."""

    start: int
    stop: int
    weight: float
    pivot: Float


def insert_rotation(
    step: StepClip,
    angle: float,
    *,
    measure: int | None = None,
    window: float = BLEND_WINDOW,
    softness: float = 0.0,
) -> StepClip:
    """The step turned by `angle` [rad, positive towards +x] in the course of one measure (from 0) or of all of them.

    Each of the N samples in which one foot alone carries turns the whole rest of the sequence by angle / N about the
    ball of that foot, so that the foot stays (T049); the last `window` (share of a measure) of each measure takes no
    rotation (T050). `softness` above 0 (to 0.5) lets the turn of each support speed up and slow down over that share
    of it. Where no foot ever carries alone, the angle is spread over the measure as fast as the feet move, about
    their middle. ValueError for a measure that the step does not have, a window outside [0, 0.9] or a softness
    outside [0, 0.5].
    """
    _check(step, measure, window, softness)
    stretches = _stretches(step, find_feet(step.clip), measure, window)
    increment = np.zeros(step.clip.sample_count)
    pivot = np.zeros((step.clip.sample_count, 2))
    for stretch in stretches:
        edges = np.linspace(0.0, 1.0, stretch.stop - stretch.start + 1)
        increment[stretch.start : stretch.stop] += angle * stretch.weight * np.diff(soft_progress(edges, softness))
        pivot[stretch.start : stretch.stop] = stretch.pivot
    turned = replace(step, clip=turn_about(step.clip, increment, pivot))
    return replace(turned, direction=measured_direction(turned), distance_m=measured_distance(turned))


def turn_about(clip: Clip, increment: Float, pivot: Float) -> Clip:
    """Turn everything from each sample on by `increment` (T,) [rad] about `pivot` (T, 2), as it lies by then (T049).

    `pivot` holds x and z [m] in the given clip; what earlier samples have turned carries it along. The loop
    "rotate, then translate so that the pivot stays, then go on with the rest" is a running sum of complex numbers.
    """
    yaw = np.cumsum(increment)
    turned = np.exp(1j * yaw)
    point = pivot[:, 1] + 1j * pivot[:, 0]
    moved = np.cumsum((np.exp(1j * (yaw - increment)) - turned) * point)
    root = clip.root_position.astype(np.float64)
    place = turned * (root[:, 2] + 1j * root[:, 0]) + moved
    rotation = clip.rotation.astype(np.float64)
    rotation[:, 0] = quaternion.mul(quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), yaw), rotation[:, 0])
    return replace(
        clip,
        root_position=np.stack((place.imag, root[:, 1], place.real), axis=1).astype(np.float32),
        rotation=np.ascontiguousarray(rotation, np.float32),
    )


def support_turns(
    step: StepClip, measure: int, *, window: float = BLEND_WINDOW, softness: float = 0.0, feet: Feet | None = None
) -> SupportTurns:
    """Where and about which points one measure (from 0) of a step can be turned by any angle; arrays of shape (8,).

    The same as `insert_rotation` does sample by sample, as a function of the fraction of the measure; the ball of a
    carrying foot goes straight from where it stands first to where it stands last. Measures without single support
    get eight stretches outside the blend window, weighted by how fast the feet move, about the middle between the
    feet (softness 0). `feet` are those of the clip, where the caller has them. ValueError as for `insert_rotation`.
    """
    _check(step, measure, window, softness)
    feet = find_feet(step.clip) if feet is None else feet
    supports = [(measure, support) for support in _supports(step, feet, measure, window)]
    stretches = _stretches_of(step, feet, (measure,), window, supports)
    single = bool(supports)
    columns = np.zeros((8, MAX_SEGMENTS))
    columns[:2] = 1.0
    begin = step.first + measure * step.samples_per_measure
    for n, stretch in enumerate(stretches):
        # a sample's turn happens between the sample before it and itself
        ends = (np.array((stretch.start, stretch.stop)) - 0.5 - begin) / step.samples_per_measure
        first, last = _line_through(stretch.pivot)
        columns[:, n] = (
            *np.clip(ends, 0.0, 1.0 - window),
            stretch.weight,
            *first,
            *last,
            softness if single else 0.0,
        )
    return SupportTurns(
        start=columns[0].copy(),
        stop=columns[1].copy(),
        weight=columns[2].copy(),
        point=np.ascontiguousarray(columns[3:5].T),
        point_stop=np.ascontiguousarray(columns[5:7].T),
        softness=columns[7].copy(),
    )


def _line_through(points: Float) -> tuple[Float, Float]:
    """Ends of the straight way that fits `points` (n, 2) best, in the least squares sense."""
    if len(points) < 3:
        return points[0], points[-1]
    along = np.linspace(-1.0, 1.0, len(points))
    slope = along @ points / (along @ along)
    middle = points.mean(axis=0)
    return middle - slope, middle + slope


def _check(step: StepClip, measure: int | None, window: float, softness: float) -> None:
    if measure is not None and not 0 <= measure < step.measures:
        raise ValueError(f"step {step.step!r} has {step.measures} measures; there is no measure {measure} (from 0)")
    if not 0.0 <= window <= 0.9:
        raise ValueError(f"window {window}: a share of the measure from 0 to 0.9 expected")
    if not 0.0 <= softness <= 0.5:
        raise ValueError(f"softness {softness}: 0 to 0.5 expected")


def _range(step: StepClip, measure: int, window: float) -> tuple[int, int, int]:
    """First sample of a measure, the first one of its blend window, and the first one after it."""
    begin = step.first + measure * step.samples_per_measure
    ends = (begin, begin + (1.0 - window) * step.samples_per_measure, begin + step.samples_per_measure)
    first, last, stop = (int(np.ceil(end - 1e-9)) for end in ends)
    return first, last, stop


def _supports(step: StepClip, feet: Feet, measure: int, window: float) -> list[tuple[int, int, int]]:
    first, last, stop = _range(step, measure, window)
    found = find_supports(feet, step.clip.sample_rate, first, stop, last=last, contact=step.clip.contact)
    kept = sorted(found, key=lambda support: -support.samples)[:MAX_SEGMENTS]
    return [(s.start, s.stop, s.foot) for s in sorted(kept, key=lambda support: support.start)]


def _stretches(step: StepClip, feet: Feet, measure: int | None, window: float) -> list[_Stretch]:
    """Stretches of one measure or of all; weights sum to 1 and are the shares of the N samples (T049)."""
    measures = range(step.measures) if measure is None else (measure,)
    supports = [(n, support) for n in measures for support in _supports(step, feet, n, window)]
    return _stretches_of(step, feet, measures, window, supports)


def _stretches_of(
    step: StepClip,
    feet: Feet,
    measures: Sequence[int],
    window: float,
    supports: list[tuple[int, tuple[int, int, int]]],
) -> list[_Stretch]:
    total = sum(stop - start for _, (start, stop, _) in supports)
    if not supports:
        return [stretch for n in measures for stretch in _by_speed(step, feet, n, window, 1.0 / len(measures))]
    ball = feet.ball[..., (0, 2)]
    return [
        _Stretch(start, stop, (stop - start) / total, ball[start:stop, foot]) for _, (start, stop, foot) in supports
    ]


def _by_speed(step: StepClip, feet: Feet, measure: int, window: float, weight: float) -> list[_Stretch]:
    """Eight stretches of a measure in which no foot carries alone, weighted by the mean speed of the feet."""
    first, last, _ = _range(step, measure, window)
    places = np.linspace(first, last, MAX_SEGMENTS + 1).round().astype(int)
    seconds = 1.0 / step.clip.sample_rate
    speed = np.linalg.norm(np.gradient(feet.ball, axis=0), axis=-1).mean(axis=1) / seconds + _STILL
    middle = feet.ball.mean(axis=1)[:, (0, 2)]
    ways = [(a, b, float(speed[a:b].sum())) for a, b in pairwise(places) if b > a]
    total = sum(way for _, _, way in ways)
    return [_Stretch(a, b, weight * way / total, middle[a:b]) for a, b, way in ways]
