"""Rise: when within a measure a dancer may be carried, from what her clip says of her feet (T048, for ways)."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.shifting.kernels import KNOTS

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

FINE: Final = 16
"""Places between two knots at which the feet are looked at."""
LEAST: Final = 0.04
"""Share of the measure in which feet must be in the air at least, or the way is spread over all of it."""


def rise_of(contact: Bool, *, last: float) -> tuple[Float64, bool]:
    """The rise (KNOTS, 2) of a measure, and whether it follows the feet.

    `contact` (T, 2): whether each foot is on the floor, evenly spaced from the measure's beginning to its end. The
    share rises while exactly one foot carries, or none, and not after `last` (share of the measure), where the blend
    lies (T050). Where no foot is ever lifted it rises all the time: an ease.
    """
    fine = np.linspace(0.0, 1.0, FINE * (KNOTS - 1) + 1)
    at = np.minimum((fine * (len(contact) - 1)).round().astype(np.int64), len(contact) - 1)
    free = ~contact[at].all(axis=1) & (fine < last)
    follows = bool(free.mean() >= LEAST)
    if not follows:
        free = fine < last
    knots = _knots(_humps(free, fine))
    share = np.concatenate(([0.0], np.cumsum(0.5 * (knots[1:] + knots[:-1])) / (KNOTS - 1)))
    return np.ascontiguousarray(np.stack((share, knots), axis=1) / share[-1]), follows


def _humps(free: Bool, fine: Float64) -> Float64:
    """A rate at each fine place: in every free stretch a hump that begins and ends at 0, as high as it is long."""
    edges = np.flatnonzero(np.diff(free.astype(np.int8), prepend=0, append=0))
    rate = np.zeros(len(fine))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        u = (np.arange(begin, end) + 0.5 - begin) / (end - begin)
        rate[begin:end] = 6.0 * u * (1.0 - u)
    return rate


def _knots(rate: Float64) -> Float64:
    """Rates at the knots, from those at fine places: means about each knot, 0 at both ends."""
    padded = np.pad(rate, FINE // 2)
    knots = np.array([padded[k * FINE : (k + 1) * FINE + 1].mean() for k in range(KNOTS)])
    knots[0] = knots[-1] = 0.0
    return knots
