"""Give: how far legs let a dancer be carried beyond a measure's own way while her feet hold their places.

Rise: when within a measure a dancer may be carried, from what her clip says of her feet (T048, for ways).
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.pose.root_warp_kernels import DIRECTIONS, KNOTS, RATE, SHARE, share_out
from live.motion.skeleton import SKELETON

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]

FINE: Final = 16
"""Places between two knots at which the feet are looked at."""
LEAST: Final = 0.04
"""Share of the measure in which feet must be in the air at least, or the way is spread over all of it."""
MOST_HELD: Final = 0.15
"""A foot is held against a way of at most this [m] while it stands; the lock lets it go at 0.2 m."""
QUICKEST: Final = 1.3
"""Metres per measure at which a dancer is carried at most."""
ROUNDS: Final = 256
"""Rounds in which the stretches' shares are weighed against each other."""


def rise_of(contact: Bool, *, last: float) -> tuple[Float64, bool]:
    """The rise (KNOTS, 2) of a measure, and whether it follows the feet.

    `contact` (T, 2): whether each foot is on the floor, evenly spaced from the measure's beginning to its end. The
    share rises while exactly one foot carries, or none, and not after `last` (share of the measure), where the blend
    lies (T050). Of several such stretches each gets a share, such that the way that any foot is held against while it
    stands is as short as can be. Where no foot is ever lifted it rises all the time: an ease.
    """
    fine = np.linspace(0.0, 1.0, FINE * (KNOTS - 1) + 1)
    stands = contact[np.minimum((fine * (len(contact) - 1)).round().astype(np.int64), len(contact) - 1)]
    free = ~stands.all(axis=1) & (fine < last)
    follows = bool(free.mean() >= LEAST)
    if not follows:
        free = fine < last
    humps = _humps(free)
    knots = _knots(_weights(humps, stands) @ humps)
    share = np.concatenate(([0.0], np.cumsum(0.5 * (knots[1:] + knots[:-1])) / (KNOTS - 1)))
    return np.ascontiguousarray(np.stack((share, knots), axis=1) / share[-1]), follows


def stances(contact: Bool) -> list[tuple[int, int, int]]:
    """Foot, first sample and the one after the last of all times in which a foot stands, from `contact` (T, 2)."""
    found = []
    for foot in range(2):
        edges = np.flatnonzero(np.diff(contact[:, foot].astype(np.int8), prepend=0, append=0))
        found += [(foot, int(begin), int(end)) for begin, end in zip(edges[::2], edges[1::2], strict=True)]
    return found


def _humps(free: Bool) -> Float64:
    """For each free stretch a rate that begins and ends at 0, shape (K, F): each adds up to 1."""
    edges = np.flatnonzero(np.diff(free.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    humps = np.zeros((len(edges), len(free)))
    for hump, (begin, end) in zip(humps, edges, strict=True):
        u = (np.arange(begin, end) + 0.5 - begin) / (end - begin)
        hump[begin:end] = u * (1.0 - u)
    return np.asarray(humps / humps.sum(axis=1, keepdims=True))


def _weights(humps: Float64, stands: Bool) -> Float64:
    """Shares (K,) of the stretches, for which the dearest of all costs is least.

    Costs are the shares of the way that a foot is held against while it stands, and the speed in a stretch. This is a
    game of two, whoever shares out and whoever names the dearest cost, and `share_out` plays it.
    """
    lengths = (humps > 0.0).mean(axis=1)
    held = [humps[:, begin:end].sum(axis=1) / MOST_HELD for _, begin, end in stances(stands)]
    costs = np.stack([*held, *np.diag(1.5 / (lengths * QUICKEST))])
    weights: Float64 = lengths / lengths.sum()
    share_out(costs, weights, ROUNDS)
    return weights


def _knots(rate: Float64) -> Float64:
    """Rates at the knots, from those at fine places: means about each knot, 0 at both ends."""
    passed = np.concatenate(([0.0], np.cumsum(rate)))
    middle = FINE * np.arange(1, KNOTS - 1)
    knots = np.zeros(KNOTS)
    knots[1:-1] = (passed[middle + FINE // 2 + 1] - passed[middle - FINE // 2]) / (FINE + 1)
    return knots


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
