"""Rotation insertion: turns a step about the supporting foot during single support (T048-T050).

`insert_rotation` edits a clip sample by sample. `SupportTurns` is the same in closed form, for any fraction of a
measure and any angle. A point of the stage plane is the complex number z + i x, so turning by `yaw` is multiplying by
exp(i yaw). During a support the turn is about the ball of its foot, which earlier turns have moved. The motion that
maps a clip's point p to exp(i angle share) p + D is therefore a sum over the supports of integrals in closed form.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float, Float32, Float64, Int32
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.editing.foot_correction import Feet, find_feet
from live.motion.editing.support_kernels import support_rows
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.skeleton import SOLE_BELOW_ANKLE
from live.motion.step_clip import StepClip, measured_direction, measured_distance

LIFT_THRESHOLD: Final = 0.20
"""Single support is where the feet's heights differ by more than this share of the largest difference (T048)."""
MIN_SUPPORT_SECONDS: Final = 0.1
"""Supports shorter than this [s] are errors (T048). The thesis states 10 frames without a rate; its OptiTrack cameras
and its N = 100 frames per measure fit 100 frames per second."""
MIN_LIFT: Final = 0.01
"""If the feet's heights never differ by more than this [m], no foot is lifted and the relative threshold is noise."""


@dataclass(frozen=True, slots=True)
class Support:
    """Single support: the samples `start` to `stop` (exclusive), in which only `foot` carries weight."""

    start: int
    stop: int
    foot: int
    """0 left, 1 right: the lower foot (T049)."""
    point: tuple[float, float]
    """Mean position of the foot's ball on the floor (x, z) [m]."""

    @property
    def samples(self) -> int:
        """Length in samples."""
        return self.stop - self.start


def height_difference(feet: Feet) -> Float:
    """Return d(t) = |height_R - height_L| [m] of the soles, shape (T,) (T048: of heights, not of positions)."""
    height = feet.height
    return np.asarray(np.abs(height[:, 1] - height[:, 0]))


def find_supports(
    feet: Feet, sample_rate: float, start: int, stop: int, *, last: int | None = None, contact: Bool | None = None
) -> list[Support]:
    """Return the single supports among the samples `start` to `stop` (exclusive), in order (T048).

    The threshold is 20 % of the largest d(t) in that range, which is one measure: "we are editing the motions at each
    measure". Samples from `last` on (the blend window, T050) count for the threshold but are not selected. A support in
    which the lower foot changes (one foot lands before the other is seen to lift) is split there. Samples where
    `contact` (T, 2), the clip's annotation, has both feet on the floor are no single support: a dragging foot differs
    in height from the other and would be moved by the turn.
    """
    difference = height_difference(feet)[start:stop]
    if difference.size == 0 or difference.max() < MIN_LIFT:
        return []
    chosen = difference > LIFT_THRESHOLD * difference.max()
    if last is not None:
        chosen[max(last - start, 0) :] = False
    if contact is not None:
        chosen &= ~contact[start:stop].all(axis=1)
    lower = np.argmin(feet.height[start:stop], axis=1)
    state = np.where(chosen, 1 + lower, 0)
    edges = np.flatnonzero(np.diff(state, prepend=0, append=0))
    shortest = MIN_SUPPORT_SECONDS * sample_rate
    supports = []
    for begin, end in pairwise(edges):
        if state[begin] == 0 or end - begin < shortest - 1e-9:
            continue
        foot = int(state[begin]) - 1
        x, _, z = feet.ball[start + begin : start + end, foot].mean(axis=0)
        supports.append(Support(int(start + begin), int(start + end), foot, (float(x), float(z))))
    return supports


Complex = npt.NDArray[np.complex128]

MAX_SEGMENTS: Final = 8
"""Maximum segments per measure; the longest supports are kept."""


@dataclass(frozen=True, slots=True, eq=False)
class SupportTurns:
    """Segments of a measure in which a dancer may turn, with pivots; every array has shape (..., 8).

    Leading axes are measures or dancers. Unused segments come last and have start = stop = 1 and weight 0. Every
    measure has at least one segment (see `support_turns`), so its weights sum to 1.
    """

    start: Float64
    """Fraction of the measure at which the segment begins, in [0, 1]."""
    stop: Float64
    """Fraction at which it ends; segments are in order and do not overlap."""
    weight: Float64
    """Share of the total angle turned in the segment."""
    point: Float64
    """Position of the supporting foot's ball at the segment start, x and z [m] in clip axes; shape (..., 8, 2)."""
    point_stop: Float64
    """The same at the end of the segment: recorded feet creep, and roll from heel to toe."""
    softness: Float64
    """Share of the segment for acceleration, and again for deceleration: 0 (uniform, T049) to 0.5."""

    def select(self, rows: npt.NDArray[np.integer]) -> "SupportTurns":
        """Return the rows `rows` (A,) of the first axis: from the nodes of a library to the dancers."""
        return SupportTurns(*(getattr(self, name)[rows] for name in self.__slots__))

    def rows(self) -> Float64:
        """Return one row per segment, (..., 8, 8): start, stop, weight, x, z at its start and at its stop, softness."""
        single = (self.start, self.stop, self.weight, self.softness)
        start, stop, weight, softness = (array[..., None] for array in single)
        return np.concatenate((start, stop, weight, self.point, self.point_stop, softness), axis=-1)

    @property
    def max_speed(self) -> Float64:
        """Maximum turning speed in total angles per measure, (...); high for a turn within one short support."""
        span = np.maximum(self.stop - self.start, 1e-12)
        return np.asarray(np.max(self.weight / span / (1.0 - self.softness), axis=-1))

    def share(self, fraction: npt.ArrayLike) -> Float64:
        """Return the share of the angle turned after `fraction` (...) of the measure: 0 to 1, never decreasing."""
        return np.asarray(np.sum(self.weight * self._progress(fraction), axis=-1))

    def displacement(self, fraction: npt.ArrayLike, angle: npt.ArrayLike) -> Float64:
        """Return the displacement that keeps the supporting foot in place: x, z [m] in the clip's own axes, (..., 2).

        With yaw = `angle` · share(`fraction`) a point of the clip goes to turned(point, yaw) + displacement, and the
        body's heading grows by yaw. If the clip is placed on the stage with another yaw, turn the
        displacement by that one and add yaw to those of path and body. `fraction` and `angle` [rad]
        broadcast against the leading axes.
        """
        progress = self._progress(fraction)
        whole = np.asarray(angle, np.float64)[..., None] * self.weight
        before = np.cumsum(whole * progress, axis=-1) - whole * progress  # turned in earlier segments
        turn = whole * progress
        start = self.point[..., 1] + 1j * self.point[..., 0]
        way = self.point_stop[..., 1] + 1j * self.point_stop[..., 0] - start
        mean = np.exp(0.5j * turn) * np.sinc(turn / (2.0 * np.pi))  # of exp(i φ) for φ from 0 to turn
        moved = start - np.exp(1j * turn) * (start + way * progress) + way * progress * mean
        total = np.sum(np.exp(1j * before) * moved, axis=-1)
        return np.stack((total.imag, total.real), axis=-1)

    def _progress(self, fraction: npt.ArrayLike) -> Float64:
        """Return the progress of each segment's turn, 0 to 1, shape (..., 8)."""
        span = np.maximum(self.stop - self.start, 1e-12)
        passed = np.clip((np.asarray(fraction, np.float64)[..., None] - self.start) / span, 0.0, 1.0)
        return ease_progress(passed, self.softness)


def ease_progress(passed: npt.ArrayLike, softness: npt.ArrayLike) -> Float64:
    """Return an ease from 0 to 1 as `passed` goes from 0 to 1: linear for softness 0, else with linear speed ramps.

    `softness` is the share of time of each of the two ramps, at most 0.5.
    """
    passed, softness = np.broadcast_arrays(np.asarray(passed, np.float64), np.asarray(softness, np.float64))
    safe = np.maximum(softness, 1e-9)
    edge = np.minimum(np.minimum(passed, 1.0 - passed), safe)  # distance from the nearer end, while in its ramp
    ramp = 0.5 * edge * edge / safe
    inner = np.clip(passed, safe, 1.0 - safe)
    risen = (inner - safe + np.where(passed < 0.5, ramp, safe - ramp)) / (1.0 - safe)
    return np.asarray(np.where(softness > 1e-9, risen, passed))


def stack_turns(turns: Sequence[SupportTurns]) -> SupportTurns:
    """Stack N measures into arrays of shape (N, 8), one row per node of a library."""
    return SupportTurns(*(np.stack([getattr(one, name) for one in turns]) for name in SupportTurns.__slots__))


BLEND_WINDOW: Final = 0.2
"""Share of a measure before its end without rotation, because the blend into the next one is there (T050):
the thesis' 20 frames (T036) of 100 per measure."""
_BASE_SPEED: Final = 0.02
"""Speed [m/s] added to that of the feet, so that the angle is spread evenly if no foot moves."""


@dataclass(frozen=True, slots=True, eq=False)
class _TurnSegment:
    """The samples `start` to `stop` (exclusive), in which `weight` of the angle is turned about `pivot` (n, 2)."""

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
    """Return the step turned by `angle` [rad, positive towards +x] during one measure (from 0) or all of them.

    Each of the N single-support samples turns the rest of the sequence by angle / N about the ball of the supporting
    foot, so that the foot stays (T049). The last `window` (share of a measure) of each measure has no rotation (T050).
    `softness` above 0 (to 0.5) accelerates and decelerates the turn of each support over that share of it. Without
    single support the angle is spread over the measure in proportion to the speed of the feet, about the midpoint
    between them. ValueError for a measure that the step does not have, a window outside [0, 0.9] or a softness
    outside [0, 0.5].
    """
    _check(step, measure, window, softness)
    stretches = _segments(step, find_feet(step.clip), measure, window)
    increment = np.zeros(step.clip.sample_count)
    pivot = np.zeros((step.clip.sample_count, 2))
    for stretch in stretches:
        edges = np.linspace(0.0, 1.0, stretch.stop - stretch.start + 1)
        increment[stretch.start : stretch.stop] += angle * stretch.weight * np.diff(ease_progress(edges, softness))
        pivot[stretch.start : stretch.stop] = stretch.pivot
    turned = replace(step, clip=turn_about(step.clip, increment, pivot))
    return replace(turned, direction=measured_direction(turned), distance_m=measured_distance(turned))


def turn_about(clip: Clip, increment: Float, pivot: Float) -> Clip:
    """Turn everything from each sample on by `increment` (T,) [rad] about `pivot` (T, 2) (T049).

    `pivot` holds x and z [m] in the given clip; earlier turns move it. The loop "rotate, then translate so that the
    pivot stays, then continue with the rest" is a cumulative sum of complex numbers.
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
    """Return the segments and pivots for turning one measure (from 0) of a step by any angle; arrays of shape (8,).

    Equivalent to `insert_rotation`, but as a function of the fraction of the measure; the ball of a supporting foot
    moves straight from its first to its last position. Measures without single support get eight segments outside the
    blend window, weighted by the speed of the feet, about the midpoint between the feet (softness 0). `feet` are those
    of the clip, if already computed. ValueError as for `insert_rotation`.
    """
    _check(step, measure, window, softness)
    feet = find_feet(step.clip) if feet is None else feet
    supports = [(measure, support) for support in _supports(step, feet, measure, window)]
    stretches = _segments_of(step, feet, (measure,), window, supports)
    single = bool(supports)
    columns = np.zeros((8, MAX_SEGMENTS))
    columns[:2] = 1.0
    begin = step.first + measure * step.samples_per_measure
    for n, stretch in enumerate(stretches):
        # a sample's turn happens between the previous sample and this one
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


def support_turn_rows(
    clips: Sequence[StepClip],
    clip: Int32,
    begin: Float64,
    size: Float64,
    ankle: Float32,
    ball: Float32,
    *,
    window: float,
    softness: float,
) -> tuple[Float64, Float64]:
    """Return the support turns of N measures as rows, (N, 8, 8), and their peak speeds, (N,).

    See `support_turns` and `SupportTurns.rows`. Measure n is in `clips`[`clip`[n]]; it begins at the sample begin[n] of
    all clips one after another, and lasts size[n] samples. `ankle` and `ball` (S, 2, 3) [m] of both feet: all samples.
    """
    starts = np.cumsum([0, *(step.clip.sample_count for step in clips)])
    contact = np.concatenate([step.clip.contact for step in clips])
    rate = np.array([step.clip.sample_rate for step in clips])
    rows, found = np.zeros((len(clip), MAX_SEGMENTS, 8)), np.zeros(len(clip), np.bool_)
    support_rows(
        ankle, ball, contact, SOLE_BELOW_ANKLE, TOES_OVER_SOLE, begin, size, MIN_SUPPORT_SECONDS * rate[clip],
        MIN_LIFT, LIFT_THRESHOLD, window, softness, rows, found,
    )  # fmt: skip
    for n in np.flatnonzero(~found):  # turned by the speed of both feet
        step, own = clips[clip[n]], slice(starts[clip[n]], starts[clip[n] + 1])
        alone = replace(step, first=float(begin[n] - own.start), samples_per_measure=float(size[n]), measures=1)
        feet = Feet(ankle[own].astype(np.float64), ball[own].astype(np.float64))
        rows[n] = support_turns(alone, 0, window=window, softness=softness, feet=feet).rows()
    span = np.maximum(rows[..., 1] - rows[..., 0], 1e-12)
    return rows, np.asarray(np.max(rows[..., 2] / span / (1.0 - rows[..., 7]), axis=-1))


def _line_through(points: Float) -> tuple[Float, Float]:
    """Return the ends of the least-squares line through `points` (n, 2)."""
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
    """Return the first sample of a measure, of its blend window, and after the measure."""
    begin = step.first + measure * step.samples_per_measure
    ends = (begin, begin + (1.0 - window) * step.samples_per_measure, begin + step.samples_per_measure)
    first, last, stop = (int(np.ceil(end - 1e-9)) for end in ends)
    return first, last, stop


def _supports(step: StepClip, feet: Feet, measure: int, window: float) -> list[tuple[int, int, int]]:
    first, last, stop = _range(step, measure, window)
    found = find_supports(feet, step.clip.sample_rate, first, stop, last=last, contact=step.clip.contact)
    kept = sorted(found, key=lambda support: -support.samples)[:MAX_SEGMENTS]
    return [(s.start, s.stop, s.foot) for s in sorted(kept, key=lambda support: support.start)]


def _segments(step: StepClip, feet: Feet, measure: int | None, window: float) -> list[_TurnSegment]:
    """Return the segments of one measure or of all; weights sum to 1 and are the shares of the N samples (T049)."""
    measures = range(step.measures) if measure is None else (measure,)
    supports = [(n, support) for n in measures for support in _supports(step, feet, n, window)]
    return _segments_of(step, feet, measures, window, supports)


def _segments_of(
    step: StepClip,
    feet: Feet,
    measures: Sequence[int],
    window: float,
    supports: list[tuple[int, tuple[int, int, int]]],
) -> list[_TurnSegment]:
    total = sum(stop - start for _, (start, stop, _) in supports)
    if not supports:
        return [stretch for n in measures for stretch in _segments_by_speed(step, feet, n, window, 1.0 / len(measures))]
    ball = feet.ball[..., (0, 2)]
    return [
        _TurnSegment(start, stop, (stop - start) / total, ball[start:stop, foot]) for _, (start, stop, foot) in supports
    ]


def _segments_by_speed(step: StepClip, feet: Feet, measure: int, window: float, weight: float) -> list[_TurnSegment]:
    """Return eight segments of a measure without single support, weighted by the mean speed of the feet."""
    first, last, _ = _range(step, measure, window)
    places = np.linspace(first, last, MAX_SEGMENTS + 1).round().astype(int)
    seconds = 1.0 / step.clip.sample_rate
    speed = np.linalg.norm(np.gradient(feet.ball, axis=0), axis=-1).mean(axis=1) / seconds + _BASE_SPEED
    middle = feet.ball.mean(axis=1)[:, (0, 2)]
    ways = [(a, b, float(speed[a:b].sum())) for a, b in pairwise(places) if b > a]
    total = sum(way for _, _, way in ways)
    return [_TurnSegment(a, b, weight * way / total, middle[a:b]) for a, b, way in ways]
