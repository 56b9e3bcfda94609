"""Smoothness: how the joints' velocities change, where clips are joined and in the clips themselves."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

ACCELERATION_WINDOW: Final = 3
"""Samples over which velocities are averaged before accelerations: recorded markers tremble."""
AROUND: Final = 0.2
"""A join is looked at for so many seconds before and after its middle, at least..."""
BESIDE: Final = 0.05
"""... and always for so many before and after its blend."""
DRAWN: Final = 4000
"""Random places of the raw clips that joins are compared with."""


def velocity_changes(position: Float, rate: float) -> Float64:
    """Change of each joint's velocity at the samples between the first and last [m/s], (T - 2, ...) of (T, ..., 3)."""
    velocity = np.diff(position.astype(np.float64), axis=0) * rate
    return np.asarray(np.linalg.norm(np.diff(velocity, axis=0), axis=-1), np.float64)


def accelerations(position: Float, rate: float) -> Float64:
    """Acceleration [m/s²], velocities averaged over three samples, (T - 4, ...) from (T, ..., 3): none at the ends."""
    velocity = np.diff(position.astype(np.float64), axis=0) * rate
    if len(velocity) < ACCELERATION_WINDOW + 1:
        return np.zeros((0, *velocity.shape[1:-1]))
    windows = np.lib.stride_tricks.sliding_window_view(velocity, ACCELERATION_WINDOW, axis=0)
    return np.asarray(np.linalg.norm(np.diff(windows.mean(axis=-1), axis=0), axis=-1) * rate, np.float64)


def at_samples(position: Float, rate: float) -> tuple[Float64, Float64]:
    """Largest velocity change [m/s] and acceleration [m/s²] of any joint at every sample, (T, ...) of (T, ..., J, 3).

    0 at the first and last samples, where there is none.
    """
    shape = position.shape[:-2]
    change, acceleration = np.zeros(shape), np.zeros(shape)
    if len(position) > 2:
        change[1:-1] = velocity_changes(position, rate).max(axis=-1)
    if len(position) > ACCELERATION_WINDOW + 1:
        acceleration[2:-2] = accelerations(position, rate).max(axis=-1)
    return change, acceleration


def half_width(blend: float) -> float:
    """Seconds before and after the middle of a join that takes `blend` seconds over which it is looked at."""
    return max(AROUND, 0.5 * blend + BESIDE)


def largest_around(values: Float64, middle: Float64, half: float, rate: float) -> Float64:
    """The largest of `values` (T,) within `half` seconds of each of the times `middle` (n,) [s], (n,)."""
    first = np.clip(np.ceil((middle - half) * rate - 1e-6).astype(np.int64), 0, len(values) - 1)
    last = np.clip(np.floor((middle + half) * rate + 1e-6).astype(np.int64), 0, len(values) - 1)
    width = int((last - first).max(initial=0)) + 1
    rows = np.minimum(first[:, None] + np.arange(width), last[:, None])
    return np.asarray(values[rows].max(axis=1), np.float64)


def p99_of_raw(traces: Sequence[Float64], half: float, rate: float, *, seed: int = 0) -> float:
    """p99 of the largest value within `half` seconds of random samples of the raw clips' `traces`, each (T,).

    Places are drawn evenly from all samples of all clips that have `half` seconds on both sides; of a clip shorter
    than that its middle counts. 0 if there is no clip.
    """
    chance = np.random.default_rng(seed)
    margin = half * rate
    room = np.array([max(len(trace) - 1 - 2.0 * margin, 0.0) + 1.0 for trace in traces])
    if not len(room):
        return 0.0
    clip = chance.choice(len(traces), DRAWN, p=room / room.sum())
    found = []
    for n, trace in enumerate(traces):
        places = chance.uniform(0.0, room[n] - 1.0, int((clip == n).sum())) + min(margin, 0.5 * (len(trace) - 1))
        if len(places):
            found.append(largest_around(trace, places / rate, half, rate))
    return float(np.percentile(np.concatenate(found), 99))
