"""Foot contact detection from height and speed, with hysteresis."""

from typing import Final

import numpy as np

from live.base.arrays import Bool, Float
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

TOES_OVER_SOLE: Final = SOLE_BELOW_ANKLE + float(SKELETON.offsets[SKELETON.index("leftToes"), 1])
"""Height [m] of the toe joint over the floor when the foot is flat."""

SPEED_ON: Final = 0.15
"""A foot must be slower than this [m/s] for contact to start; the usual threshold (toe speed, median over 0.1 s)."""
SPEED_OFF: Final = 0.45
"""Contact ends above this speed [m/s]; below it the foot may slide or pivot, as dancers do."""
HEIGHT_ON: Final = 0.045
HEIGHT_OFF: Final = 0.09
"""Heights [m] of the lower of heel and toe for contact to start and to end."""
SPEED_WINDOW: Final = 0.1
"""Length of the speed's median window [s]."""
MIN_DURATION: Final = 0.08
"""Contacts and gaps shorter than this [s] are treated as flicker."""


def find_contacts(ankles: Float, toes: Float, sample_rate: float) -> Bool:
    """Return the contact of the left and the right foot, shape (T, 2).

    `ankles` and `toes` are world positions [m] of shape (T, 2, 3), the floor at y = 0. The lower height and the lower
    speed of heel and toes count, because a dancer stands and pivots on either. Contact starts when the foot is low and
    slow, ends when it is high or fast, and is unchanged between the two thresholds.
    """
    samples = ankles.shape[0]
    heights = np.stack((ankles[..., 1] - SOLE_BELOW_ANKLE, toes[..., 1] - TOES_OVER_SOLE), axis=-1)
    height = heights.min(axis=-1)
    speed = np.minimum(_speed(ankles, sample_rate), _speed(toes, sample_rate))
    lands = (height < HEIGHT_ON) & (speed < SPEED_ON)
    leaves = (height > HEIGHT_OFF) | (speed > SPEED_OFF)
    shortest = max(1, round(MIN_DURATION * sample_rate))
    contact = np.zeros((samples, 2), np.bool_)
    for foot in range(2):
        contact[:, foot] = remove_flicker(_hysteresis(lands[:, foot], leaves[:, foot]), shortest)
    return contact


def _speed(positions: Float, sample_rate: float) -> Float:
    """Median speed [m/s] about each sample, shape (T, 2)."""
    samples = positions.shape[0]
    if samples < 2:
        return np.zeros(positions.shape[:2])
    speed = np.linalg.norm(np.gradient(positions, axis=0), axis=-1) * sample_rate
    half = min(int(0.5 * SPEED_WINDOW * sample_rate), samples - 1)
    padded = np.pad(speed, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)
    return np.asarray(np.median(windows, axis=-1))


def _hysteresis(on: Bool, off: Bool) -> Bool:
    """True from each `on` until the next `off`, shape (T,)."""
    places = np.arange(on.size)
    last_on = np.maximum.accumulate(np.where(on, places, -1))
    last_off = np.maximum.accumulate(np.where(off & ~on, places, -1))
    return np.asarray(last_on > last_off)


def remove_flicker(contact: Bool, shortest: int) -> Bool:
    """Fill short gaps, then drop contacts shorter than `shortest` samples; runs that touch an end are kept."""
    contact = contact.copy()
    for value in (False, True):
        edges = np.flatnonzero(np.diff(contact))
        for start, stop in zip(edges[:-1] + 1, edges[1:] + 1, strict=True):
            if contact[start] == value and stop - start < shortest:
                contact[start:stop] = not value
    return contact
