"""One unit laid on a stretch of the input: the rigid motion of the floor that fits best, and what is left (H002-H004).

This is the plain form, for one window at a time: what kernels and matrix products do for all of them at once is
measured against it.
"""

from dataclasses import dataclass

import numpy as np

from live.motion.partner.cloud import Cloud


@dataclass(frozen=True, slots=True)
class Fit:
    """M (2) and D (1)."""

    turn: complex
    """Rotation about the vertical as a unit number."""
    shift: complex
    """What is added after it [m]."""
    distance: float
    """Sum over samples and points of the squared distances that remain [m²]."""


def stretched(cloud: Cloud, start: float, length: float, duration: int) -> Cloud:
    """The samples `start` to `start + length` of a cloud in `duration` equal steps: `duration` + 1 samples."""
    return cloud.at(np.asarray(start + np.arange(duration + 1) * (length / duration), np.float64))


def fit(x: Cloud, a: Cloud) -> Fit:
    """D(x, a) and the M that it is taken at, in closed form (K001): ground translation and vertical rotation.

    Both clouds have the same shape. Heights are compared as they are. Where every rotation is as good (all points of
    one in one place) there is none.
    """
    middle_x, middle_a = x.floor.mean(), a.floor.mean()
    product = complex(np.sum(np.conj(a.floor - middle_a) * (x.floor - middle_x)))
    turn = product / abs(product) if abs(product) > 1e-12 else complex(1.0)
    shift = complex(middle_x - turn * middle_a)
    moved = a.moved(turn, shift)
    left = np.sum(np.abs(x.floor - moved.floor) ** 2) + np.sum((x.height - moved.height) ** 2)
    return Fit(turn, shift, float(left))


def gap(tail: Cloud, head: Cloud) -> float:
    """C (4): the squared distance [m²] of the last sample of `tail` from the first of `head`."""
    floor = np.abs(tail.floor[-1] - head.floor[0]) ** 2
    return float(floor.sum() + ((tail.height[-1] - head.height[0]) ** 2).sum())
