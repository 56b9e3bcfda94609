"""Curve fit of pulse times over pulse numbers, with an adaptive window.

A bank of straight lines (a steady tempo) and parabolas (a tempo that changes evenly) over the last 4 to 768 pulses.
Among those that the newest pulses do not contradict, the one that predicts best is used: long windows for a steady
sender, short ones while the tempo moves (Lepski's method of choosing a bandwidth; Goldenshluger and Nemirovski, "On
spatially adaptive estimation of nonparametric regression", 1997).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

Times = npt.NDArray[np.float64]

LINES: Final = (4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 72, 96, 144, 192, 288, 384, 576, 768)
PARABOLAS: Final = (32, 48, 64, 96, 128, 192)
"""Lengths of the windows [pulses]."""

RECENT: Final = np.array((4, 6, 8, 12, 16, 24, 32, 48, 64, 96))
"""Numbers of newest pulses over which a curve's mean residual is tested against chance."""

PREDICTION_DISTANCE: Final = 12.0
"""Curves are compared by their prediction of the pulse half a beat ahead."""

REJECTION_THRESHOLD: Final = 4.6
"""Standard errors of a mean residual, or of the difference to a shorter curve's prediction, that reject a curve.

The limit is high because each of a song's thousands of pulses brings ten tests, and a false rejection leaves only a
short window for the tempo.
"""

STEADY_PULSES: Final = 96
"""If no line of so many pulses or more fits, the tempo moves, and short lines only hide how."""

_HANKEL: Final = np.array(((0, 1, 2), (1, 2, 3), (2, 3, 4)))

PERIOD_MIN: Final = 1e-3
"""Minimum pulse period [s]; faster pulses are a flood."""

NOISE_MIN: Final = 2e-4
"""Minimum scatter of arrival times [s]; no curve is rejected for less."""

KNOWN_PERIOD_PULSES: Final = 144
"""Pulses after which a stretch determines its period better than the estimate before it."""

NOISE_WINDOW: Final = 96
SPREAD_OF_SECOND_DIFFERENCES: Final = 1.9
"""Standard deviation of white noise's second differences without the largest tenth, in units of the noise's own."""


@dataclass(frozen=True, slots=True)
class PulseFit:
    """time(n) = time + period · x + bend · x² with x = n − number."""

    number: int
    time: float
    """Time of pulse `number`, the last one fitted [s]."""
    period: float
    """Pulse period at that moment [s]."""
    bend: float
    noise: float
    """Scatter of arrivals about the curve [s]."""
    count: int
    """Number of pulses fitted."""

    def time_of(self, number: float) -> float:
        """Return the time of pulse `number` [s]; a bend is extrapolated for at most one beat."""
        x = number - self.number
        near = min(x, 24.0)
        time = self.time + self.period * near + self.bend * near * near
        return time + self.period_at(number) * (x - near)

    def period_at(self, number: float) -> float:
        """Return the pulse period at `number` [s], at least half of the present one."""
        return max(self.period + 2.0 * self.bend * min(number - self.number, 24.0), 0.5 * self.period)


def _variance_ahead(length: npt.NDArray[np.float64], degree: int) -> npt.NDArray[np.float64]:
    """Return the variance of a prediction `AHEAD` pulses beyond a window, for white noise of variance 1 (Legendre
    polynomials).
    """
    x = 1.0 + 2.0 * PREDICTION_DISTANCE / length
    value = 1.0 + 3.0 * x**2
    if degree == 2:
        value += 5.0 * ((3.0 * x**2 - 1.0) / 2.0) ** 2
    return np.asarray(value / length)


def estimate_noise(numbers: npt.NDArray[np.int64], times: Times) -> float:
    """Return the scatter of arrivals [s], from second differences, which a changing tempo hardly affects."""
    numbers, times = numbers[-NOISE_WINDOW:], times[-NOISE_WINDOW:]
    bends = np.diff(times, 2)[(numbers[2:] - numbers[:-2]) == 2]
    if bends.size < 4:
        return NOISE_MIN
    squares = np.sort(bends * bends)[: max(bends.size - bends.size // 10, 4)]
    return max(float(np.sqrt(squares.mean())) / SPREAD_OF_SECOND_DIFFERENCES, NOISE_MIN)


def fit(
    numbers: npt.NDArray[np.int64], times: Times, weights: Times, noise: float, known: float | None = None
) -> PulseFit:
    """Fit the best curve to pulses, oldest first, of one stretch without a sudden change; at least 4 are needed.

    `weights` are 1, or 0 for pulses that are left out. `noise` as returned by `estimate_noise`. The period `known`
    before the stretch is kept as long as nothing contradicts it and the stretch is short.
    """
    last = int(numbers[-1])
    x = (numbers - last).astype(np.float64)[::-1]
    rough = float(times[-1] - times[0]) / max(last - int(numbers[0]), 1)
    y = (times - times[-1])[::-1] - rough * x
    w = weights[::-1]
    moments = np.cumsum(np.stack((w, w * x, w * x**2, w * x**3, w * x**4, w * y, w * x * y, w * x**2 * y)), axis=1)
    have = x.size
    lines = np.array(sorted({length for length in LINES if length < have} | {min(have, LINES[-1])}))
    parabolas = np.array([length for length in PARABOLAS if length <= have], dtype=np.int64)
    lengths = np.concatenate((lines, parabolas))
    bent = np.arange(lengths.size) >= lines.size
    curves = _curves(moments[:, lengths - 1], bent)
    keep = known is not None and have < KNOWN_PERIOD_PULSES
    if known is not None and keep:
        lengths, bent = np.append(lengths, have), np.append(bent, False)
        total, slope = moments[:, -1], known - rough
        curves = np.column_stack((curves, ((total[5] - slope * total[1]) / max(total[0], 1e-9), slope, 0.0)))
    variance = np.where(bent, _variance_ahead(lengths * 1.0, 2), _variance_ahead(lengths * 1.0, 1))
    if keep:
        variance[-1] = 0.0
    doubt = np.maximum(_misfit(moments, lengths, bent, curves, noise), _bias(curves, variance, noise))
    long = ~bent & (lengths >= STEADY_PULSES)
    if long.any() and np.all(doubt[long] > 1.0) and np.any(doubt[bent] <= 1.0):
        doubt[~bent] = np.inf
    chosen = next((int(i) for i in np.argsort(variance) if doubt[i] <= 1.0), int(np.argmin(doubt)))
    offset, slope, bend = (float(value) for value in curves[:, chosen])
    return PulseFit(last, float(times[-1]) + offset, max(rough + slope, PERIOD_MIN), bend, noise, int(lengths[chosen]))


def _curves(m: Times, bent: npt.NDArray[np.bool_]) -> Times:
    """Return least-squares curves from the moments of each window, shape (8, C): offset, slope, bend, shape (3, C)."""
    matrices = m[_HANKEL].transpose(2, 0, 1).copy()
    right = m[5:8].T.copy()
    straight = ~bent
    matrices[straight, 2, :] = matrices[straight, :, 2] = 0.0
    right[straight, 2] = 0.0
    matrices[straight, 2, 2] = 1.0
    few = m[0] < np.where(bent, 4.0, 3.0)  # too many pulses were left out
    matrices[few] = np.eye(3)
    right[few] = np.nan
    return np.asarray(np.linalg.solve(matrices, right[:, :, None])[:, :, 0].T)


def _bias(curves: Times, variance: Times, noise: float) -> Times:
    """Return how far the prediction of each curve is outside those of the shorter ones, shape (C,); 1 is the limit.

    A shorter window predicts less exactly, but with less bias: where both differ by more than chance, the longer one is
    wrong (the intersection of confidence intervals).
    """
    ahead = curves[0] + PREDICTION_DISTANCE * (curves[1] + PREDICTION_DISTANCE * curves[2])
    off = np.abs(ahead[:, None] - ahead[None, :])
    allowed = REJECTION_THRESHOLD * noise * np.sqrt(np.maximum(variance[None, :] - variance[:, None], 1e-12))
    shorter = (variance[None, :] > variance[:, None]) & np.isfinite(ahead)[None, :]
    worst = np.max(np.where(shorter, off / allowed, 0.0), axis=1, initial=0.0)
    return np.where(np.isfinite(ahead), worst, np.inf)


def _misfit(
    moments: Times, lengths: npt.NDArray[np.int64], bent: npt.NDArray[np.bool_], curves: Times, noise: float
) -> Times:
    """Return how much the newest pulses contradict each curve, shape (C,): its worst mean residual; 1 is the limit."""
    recent = RECENT[: int(np.searchsorted(RECENT, moments.shape[1], "right"))]
    part = moments[:, recent - 1]
    count = np.maximum(part[0], 1e-9)
    means = (part[5] - (curves.T @ part[:3])) / count
    # A curve's own residuals are smaller than the noise, at its end and where the window is short.
    share = np.minimum(recent[None, :] * np.where(bent, 9.0, 4.0)[:, None] / lengths[:, None], 1.0)
    allowed = REJECTION_THRESHOLD * noise * np.sqrt(np.maximum(1.0 - share, 0.35) / count)
    inside = recent[None, :] < lengths[:, None]
    worst = np.max(np.where(inside, np.abs(means) / allowed, 0.0), axis=1, initial=0.0)
    return np.where(np.isfinite(curves[0]), worst, np.inf)
