"""Single support: the stretches of a measure in which one foot alone carries the dancer (T048)."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.editing.feet import Feet

Float = npt.NDArray[np.floating]
Bool = npt.NDArray[np.bool_]

LIFTED: Final = 0.20
"""One foot carries where the feet's heights differ by more than this share of the largest difference (T048)."""
SHORTEST: Final = 0.1
"""Stretches shorter than this [s] are errors (T048). The thesis says 10 frames without a rate; its OptiTrack cameras
and its N = 100 frames for a measure fit 100 frames a second."""
LEAST_LIFT: Final = 0.01
"""Where the feet's heights never differ by more than this [m], no foot is ever lifted (a share of nothing is noise)."""


@dataclass(frozen=True, slots=True)
class Support:
    """The samples `start` to `stop` (exclusive), in which `foot` alone carries."""

    start: int
    stop: int
    foot: int
    """0 the left, 1 the right: the lower one (T049)."""
    point: tuple[float, float]
    """Where the ball of that foot stands on the floor (x, z) [m]: its mean over the stretch."""

    @property
    def samples(self) -> int:
        """Length in samples."""
        return self.stop - self.start


def height_difference(feet: Feet) -> Float:
    """d(t) = |height_R - height_L| [m] of the soles, shape (T,) (T048: of the heights, not of the feet themselves)."""
    height = feet.height
    return np.asarray(np.abs(height[:, 1] - height[:, 0]))


def find_supports(
    feet: Feet, sample_rate: float, start: int, stop: int, *, last: int | None = None, contact: Bool | None = None
) -> list[Support]:
    """The single supports among the samples `start` to `stop` (exclusive), in order (T048).

    The bar is 20 % of the largest d(t) in that range, which is one measure: "we are editing the motions at each
    measure". Samples from `last` on (the blend window, T050) count for the bar but are not selected. A stretch in
    which the feet change over (one lands before the other's lift is seen) is cut where the lower foot changes.
    Where `contact` (T, 2), the clip's own annotation, has both feet on the floor, neither carries alone: a low foot
    that drags differs in height from the other and would be swept along.
    """
    difference = height_difference(feet)[start:stop]
    if difference.size == 0 or difference.max() < LEAST_LIFT:
        return []
    chosen = difference > LIFTED * difference.max()
    if last is not None:
        chosen[max(last - start, 0) :] = False
    if contact is not None:
        chosen &= ~contact[start:stop].all(axis=1)
    lower = np.argmin(feet.height[start:stop], axis=1)
    state = np.where(chosen, 1 + lower, 0)
    edges = np.flatnonzero(np.diff(state, prepend=0, append=0))
    shortest = SHORTEST * sample_rate
    supports = []
    for begin, end in pairwise(edges):
        if state[begin] == 0 or end - begin < shortest - 1e-9:
            continue
        foot = int(state[begin]) - 1
        x, _, z = feet.ball[start + begin : start + end, foot].mean(axis=0)
        supports.append(Support(int(start + begin), int(start + end), foot, (float(x), float(z))))
    return supports
