"""Phase of the steps of a walk where its path turns sharply (H018).

A path says nothing of the feet: the phase of the step is no part of the control. In the paper (Hsu, Gentry, Popović,
2004, section 6.1) sharp turns synchronise the footwork all the same, because the best row of strides is sought as a
whole: strides before a turn are stretched so that the turn comes on the foot on which it came in the recordings. Here
that is measured, as circular statistics of the phase (N. I. Fisher, *Statistical Analysis of Circular Data*, 1993).

The phase is 0 when the left foot lands and half a cycle when the right foot lands, and runs evenly between landings.
At a turn to the right it is taken half a cycle on, so that a turn on the outer foot has one phase on either side.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Complex128, Float64
from live.motion.clip import Clip
from live.motion.partner.point_clouds import Cloud

WINDOW_S: Final = 0.6
"""Time over which the change of direction is measured [s]."""
SWAY_S: Final = 0.25
"""Standard deviation of the smoothing of a path before [s]: hips sway with each step, and a turn that is found by their
sway would have the phase of the step by its definition."""
SHARP_RAD: Final = np.radians(50.0)
"""Least change of direction within it of a sharp turn [rad]."""
MIN_SPEED: Final = 0.25
"""A path that is slower has no direction [m/s]."""
APART_S: Final = 0.8
"""Turns are so far apart at least [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class PathTurns:
    """Sharp turns of a path."""

    times: Float64
    """Time of each, in the middle of the change of direction [s], (n,)."""
    angles: Float64
    """Change of direction [rad], positive to the left, (n,)."""


def sharp_turns(path: Cloud) -> PathTurns:
    """Return the sharp turns of the middle of a path's points."""
    from scipy.ndimage import gaussian_filter1d
    from scipy.signal import find_peaks

    rate, middle = path.rate, path.floor.mean(axis=1)
    width = SWAY_S * rate
    smooth = gaussian_filter1d(middle.real, width, mode="nearest")
    smooth = smooth + 1j * gaussian_filter1d(middle.imag, width, mode="nearest")
    velocity = np.gradient(smooth) * rate
    half = max(round(0.5 * WINDOW_S * rate), 1)
    if len(velocity) <= 2 * half:
        return PathTurns(np.zeros(0), np.zeros(0))
    before, after = velocity[: -2 * half], velocity[2 * half :]
    change = np.angle(after * before.conj())
    moves = np.minimum(np.abs(before), np.abs(after)) > MIN_SPEED
    size = np.where(moves, np.abs(change), 0.0)
    peaks, _ = find_peaks(size, height=SHARP_RAD, distance=max(round(APART_S * rate), 1), plateau_size=1)
    return PathTurns(np.asarray((peaks + half) / rate), np.asarray(change[peaks]))


def landings(clip: Clip) -> tuple[Float64, npt.NDArray[np.int64]]:
    """Return times [s] and feet (0 left, 1 right) of all landings, (n,), in their order."""
    found = [
        (float(sample + 1) / clip.sample_rate, foot)
        for foot in range(2)
        for sample in np.flatnonzero(np.diff(clip.contact[:, foot].astype(np.int8)) > 0)
    ]
    found.sort()
    return np.array([one[0] for one in found]), np.array([one[1] for one in found], np.int64)


def step_phases(clip: Clip, times: Float64) -> Float64:
    """Return the phase of the step at each of `times` [s], in cycles from 0 to 1; nan outside of steps.

    Only between landings of different feet the phase is known: one foot that lands twice is no walk.
    """
    when, foot = landings(clip)
    phase = np.full(len(times), np.nan)
    after = np.searchsorted(when, times, side="right")
    for n, index in enumerate(after.tolist()):
        if 0 < index < len(when) and foot[index] != foot[index - 1]:
            share = (times[n] - when[index - 1]) / (when[index] - when[index - 1])
            phase[n] = (0.5 * float(foot[index - 1]) + 0.5 * float(share)) % 1.0
    return phase


@dataclass(frozen=True, slots=True, eq=False)
class PhaseAtTurns:
    """Phases of the steps at sharp turns, turns to the right half a cycle on."""

    phases: Float64
    """In cycles, (n,)."""

    @property
    def count(self) -> int:
        """Number of turns n."""
        return len(self.phases)

    @property
    def resultant(self) -> complex:
        """Mean of the phases as unit complex numbers: its length is 1 if all agree and 0 if they are spread evenly."""
        return complex(_circle(self.phases).mean()) if self.count else 0j

    @property
    def mean(self) -> float:
        """Mean phase, in cycles from 0 to 1."""
        return float(np.angle(self.resultant) / (2.0 * np.pi)) % 1.0

    @property
    def spread(self) -> float:
        """Circular standard deviation, in cycles; infinite if the phases are spread evenly."""
        return float(np.sqrt(-2.0 * np.log(max(abs(self.resultant), 1e-300))) / (2.0 * np.pi))

    @property
    def chance(self) -> float:
        """Probability of phases that agree as well or better by chance (Rayleigh's test, Fisher's approximation)."""
        if not self.count:
            return 1.0
        z = self.count * abs(self.resultant) ** 2
        return float(min(max(np.exp(-z) * (1.0 + (2.0 * z - z * z) / (4.0 * self.count)), 0.0), 1.0))


def phase_values(one: PhaseAtTurns) -> dict[str, float | int | None]:
    """Return the figures for a report; without turns there is no mean and no spread."""
    known = one.count > 0
    return {
        "turns": one.count,
        "mean_cycles": one.mean if known else None,
        "spread_cycles": one.spread if known and np.isfinite(one.spread) else None,
        "chance": one.chance if known else None,
    }


def phase_at_turns(clip: Clip, path: Cloud) -> PhaseAtTurns:
    """Return the phases of a walk at the sharp turns of its path, whose time begins with the clip's."""
    turns = sharp_turns(path)
    phase = step_phases(clip, turns.times)
    phase = np.where(turns.angles < 0.0, phase + 0.5, phase) % 1.0
    return PhaseAtTurns(np.asarray(phase[np.isfinite(phase)]))


def phase_difference(one: PhaseAtTurns, other: PhaseAtTurns) -> float:
    """Return how far apart the two mean phases are, in cycles from 0 to 0.5."""
    away = (one.mean - other.mean) % 1.0
    return min(away, 1.0 - away)


def pooled(many: list[PhaseAtTurns]) -> PhaseAtTurns:
    """Return the phases of several walks together."""
    return PhaseAtTurns(np.concatenate([one.phases for one in many]) if many else np.zeros(0))


def _circle(phase: Float64) -> Complex128:
    return np.asarray(np.exp(2j * np.pi * phase), np.complex128)
