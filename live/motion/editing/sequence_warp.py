"""Time warp of a whole sequence: slow swings about the beat whose size and pace wander (T056)."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from live.motion.editing.time_warp import A_MAX, F_MAX, F_MIN, warp_clip
from live.motion.step_clip import StepClip

Float64 = npt.NDArray[np.float64]

SPACING: Final = 2.0
"""Measures between the sparse points."""
STEEPEST: Final = 0.95
"""What the condition of T056 may come to; at 1 time would stand still."""
_CHECKED: Final = 64
"""Points in each measure at which the condition is checked."""


@dataclass(frozen=True, slots=True, eq=False)
class SequenceWarp:
    """w(x) = x + A(x) sin(φ(x)), φ' = 2πf(x), with x in measures from the beginning of the sequence.

    A and f are cubic splines through `amplitudes` [measures] and `frequencies` [waves a measure] at `knots`
    [measures], each of shape (K,), K >= 2. The phase is accumulated: with f(x)·x, as printed, its pace would grow
    with x. ValueError if time could run back anywhere between the knots.
    """

    knots: Float64
    amplitudes: Float64
    frequencies: Float64

    def __post_init__(self) -> None:
        if not self.slowest() < 1.0:
            raise ValueError(f"max(|A'| + A φ') is {self.slowest():.3f}: below 1 expected, or time would run back")

    def phase(self, x: npt.ArrayLike) -> Float64:
        """w(x) [measures]; before the first and after the last knot x itself."""
        x = np.asarray(x, np.float64)
        a, f = self._splines()
        turned = 2.0 * np.pi * f.antiderivative()(x)
        inside = (x > self.knots[0]) & (x < self.knots[-1])
        return np.asarray(np.where(inside, x + a(x) * np.sin(turned), x))

    def slowest(self) -> float:
        """max(|A'| + |A| φ'), checked numerically: time never goes slower than 1 less this (T056 as corrected)."""
        return _slowest(self.knots, self.amplitudes, self.frequencies)

    def _splines(self) -> tuple[CubicSpline, CubicSpline]:
        return CubicSpline(self.knots, self.amplitudes), CubicSpline(self.knots, self.frequencies)


def draw_sequence_warp(
    rng: np.random.Generator,
    measures: float,
    *,
    spacing: float = SPACING,
    a_max: float = A_MAX,
    f_max: float = F_MAX,
) -> SequenceWarp:
    """A random warp of a sequence of `measures`: A ~ U[0, a_max] and f ~ U[0.5, f_max] every `spacing` measures (T056).

    All frequencies are then scaled by a little so that a whole number of half waves fills the sequence, which ends
    where it would; and all amplitudes, if need be, so that time never runs back. ValueError for an empty sequence or
    values below 0.
    """
    if not (measures > 0.0 and spacing > 0.0 and a_max >= 0.0 and f_max >= F_MIN):
        raise ValueError(f"measures {measures}, spacing {spacing}, a_max {a_max}, f_max {f_max}: too small")
    knots = np.linspace(0.0, measures, max(2, int(np.ceil(measures / spacing)) + 1))
    amplitudes = rng.uniform(0.0, a_max, knots.size)
    frequencies = rng.uniform(F_MIN, f_max, knots.size)
    waves = float(CubicSpline(knots, frequencies).integrate(0.0, measures))
    frequencies *= max(1.0, round(2.0 * waves)) / (2.0 * waves)
    slope = _slowest(knots, amplitudes, frequencies)
    return SequenceWarp(knots, amplitudes * min(1.0, STEEPEST / max(slope, 1e-12)), frequencies)


def warp_sequence(step: StepClip, warp: SequenceWarp) -> StepClip:
    """The step with its measures, from the first downbeat on, warped as a sequence; lead-in and tail as they were."""
    place = (np.arange(step.clip.sample_count) - step.first) / step.samples_per_measure
    return replace(step, clip=warp_clip(step.clip, step.first + warp.phase(place) * step.samples_per_measure))


def _slowest(knots: Float64, amplitudes: Float64, frequencies: Float64) -> float:
    count = int(np.ceil(knots[-1] - knots[0])) * _CHECKED + 1
    x = np.linspace(knots[0], knots[-1], count)
    a, f = CubicSpline(knots, amplitudes), CubicSpline(knots, frequencies)
    return float(np.max(np.abs(a(x, 1)) + np.abs(a(x)) * 2.0 * np.pi * np.abs(f(x))))
