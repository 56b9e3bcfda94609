"""Give: how far legs let a dancer be carried beyond a measure's own way while her feet hold their places."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.pose.rise import MOST_HELD, QUICKEST, stances
from live.motion.pose.shifting_kernels import DIRECTIONS, KNOTS, RATE, SHARE
from live.motion.skeleton import SKELETON

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

LEG: Final = sum(float(np.linalg.norm(SKELETON.offsets[SKELETON.index(name)])) for name in ("leftLowerLeg", "leftFoot"))
"""Length of a leg from hip to ankle [m]."""
BUFFER: Final = 0.015
"""A leg is never stretched beyond its length less this [m] (the pose kernels' own rule)."""
SINK: Final = 0.01
"""The hips may sink by this [m] for it: half of what the pose kernels allow."""
SLIDES: Final = 0.2
"""A foot that moves this far [m] while it is said to stand is not planted: the foot lock lets go."""
STANDING: Final = 0.08
"""Where no foot is ever lifted a dancer is carried this far [m] at most: her feet are never put down anew."""


def give_of(hip: Float64, ankle: Float64, contact: Bool, rise: Float64, *, follows: bool) -> Float64:
    """How far [m] a dancer may be carried in DIRECTIONS ways about the clip's own heading, shape (DIRECTIONS,).

    `hip` and `ankle` (T, 2, 3) [m] of both legs and `contact` (T, 2), evenly spaced over the measure; `rise`
    (KNOTS, 2). While a foot stands the body goes over it by the share that comes in meanwhile: the leg must reach, and
    no foot is held against more than MOST_HELD. A foot that slides in the clip itself holds nothing. Direction k is
    that of yaw 2 pi k / DIRECTIONS.
    """
    planted = [stance for stance in stances(contact) if not _slides(ankle, *stance)]
    follows |= len(planted) < len(stances(contact))
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ways = np.stack((np.sin(angle), np.cos(angle)), axis=1)
    places = np.linspace(0.0, 1.0, len(contact))
    share = np.interp(places, np.linspace(0.0, 1.0, KNOTS), rise[:, SHARE])
    give = np.full(DIRECTIONS, QUICKEST / rise[:, RATE].max() if follows else STANDING)
    for foot, begin, end in planted:
        risen = share[begin:end] - share[begin]
        if risen[-1] <= 1e-3:
            continue
        leg = ankle[begin:end, foot] - hip[begin:end, foot]
        longest = np.maximum(LEG - BUFFER, np.linalg.norm(leg, axis=1))
        level = longest**2 - np.minimum(leg[:, 1] + SINK, 0.0) ** 2  # squared reach on the floor
        flat = leg[:, (0, 2)]
        along = flat @ ways.T  # the body goes ahead, so the foot comes nearer by this, and then falls behind
        spare = np.maximum(level - np.sum(flat * flat, axis=1), 0.0)[:, None]
        far = along + np.sqrt(along * along + spare)
        moves = risen > 1e-3
        give = np.minimum(give, np.min(far[moves] / risen[moves, None], axis=0))
        give = np.minimum(give, MOST_HELD / risen[-1])
    return np.asarray(np.maximum(give, 0.0))


def holds_of(ankle: Float64, contact: Bool, rise: Float64) -> Float64:
    """Share of the correction that is in before each foot that stands at the beginning is lifted, shape (2,)."""
    share = np.interp(np.linspace(0.0, 1.0, len(contact)), np.linspace(0.0, 1.0, KNOTS), rise[:, SHARE])
    holds = np.zeros(2)
    for foot, begin, end in stances(contact):
        if begin == 0 and not _slides(ankle, foot, begin, end):
            holds[foot] = share[end - 1]
    return holds


def _slides(ankle: Float64, foot: int, begin: int, end: int) -> bool:
    """Whether the clip itself drags that foot, from `ankle` (T, 2, 3), farther than the foot lock would hold it."""
    way = ankle[begin:end, foot][:, (0, 2)]
    return bool(np.ptp(way, axis=0).max() > SLIDES)
