"""Fit of a regular beat grid to event times with missing events and outliers."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64

Int = npt.NDArray[np.int64]

EVENT_DEVIATION: Final = 0.03
"""Standard deviation [s] of an event about its beat: at this distance it counts 60 %."""
MAX_DISTANCE: Final = 0.07
"""Events farther than this [s] from every beat are outliers; people clap within 30 ms."""
MAX_DISTANCE_BEATS: Final = 0.2
"""The same limit in beats."""
PERIODS: Final = (0.24, 1.5)
"""Range of seconds per beat that is searched: 250 to 40 bpm."""
OFFSET_STEP: Final = 0.002
"""Step between tried offsets [s]."""
OCTAVE_BONUS: Final = 0.02
"""Score bonus per octave for longer periods, so that of two equally good periods the longer one is chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class BeatFit:
    """Beats at offset_s + k · period_s, and the assignment of N events to them."""

    times: Float64
    """The events [s], shape (N,)."""
    offset_s: float
    period_s: float
    numbers: Int
    """Beat k nearest to each event, shape (N,)."""
    residuals: Float64
    """Lateness of each event [s], shape (N,)."""
    on_beat: Bool
    """Whether the event is on a beat, shape (N,)."""

    @property
    def rms_s(self) -> float:
        """Root mean square of the residuals of events on beats [s]."""
        own = self.residuals[self.on_beat]
        return float(np.sqrt(np.mean(own**2))) if own.size else float("inf")

    @property
    def coverage(self) -> float:
        """Share of the beats with an event, from the first such beat to the last."""
        own = np.unique(self.numbers[self.on_beat])
        return own.size / (int(own[-1]) - int(own[0]) + 1) if own.size else 0.0


def fit_known_period(times: Float64, period_s: float) -> BeatFit:
    """Fit with the offset in [0, period) that puts most events on beats (kernel density), refined on those."""
    offsets = np.arange(0.0, period_s, OFFSET_STEP)
    off = times[:, None] - offsets
    late = off - period_s * np.round(off / period_s)
    score = np.exp(-0.5 * (late / EVENT_DEVIATION) ** 2).sum(axis=0)
    offset = float(offsets[int(np.argmax(score))])
    for _ in range(3):
        fit = _assign_events(times, offset, period_s)
        if fit.on_beat.any():
            offset += float(np.mean(fit.residuals[fit.on_beat]))
    return _assign_events(times, offset, period_s)


def fit_free_period(times: Float64, periods: tuple[float, float] = PERIODS) -> BeatFit | None:
    """Return the best fit of offset and period; None if fewer than three events agree.

    Candidates are the intervals between any two of four neighbouring events, and their halves and thirds (for missed
    ones). The period is refined by least squares over the events on beats. Beats without events cost as much as events
    without beats, so that the tempo is not doubled.
    """
    if times.size < 3:
        return None
    gaps = np.concatenate([times[k:] - times[:-k] for k in range(1, min(4, times.size))])
    candidates = np.concatenate([gaps / k for k in (1, 2, 3)])
    candidates = np.unique(np.round(candidates[(candidates >= periods[0]) & (candidates <= periods[1])], 3))
    best: BeatFit | None = None
    best_worth = -np.inf
    for period in candidates:
        fit = refine(fit_known_period(times, float(period)))
        if not periods[0] <= fit.period_s <= periods[1]:
            continue
        worth = _score(fit, times.size)
        if worth > best_worth:
            best, best_worth = fit, worth
    return best if best is not None and int(best.on_beat.sum()) >= 3 else None


def _score(fit: BeatFit, events: int) -> float:
    own = int(np.unique(fit.numbers[fit.on_beat]).size)
    tight = float(np.exp(-0.5 * (fit.residuals[fit.on_beat] / EVENT_DEVIATION) ** 2).sum())
    span = own / max(fit.coverage, 1e-9)
    return (tight - 0.5 * (span - own) - 0.5 * (events - own)) / events + OCTAVE_BONUS * float(np.log2(fit.period_s))


def refine(fit: BeatFit) -> BeatFit:
    """Return the fit refined by three least-squares iterations over the events on beats."""
    for _ in range(3):
        numbers, own = fit.numbers[fit.on_beat], fit.times[fit.on_beat]
        if np.unique(numbers).size < 2:
            return fit
        slope, offset = np.polyfit(numbers, own, 1)
        if slope <= 0.0:
            return fit
        fit = _assign_events(fit.times, float(offset), float(slope))
    return fit


def _assign_events(times: Float64, offset: float, period_s: float) -> BeatFit:
    numbers = np.round((times - offset) / period_s).astype(np.int64)
    late = times - offset - numbers * period_s
    belongs = np.abs(late) <= min(MAX_DISTANCE, MAX_DISTANCE_BEATS * period_s)
    for number in np.unique(numbers[belongs]):  # of several events on one beat only the nearest counts
        rivals = np.flatnonzero(belongs & (numbers == number))
        belongs[rivals] = False
        belongs[rivals[np.argmin(np.abs(late[rivals]))]] = True
    return BeatFit(times, offset, period_s, numbers, np.asarray(late), np.asarray(belongs))
