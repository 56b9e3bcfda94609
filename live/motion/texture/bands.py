"""Frequency bands of a signal: a Laplacian pyramid that keeps its sampling (P003).

Band 1 is the highest. Each next one comes of a filter twice as long (Burt and Adelson's B-spline 1 4 6 4 1, with
zeros between its taps), so bands keep the signal's rate, move with it in time, and add up to it exactly.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

RATE: Final = 24.0
"""Samples per second in which bands are counted, as in the paper [Hz]: band 1 is 6 to 12 Hz, band 2 is 3 to 6 Hz."""
MOST_BANDS: Final = 10
"""Band 10 at 24 samples a second has a period of a minute."""


def split_bands(signal: Float, count: int) -> Float64:
    """`count` bands of `signal` (T, ...), the highest first, and what is left of it, (count + 1, T, ...).

    Their sum is the signal. Beyond its ends a signal goes on reflected in its end *points*, x(-t) = 2 x(0) - x(t):
    so a line has no bands, all bands are 0 at both ends, and nothing of a trend comes into them.
    """
    if count < 0:
        raise ValueError(f"{count} bands: 0 or more expected")
    rest = np.array(signal, np.float64)
    out = np.empty((count + 1, *rest.shape))
    for band in range(count):
        lower = lower_half(rest, 1 << band)
        out[band] = rest - lower
        rest = lower
    out[count] = rest
    return out


def lower_half(signal: Float64, spacing: int) -> Float64:
    """`signal` (T, ...) without its upper half of frequencies at a filter whose taps are `spacing` samples apart."""
    length = len(signal)
    if length < 2:
        return signal.copy()
    reach = 2 * spacing
    if reach < length:  # one reflection at each end is all that the filter sees
        before = 2.0 * signal[0] - signal[reach:0:-1]
        after = 2.0 * signal[-1] - signal[-2 : -2 - reach : -1]
        wide = np.concatenate((before, signal, after))
    else:
        wide = _reflected(signal, reach)
    parts = [wide[n * spacing : n * spacing + length] for n in range(5)]
    return np.asarray((parts[0] + parts[4] + 4.0 * (parts[1] + parts[3]) + 6.0 * parts[2]) / 16.0)


def _reflected(signal: Float64, reach: int) -> Float64:
    """The signal with `reach` samples more at both ends, however often it must be reflected for that."""
    last = len(signal) - 1
    at = np.arange(-reach, last + reach + 1)
    shape = (-1, *(1,) * (signal.ndim - 1))
    slope = (signal[-1] - signal[0]) / last
    flat = signal - signal[0] - np.arange(last + 1.0).reshape(shape) * slope  # 0 at both ends: odd about them
    turn = at % (2 * last)
    back = turn > last
    wide = flat[np.where(back, 2 * last - turn, turn)] * np.where(back, -1.0, 1.0).reshape(shape)
    return np.asarray(wide + signal[0] + at.reshape(shape) * slope)
