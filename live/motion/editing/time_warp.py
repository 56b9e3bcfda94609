"""Time warps of one measure (T055) and of a whole sequence (T056), so that dancers differ in timing.

A measure warp is a half sine wave ahead of or behind the beat. A sequence warp oscillates about the beat with varying
amplitude and frequency. Phases are fractions of the measure, 0 to 1, and amplitudes shares of it: the thesis'
A_max = 7 and f_max = 2 for N = 100 frames are 0.07 and 2 here.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.motion.clip import Clip, read_clip
from live.motion.editing.turn_insertion import BLEND_WINDOW
from live.motion.step_clip import StepClip

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

A_MAX: Final = 0.07
F_MAX: Final = 2.0
F_MIN: Final = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class MeasureWarps:
    """The warps of n measures or dancers, each array of shape (n,)."""

    amplitude: Float64
    """A: maximum lead or lag of the clip [share of the measure]."""
    frequency: Float64
    """f: the half wave takes 1 / (2 f) of the measure."""
    start: Float64
    """x0: fraction of the measure at which it begins."""
    sign: Float64
    """1 to lead, -1 to lag."""

    def select(self, rows: npt.NDArray[np.integer]) -> "MeasureWarps":
        """Return the selected rows."""
        return MeasureWarps(self.amplitude[rows], self.frequency[rows], self.start[rows], self.sign[rows])

    def phase(self, x: npt.ArrayLike, window: float = BLEND_WINDOW) -> Float64:
        """Return `measure_warp` with these parameters; `x` broadcasts against (n,)."""
        return measure_warp(x, self.amplitude, self.frequency, self.start, self.sign, window)


def measure_warp(
    x: npt.ArrayLike,
    amplitude: npt.ArrayLike,
    frequency: npt.ArrayLike,
    start: npt.ArrayLike,
    sign: npt.ArrayLike,
    window: npt.ArrayLike = BLEND_WINDOW,
) -> Float64:
    """Return the phase of the clip w(x) at phase `x` of the measure; arguments broadcast (T055 as corrected).

    x + sign · A · sin(2πf (x - x0)) during the half wave from x0 to x0 + 1 / (2f), else x. The half wave lies before
    the blend `window` (share of the measure, T052): if `start` or a low `frequency` would extend it into the
    window, it begins earlier or is shortened. Increasing while 2πf·A < 1 (`steepness`).
    """
    x = np.asarray(x, np.float64)
    f, x0 = _half_wave(frequency, start, window)
    wave = np.sin(2.0 * np.pi * f * np.clip(x - x0, 0.0, 0.5 / f))
    inside = (x > x0) & (x < x0 + 0.5 / f)
    return np.asarray(np.where(inside, x + np.asarray(sign) * np.asarray(amplitude) * wave, x))


def measure_warp_slope(
    x: npt.ArrayLike,
    amplitude: npt.ArrayLike,
    frequency: npt.ArrayLike,
    start: npt.ArrayLike,
    sign: npt.ArrayLike,
    window: npt.ArrayLike = BLEND_WINDOW,
) -> Float64:
    """Return w'(x), the playback speed: 1 + sign · A 2πf cos(2πf (x - x0)) in the half wave, else 1 (T054).

    The speed jumps at the ends of the half wave; the value there is the inner one.
    """
    x = np.asarray(x, np.float64)
    f, x0 = _half_wave(frequency, start, window)
    cosine = np.cos(2.0 * np.pi * f * (x - x0))
    inside = (x >= x0) & (x <= x0 + 0.5 / f)
    return np.asarray(np.where(inside, 1.0 + np.asarray(sign) * steepness(amplitude, f) * cosine, 1.0))


def steepness(amplitude: npt.ArrayLike, frequency: npt.ArrayLike) -> Float64:
    """Return A · 2πf, the maximum deviation of the speed from 1; below 1 time never runs backwards (T054).

    A = 7 frames of 100 and f = 2 give 0.8796.
    """
    return np.asarray(2.0 * np.pi * np.asarray(frequency, np.float64) * np.asarray(amplitude, np.float64))


def draw_measure_warps(
    rng: np.random.Generator,
    count: int,
    *,
    a_max: float = A_MAX,
    f_max: float = F_MAX,
    window: float = BLEND_WINDOW,
) -> MeasureWarps:
    """Random warps for `count` measures: A ~ U[0, a_max], f ~ U[0.5, f_max], x0 ~ U, the sign of y ~ U(-1, 1) (T055).

    The lower limit of f is raised so that the half wave fits before the blend `window`, and x0 is drawn from all
    positions where it fits. ValueError for values with which time could run backwards or the half wave would not fit.
    """
    lowest = max(F_MIN, 0.5 / (1.0 - window)) if 0.0 <= window < 1.0 else np.inf
    if not f_max >= lowest:
        raise ValueError(f"f_max {f_max} with a window of {window}: at least {lowest:.3g} expected")
    if not 0.0 <= steepness(a_max, f_max) < 1.0:
        raise ValueError(
            f"a_max {a_max} with f_max {f_max}: 0 to {1.0 / (2.0 * np.pi * f_max):.3f} expected, or time would run back"
        )
    amplitude = rng.uniform(0.0, a_max, count)
    frequency = rng.uniform(lowest, f_max, count)
    start = rng.uniform(0.0, 1.0, count) * (1.0 - window - 0.5 / frequency)
    sign = np.where(rng.uniform(-1.0, 1.0, count) < 0.0, -1.0, 1.0)
    return MeasureWarps(amplitude, frequency, start, sign)


def warp_step(step: StepClip, warps: MeasureWarps, *, window: float = BLEND_WINDOW) -> StepClip:
    """Return the step with each measure warped by a row of `warps`; lead-in, blend windows and measure lines unchanged.

    ValueError unless there is one row for each measure.
    """
    if warps.amplitude.shape != (step.measures,):
        raise ValueError(f"{warps.amplitude.size} warps for the {step.measures} measures of the step {step.step!r}")
    place = (np.arange(step.clip.sample_count) - step.first) / step.samples_per_measure
    measure = np.clip(np.floor(place).astype(np.int64), 0, step.measures - 1)
    inside = (place >= 0.0) & (place < step.measures)
    warped = measure + warps.select(measure).phase(place - measure, window)
    samples = step.first + np.where(inside, warped, place) * step.samples_per_measure
    return replace(step, clip=warp_clip(step.clip, samples))


def warp_clip(clip: Clip, samples: npt.NDArray[np.floating]) -> Clip:
    """Clip resampled so that sample n is `clip` at the fractional sample `samples[n]`, (T,); ends are held."""
    root, rotation, contact = read_clip(clip, samples)
    return replace(
        clip,
        root_position=root.astype(np.float32),
        rotation=np.ascontiguousarray(rotation, np.float32),
        contact=contact,
    )


def _half_wave(frequency: npt.ArrayLike, start: npt.ArrayLike, window: npt.ArrayLike) -> tuple[Float64, Float64]:
    """Return f and x0 such that the half wave ends before the window."""
    room = 1.0 - np.asarray(window, np.float64)
    f = np.maximum(np.asarray(frequency, np.float64), 0.5 / room)
    return f, np.clip(np.asarray(start, np.float64), 0.0, np.maximum(room - 0.5 / f, 0.0))


SPACING: Final = 2.0
"""Measures between the sparse points."""
MAX_STEEPNESS: Final = 0.95
"""Upper limit for the condition of T056; at 1 time would stand still."""
_POINTS_PER_MEASURE: Final = 64
"""Points in each measure at which the condition is checked."""


@dataclass(frozen=True, slots=True, eq=False)
class SequenceWarp:
    """w(x) = x + A(x) sin(φ(x)), φ' = 2πf(x), with x in measures from the beginning of the sequence.

    A and f are cubic splines through `amplitudes` [measures] and `frequencies` [waves a measure] at `knots`
    [measures], each of shape (K,), K >= 2. The phase is an integral: with f(x)·x, as printed, its rate would grow
    with x. ValueError if time could run backwards between the knots.
    """

    knots: Float64
    amplitudes: Float64
    frequencies: Float64

    def __post_init__(self) -> None:
        if not self.max_deviation() < 1.0:
            raise ValueError(
                f"max(|A'| + A φ') is {self.max_deviation():.3f}: below 1 expected, or time would run back"
            )

    def phase(self, x: npt.ArrayLike) -> Float64:
        """Return w(x) [measures]; x itself before the first and after the last knot."""
        x = np.asarray(x, np.float64)
        a, f = self._splines()
        turned = 2.0 * np.pi * f.antiderivative()(x)
        inside = (x > self.knots[0]) & (x < self.knots[-1])
        return np.asarray(np.where(inside, x + a(x) * np.sin(turned), x))

    def max_deviation(self) -> float:
        """Return max(|A'| + |A| φ'), computed numerically: the speed is at least 1 minus this (T056 as corrected)."""
        return _sequence_steepness(self.knots, self.amplitudes, self.frequencies)

    def _splines(self) -> "tuple[CubicSpline, CubicSpline]":
        from scipy.interpolate import CubicSpline

        return CubicSpline(self.knots, self.amplitudes), CubicSpline(self.knots, self.frequencies)


def draw_sequence_warp(
    rng: np.random.Generator,
    measures: float,
    *,
    spacing: float = SPACING,
    a_max: float = A_MAX,
    f_max: float = F_MAX,
) -> SequenceWarp:
    """Random warp of a sequence of `measures`: A ~ U[0, a_max] and f ~ U[0.5, f_max] every `spacing` measures (T056).

    Frequencies are then scaled slightly so that a whole number of half waves fills the sequence and its end does not
    move; amplitudes are scaled, if necessary, so that time never runs backwards. ValueError for an empty sequence or
    values below 0.
    """
    from scipy.interpolate import CubicSpline

    if not (measures > 0.0 and spacing > 0.0 and a_max >= 0.0 and f_max >= F_MIN):
        raise ValueError(f"measures {measures}, spacing {spacing}, a_max {a_max}, f_max {f_max}: too small")
    knots = np.linspace(0.0, measures, max(2, int(np.ceil(measures / spacing)) + 1))
    amplitudes = rng.uniform(0.0, a_max, knots.size)
    frequencies = rng.uniform(F_MIN, f_max, knots.size)
    waves = float(CubicSpline(knots, frequencies).integrate(0.0, measures))
    frequencies *= max(1.0, round(2.0 * waves)) / (2.0 * waves)
    slope = _sequence_steepness(knots, amplitudes, frequencies)
    return SequenceWarp(knots, amplitudes * min(1.0, MAX_STEEPNESS / max(slope, 1e-12)), frequencies)


def warp_sequence(step: StepClip, warp: SequenceWarp) -> StepClip:
    """Step with its measures, from the first downbeat on, warped as a sequence; lead-in and tail unchanged."""
    place = (np.arange(step.clip.sample_count) - step.first) / step.samples_per_measure
    return replace(step, clip=warp_clip(step.clip, step.first + warp.phase(place) * step.samples_per_measure))


def _sequence_steepness(knots: Float64, amplitudes: Float64, frequencies: Float64) -> float:
    from scipy.interpolate import CubicSpline

    count = int(np.ceil(knots[-1] - knots[0])) * _POINTS_PER_MEASURE + 1
    x = np.linspace(knots[0], knots[-1], count)
    a, f = CubicSpline(knots, amplitudes), CubicSpline(knots, frequencies)
    return float(np.max(np.abs(a(x, 1)) + np.abs(a(x)) * 2.0 * np.pi * np.abs(f(x))))
