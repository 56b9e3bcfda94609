"""Recognition of danced measures: which step of a library a body danced, whatever its size, place, heading and tempo.

A measure is a cloud of points: some joints at four moments of each beat, on the engine's skeleton, so that the size of
a body counts no more. Two clouds are compared after the turn about the vertical axis and the shift on the floor that
bring them nearest to each other (Kovar, Gleicher and Pighin 2002, "Motion Graphs"; checklist K003). Time is counted in
beats. Steps are tried a little early and late and, mirrored, on the other side.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Complex64, Float, Float32, Float64, Int32
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline
from live.motion.quaternion import align_signs
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip

SAMPLES_PER_BEAT: Final = 4
"""Moments of each beat at which measures are compared."""
_FINE: Final = 4
"""Moments between two of them from which their mean is taken, which takes the jitter of cameras away."""
_SMOOTHING: Final = 4
"""Half width of that mean, in those moments."""
SHIFTS: Final = (-0.25, -0.125, 0.0, 0.125, 0.25)
"""Beats by which a body may be late (above 0) or early."""
TRAVEL_SHARE: Final = 0.5
"""Weight of the way over the floor: another body makes shorter or longer steps."""
POSTURE_SHARE: Final = 0.5
"""Weight of the mean place of each joint, which differs from body to body more than the motion about it."""
MIN_POSES_PER_BEAT: Final = 3.0
"""With fewer poses nothing is recognised."""
MAX_GAP: Final = 1.0
"""Longest gap between two poses [beats]."""
MAX_DISTANCE: Final = 0.09
"""Distance [m] from which on a measure is no step that is known."""
MAX_RATIO: Final = 0.8
"""Largest distance as a share of the measure's own motion: a body that hardly moves is near to every calm step."""
MIN_MOTION: Final = 0.03
"""A body that moves less than this [m] (root mean square over joints and moments) stands still."""
MIN_MARGIN: Final = 0.4
"""The second step has to be farther than the first by this share of its distance: what is between two is neither."""
SURE_MARGIN: Final = 1.0
"""With this share the first is sure."""
_WEIGHTS: Final = {
    "hips": 1.0, "head": 0.7, "leftHand": 1.0, "rightHand": 1.0, "leftLowerArm": 0.8, "rightLowerArm": 0.8,
    "leftLowerLeg": 1.0, "rightLowerLeg": 1.0, "leftFoot": 1.6, "rightFoot": 1.6,
}  # fmt: skip
_JOINTS: Final = np.array([SKELETON.index(name) for name in _WEIGHTS], np.intp)
_WEIGHT: Final = np.array(list(_WEIGHTS.values())) / sum(_WEIGHTS.values())
_SWAPPED: Final = np.array(
    [
        list(_WEIGHTS).index(
            name.replace("left", "right") if name.startswith("left") else name.replace("right", "left")
        )
        for name in _WEIGHTS
    ],
    np.intp,
)
_HIPS: Final = 0
"""Row of the hips among the joints."""


@dataclass(frozen=True, slots=True)
class RecognisedStep:
    """What a body danced in a measure."""

    step: int
    """Index of the step among those of the templates; -1: none that is known."""
    measure: int
    """Which measure of the step it was, from 0."""
    mirrored: bool
    """Whether it was danced on the other side than it was recorded or sketched."""
    confidence: float
    """How sure that is, 0 to 1."""
    distance: float
    """Distance to the nearest step, known or not [m], root mean square over joints and moments."""


UNKNOWN: Final = RecognisedStep(-1, 0, False, 0.0, np.inf)


def _positions(hips: Float, rotation: Float, samples: Float64) -> Float32:
    """Return the joints (M, J, 3) [m] at fractional `samples` (M,) of poses (T, 3) and (T, J, 4).

    The kernels are those that a show has loaded anyway.
    """
    pipeline = PosePipeline(len(samples))
    pipeline.sample[0] = samples
    store = ClipStore.of(np.ascontiguousarray(hips, np.float32), np.ascontiguousarray(rotation, np.float32))
    return pipeline.run(store)[0]


def is_seen(beats: Float64, first: float, count: int) -> bool:
    """Whether the poses at `beats` (T,) show the `count` beats from `first` on without a long gap."""
    within = beats[(beats >= first) & (beats <= first + count)]
    gaps = np.diff(within, prepend=first, append=first + count)
    return len(within) >= MIN_POSES_PER_BEAT * count and bool(gaps.max() <= MAX_GAP)


def motion_of(hips: Float, rotation: Float, beats: Float64, first: float, count: int) -> float:
    """Return how much a body moves within `count` beats from `first` on [m]: see MIN_MOTION; arrays as in
    `StepTemplates.recognise`, which `is_seen`."""
    return float(_flat(_measure(hips, rotation, beats, first, count))[2])


def _measure(hips: Float, rotation: Float, beats: Float64, first: float, count: int) -> Float32:
    """Return the compared points of the `count` beats from `first` on, (M, K, 3)."""
    near = np.flatnonzero((beats >= first - 0.5) & (beats <= first + count + 0.5))
    points = _points(_positions(hips[near], rotation[near], np.arange(float(len(near)))))
    return _sampled(points, beats[near], first, count)


def _points(position: Float) -> Float32:
    """Return the compared joints of world positions (T, J, 3), the way over the floor made shorter, (T, K, 3)."""
    found = np.asarray(position[:, _JOINTS], np.float32)
    found[..., ::2] -= (1.0 - TRAVEL_SHARE) * found[:, _HIPS : _HIPS + 1, ::2]
    return found


def _sampled(points: Float32, beats: Float64, first: float, count: int) -> Float32:
    """Return points (T, K, 3) at `beats` (T,) at `count` beats' moments from `first` on, (M, K, 3)."""
    fine = SAMPLES_PER_BEAT * _FINE
    moments = first + (np.arange(count * fine + 2 * _SMOOTHING) + 0.5 * _FINE - _SMOOTHING) / fine
    after = np.clip(np.searchsorted(beats, moments), 1, len(beats) - 1)
    span = beats[after] - beats[after - 1]
    part = np.clip((moments - beats[after - 1]) / np.maximum(span, 1e-9), 0.0, 1.0).astype(np.float32)
    part = part[:, None, None]
    dense = points[after - 1] * (1.0 - part) + points[after] * part
    kernel = 1.0 - np.abs(np.arange(-_SMOOTHING, _SMOOTHING + 1)) / (_SMOOTHING + 1.0)
    kernel = (kernel / kernel.sum()).astype(np.float32)
    result = np.zeros((count * SAMPLES_PER_BEAT, *points.shape[1:]), np.float32)
    for place, weight in enumerate(kernel):
        result += weight * dense[place : place + count * fine : _FINE]
    return result


def _flat(samples: Float32) -> tuple[Complex64, Float32, Float32]:
    """Return floor coordinates (..., P) as weighted complex numbers, weighted heights (..., P), and the motion [m] of
    clouds (..., M, K, 3)."""
    moments = samples.shape[-3]
    centred = samples - samples.mean(axis=(-3, -2), keepdims=True)
    mean = centred.mean(axis=-3, keepdims=True)
    moving = centred - mean
    root = np.sqrt(_WEIGHT / moments).astype(np.float32)[:, None]
    motion = np.sqrt((np.square(moving * root)).sum(axis=(-3, -2, -1)))
    weighted = (moving + POSTURE_SHARE * mean) * root
    flat = (*weighted.shape[:-3], moments * len(_WEIGHT))
    floor = (weighted[..., 0] + 1j * weighted[..., 2]).astype(np.complex64).reshape(flat)
    return floor, np.ascontiguousarray(weighted[..., 1]).reshape(flat), np.asarray(motion, np.float32)


def _mirrored(samples: Float32) -> Float32:
    """Return the mirror image of a cloud (M, K, 3)."""
    return np.asarray(samples[:, _SWAPPED] * np.array((-1.0, 1.0, 1.0), np.float32), np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class _Clouds:
    """Clouds of R rows of templates."""

    floor: Complex64
    """(R, P)"""
    height: Float32
    """(R, P)"""
    size: Float32
    """Squared size of each, (R,)."""

    @classmethod
    def of(cls, samples: Float32) -> "_Clouds":
        floor, height, _ = _flat(samples)
        size = np.square(np.abs(floor)).sum(axis=-1) + np.square(height).sum(axis=-1)
        return cls(floor, height, size.astype(np.float32))

    def joined(self, other: "_Clouds") -> "_Clouds":
        """Return the rows of both."""
        return _Clouds(
            np.concatenate([self.floor, other.floor]),
            np.concatenate([self.height, other.height]),
            np.concatenate([self.size, other.size]),
        )

    def distances(self, floor: Complex64, height: Float32) -> Float32:
        """Return the distance [m] of each row to a cloud (P,), turned and shifted for the least, (R,)."""
        own = np.square(np.abs(floor)).sum() + np.square(height).sum()
        shared = np.abs(self.floor @ floor.conj()) + self.height @ height
        return np.asarray(np.sqrt(np.maximum(self.size + own - 2.0 * shared, 0.0)), np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class StepTemplates:
    """The measures of a library as clouds, for `recognise`. Immutable."""

    beats_per_measure: int
    step: Int32
    """Step of each row, (R,)."""
    measure: Int32
    """Measure of the step of each row, (R,)."""
    mirrored: npt.NDArray[np.bool_]
    """Whether the clip of a row is a mirror image, (R,)."""
    clouds: tuple[_Clouds, ...]
    """Clouds of the first beat, the first two … up to the whole measure; None of one beat is compared."""

    @classmethod
    def of(cls, clips: Sequence[tuple[int, StepClip]], beats_per_measure: int) -> "StepTemplates":
        """Return the templates of these clips with the indices of their steps.

        Mirror images are left out of steps that have a clip which is none: every measure is tried on both sides.
        """
        originals = {clip.step for _, clip in clips if not clip.mirrored}
        rows: list[tuple[int, int, bool]] = []
        samples: list[Float32] = []
        for step, clip in clips:
            if clip.mirrored and clip.step in originals:
                continue
            for measure in range(clip.measures):
                rows += [(step, measure, clip.mirrored)] * len(SHIFTS)
                samples += _template(clip, measure)
        shape = (0, beats_per_measure * SAMPLES_PER_BEAT, len(_JOINTS), 3)
        whole = np.stack(samples) if samples else np.zeros(shape, np.float32)
        clouds = tuple(_Clouds.of(whole[:, : beats * SAMPLES_PER_BEAT]) for beats in range(1, beats_per_measure + 1))
        table = np.array(rows, np.int32).reshape(-1, 3)
        return cls(beats_per_measure, table[:, 0], table[:, 1], table[:, 2].astype(np.bool_), clouds)

    def joined(self, other: "StepTemplates") -> "StepTemplates":
        """Return the rows of both, of the same metre."""
        one, two = self, other
        return StepTemplates(
            self.beats_per_measure,
            np.concatenate([one.step, two.step]),
            np.concatenate([one.measure, two.measure]),
            np.concatenate([one.mirrored, two.mirrored]),
            tuple(a.joined(b) for a, b in zip(one.clouds, two.clouds, strict=True)),
        )

    def recognise(
        self, hips: Float, rotation: Float, beats: Float64, first: float, count: int | None = None
    ) -> RecognisedStep:
        """Return the step that a body danced in the measure that began at beat `first`.

        `hips` (T, 3) [m] and local `rotation` (T, J, 4) at `beats` (T,), ascending, on the engine's skeleton; `count`:
        beats of the measure that are looked at, 2 or more, the whole measure by default.
        """
        count = self.beats_per_measure if count is None else count
        if not len(self.step) or not is_seen(beats, first, count):
            return UNKNOWN
        samples = _measure(hips, rotation, beats, first, count)
        clouds = self.clouds[count - 1]
        floor, height, motion = _flat(samples)
        other_floor, other_height, _ = _flat(_mirrored(samples))
        distance = np.stack([clouds.distances(floor, height), clouds.distances(other_floor, other_height)])
        side, row = divmod(int(distance.argmin()), distance.shape[1])
        best, step = float(distance[side, row]), int(self.step[row])
        others = distance[:, self.step != step]
        second = float(others.min()) if others.size else np.inf
        mirrored = bool(self.mirrored[row]) != bool(side)
        sure = _confidence(best, second, float(motion))
        return RecognisedStep(step if sure > 0.0 else -1, int(self.measure[row]), mirrored, sure, best)


def _confidence(best: float, second: float, motion: float) -> float:
    """Return how sure the nearest step is, 0 to 1; 0: unknown."""
    margin = (second - best) / max(best, 1e-6)
    share = max(best / MAX_DISTANCE, best / (MAX_RATIO * max(motion, 1e-6)))
    if motion < MIN_MOTION or share >= 1.0 or margin < MIN_MARGIN:
        return 0.0
    clear = min((margin - MIN_MARGIN) / (SURE_MARGIN - MIN_MARGIN), 1.0)
    return min(1.0, 0.1 + 2.0 * (1.0 - share)) * (0.5 + 0.5 * clear)


def _template(clip: StepClip, measure: int) -> list[Float32]:
    """Return a measure of a clip danced late by each of SHIFTS, (M, K, 3) each."""
    beats = clip.beats_per_measure
    moments = np.arange(-0.75, beats + 0.75, 1.0 / (SAMPLES_PER_BEAT * _FINE))
    samples = clip.first + (measure + moments / beats) * clip.samples_per_measure
    low, high = (int(np.clip(edge, 0, clip.clip.sample_count - 1)) for edge in (samples[0], samples[-1] + 2.0))
    rotation = align_signs(clip.clip.rotation[low : high + 1])
    points = _points(
        _positions(clip.clip.root_position[low : high + 1], rotation, np.clip(samples - low, 0, high - low))
    )
    return [_sampled(points, moments + shift, 0.0, beats) for shift in SHIFTS]
