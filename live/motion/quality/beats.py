"""Beats: how the motion's own beats lie to those of the music (design: Bailando's and AIST++'s measures, both ways)."""

from typing import Final

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter1d

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

SMOOTH: Final = 5.0 / 60.0
"""Width [s] of the Gaussian that smooths the mean speed: five frames of 60 a second."""
KERNEL: Final = 3.0 / 60.0
"""Width [s] of the kernel of the alignment: three frames of 60 a second, 50 ms."""


def mean_speed(position: Float, rate: float) -> Float64:
    """Mean speed of all joints [m/s] between neighbouring samples, (T - 1, ...) from (T, ..., J, 3)."""
    moved = np.diff(position.astype(np.float64), axis=0)
    return np.asarray(np.linalg.norm(moved, axis=-1).mean(axis=-1) * rate, np.float64)


def motion_beats(speed: Float64, rate: float, begin: float = 0.0) -> Float64:
    """Times [s] of the local minima of the smoothed mean speed (T - 1,), whose first value lies at `begin` plus half
    a sample."""
    if len(speed) < 3:
        return np.zeros(0)
    smooth = gaussian_filter1d(speed, SMOOTH * rate, mode="nearest")
    low = np.flatnonzero((smooth[1:-1] < smooth[:-2]) & (smooth[1:-1] <= smooth[2:])) + 1
    return np.asarray(begin + (low + 0.5) / rate, np.float64)


def offsets(beats: Float64, others: Float64) -> Float64:
    """From each of `beats` (n,) to the nearest of `others` (m,) [s], signed, (n,); empty if either is."""
    if not len(beats) or not len(others):
        return np.zeros(0)
    others = np.sort(others)
    after = np.minimum(np.searchsorted(others, beats), len(others) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.where(np.abs(others[before] - beats) <= np.abs(others[after] - beats), before, after)
    return np.asarray(others[nearer] - beats, np.float64)


def alignment(beats: Float64, others: Float64) -> float | None:
    """Mean of exp(-d² / 2σ²) over `beats`, d the distance to the nearest of `others`, σ 50 ms; None without beats.

    With the music's beats first it is Bailando's score (does every beat have a move?), with the motion's first that of
    AIST++ (is every move on a beat?). 0 where there is nothing to be near to.
    """
    if not len(beats):
        return None
    if not len(others):
        return 0.0
    return float(np.exp(-(offsets(beats, others) ** 2) / (2.0 * KERNEL**2)).mean())
