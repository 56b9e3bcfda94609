"""Which foot is on the floor: height and speed with hysteresis."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

Float = npt.NDArray[np.floating]
Bool = npt.NDArray[np.bool_]

TOES_OVER_SOLE: Final = SOLE_BELOW_ANKLE + float(SKELETON.offsets[SKELETON.index("leftToes"), 1])
"""Height [m] of the toe joint over the floor when the foot stands flat."""

SPEED_ON: Final = 0.15
"""A foot slower than this [m/s] may land; the usual bar for contact (toe speed, median over 0.1 s)."""
SPEED_OFF: Final = 0.45
"""A foot faster than this [m/s] has left; it may slide or pivot below it, as dancers do."""
HEIGHT_ON: Final = 0.045
HEIGHT_OFF: Final = 0.09
"""Heights [m] of the lower one of heel and toe, likewise."""
SPEED_WINDOW: Final = 0.1
"""Seconds over which the median of the speed is taken."""
SHORTEST: Final = 0.08
"""Contacts and gaps shorter than this [s] are flicker."""


def find_contacts(ankles: Float, toes: Float, sample_rate: float) -> Bool:
    """Contact of the left and the right foot, shape (T, 2).

    `ankles` and `toes` are world positions [m] of shape (T, 2, 3), the floor at y = 0. Of heel and toes the lower
    and the slower one counts (one stands and pivots on either). A foot lands when it is low and slow and leaves when
    it is high or fast; between the two bars it does what it did.
    """
    samples = ankles.shape[0]
    heights = np.stack((ankles[..., 1] - SOLE_BELOW_ANKLE, toes[..., 1] - TOES_OVER_SOLE), axis=-1)
    height = heights.min(axis=-1)
    speed = np.minimum(_speed(ankles, sample_rate), _speed(toes, sample_rate))
    lands = (height < HEIGHT_ON) & (speed < SPEED_ON)
    leaves = (height > HEIGHT_OFF) | (speed > SPEED_OFF)
    shortest = max(1, round(SHORTEST * sample_rate))
    contact = np.zeros((samples, 2), np.bool_)
    for foot in range(2):
        contact[:, foot] = _without_flicker(_hold(lands[:, foot], leaves[:, foot]), shortest)
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


def _hold(on: Bool, off: Bool) -> Bool:
    """True from each `on` until the next `off`, shape (T,)."""
    places = np.arange(on.size)
    last_on = np.maximum.accumulate(np.where(on, places, -1))
    last_off = np.maximum.accumulate(np.where(off & ~on, places, -1))
    return np.asarray(last_on > last_off)


def _without_flicker(contact: Bool, shortest: int) -> Bool:
    """First fill gaps, then drop contacts of fewer than `shortest` samples; those at the ends may be cut and stay."""
    contact = contact.copy()
    for value in (False, True):
        edges = np.flatnonzero(np.diff(contact))
        for start, stop in zip(edges[:-1] + 1, edges[1:] + 1, strict=True):
            if contact[start] == value and stop - start < shortest:
                contact[start:stop] = not value
    return contact
