"""Splits of recordings for cross-validation: takes of one choreography stay on one side of every split.

Two takes are *copies* if their legs move alike at one lag and at no other: dancers in unison, or one dancer who dances
the same step twice. An upper body "predicted" for one of them was in the data. Walkers agree at many lags, one for
every stride, so they are no copies.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64, Int64
from live.motion import quaternion
from live.motion.quaternion import mean_rotation
from live.motion.texture.frequency_bands import RATE, SampledClip, split_bands
from live.motion.texture.texture_settings import JOINT_GROUPS

COPY_CORRELATION: Final = 0.5
"""Least correlation of the legs of two copies at their best lag."""
COPY_EXCESS: Final = 0.4
"""How much the correlation of copies at their best lag must exceed that at all other lags: unrelated or periodic takes
reach 0.3 at most."""
OTHER_LAG_S: Final = 0.5
"""Lags farther from the best one than this [s] are other lags."""
MIN_OVERLAP_S: Final = 2.0
"""Shortest common time [s] at which legs are compared, and at least half of the shorter take."""
GAP_S: Final = 1.0
"""Samples nearer than this [s] to a held-out part of the same take are not learnt from: neighbours are alike."""
MAX_FOLDS: Final = 8
BLOCKS: Final = 4
"""Parts into which takes are divided where all of them are one choreography."""
_BANDS: Final = slice(1, 6)
_LEG_JOINTS: Final = (*JOINT_GROUPS["hips"], *JOINT_GROUPS["knees"])


@dataclass(frozen=True, slots=True)
class TakeCopy:
    """Two takes of one choreography."""

    first: int
    second: int
    """Indices of the takes."""
    lag_s: float
    """Time in the first take minus the time in the second one at which legs are alike [s]."""
    correlation: float
    """Correlation of the legs there."""


def find_copies(takes: Sequence[SampledClip]) -> tuple[TakeCopy, ...]:
    """Return the pairs of takes whose legs agree at one lag far more than at any other."""
    if len(takes) < 2:
        return ()
    middle = np.asarray(mean_rotation(np.concatenate([take.rotation[:, _LEG_JOINTS] for take in takes])), np.float64)
    legs = [_leg_bands(take, middle) for take in takes]
    found = []
    for second in range(1, len(takes)):
        for first in range(second):
            lags, values = _lag_correlations(legs[first], legs[second])
            if not len(values):
                continue
            best = int(np.argmax(values))
            other = values[np.abs(lags - lags[best]) > OTHER_LAG_S * RATE]
            chance = max(float(other.max(initial=-1.0)), 0.0)
            # without other lags, takes too short to be told from periodic ones count as copies only if nearly equal
            least = COPY_CORRELATION if len(other) else 0.95
            if values[best] >= least and values[best] - chance >= COPY_EXCESS:
                found.append(TakeCopy(first, second, float(lags[best]) / RATE, float(values[best])))
    return tuple(found)


def _leg_bands(take: SampledClip, middle: Float64) -> Float64:
    """Return bands 2 to 6 of the legs' angles, (T, 12)."""
    away = quaternion.mul(quaternion.inverse(middle), take.rotation[:, _LEG_JOINTS])
    return np.asarray(split_bands(quaternion.to_rotation_vector(away), 6)[_BANDS].sum(axis=0).reshape(len(away), -1))


def _lag_correlations(a: Float64, b: Float64) -> tuple[Int64, Float64]:
    """Return the lags with enough common time, (n,), and the correlation of a[t + lag] with b[t] at each."""
    size = 1 << (len(a) + len(b) - 1).bit_length()
    product = np.fft.rfft(a, size, axis=0) * np.conj(np.fft.rfft(b, size, axis=0))
    products = np.fft.irfft(product.sum(axis=1), size)
    lags = np.arange(1 - len(b), len(a))
    sums = [np.concatenate(([0.0], np.cumsum((one * one).sum(axis=1)))) for one in (a, b)]
    low, high = np.maximum(0, lags), np.minimum(len(a), lags + len(b))
    energy = (sums[0][high] - sums[0][low]) * (sums[1][high - lags] - sums[1][low - lags])
    enough = high - low >= max(MIN_OVERLAP_S * RATE, 0.5 * min(len(a), len(b)))
    scale = np.sqrt(np.maximum(energy, 1e-18))
    values = np.where(energy > 1e-12, products[lags % size] / scale, 0.0)
    return lags[enough], values[enough]


@dataclass(frozen=True, slots=True, eq=False)
class Choreographies:
    """The choreography of each of n takes, and their common time."""

    number: Int64
    """Number of the choreography of each take, (n,), from 0."""
    offset: Int64
    """Samples to add to a take's time to get the time in its choreography, (n,)."""

    @property
    def count(self) -> int:
        """Number of choreographies."""
        return int(self.number.max(initial=-1)) + 1


def choreographies(count: int, copies: Sequence[TakeCopy]) -> Choreographies:
    """Return the choreographies of `count` takes: copies of copies share one."""
    number, offset = np.arange(count), np.zeros(count, np.int64)
    for copy in copies:
        first, second = int(number[copy.first]), int(number[copy.second])
        if first != second:
            moved = number == second
            offset[moved] += offset[copy.first] + round(copy.lag_s * RATE) - offset[copy.second]
            number[moved] = first
    return Choreographies(np.asarray(np.unique(number, return_inverse=True)[1], np.int64), offset)


@dataclass(frozen=True, slots=True, eq=False)
class Fold:
    """One split of all samples S of the concatenated takes."""

    learnt: Bool
    """Samples that are learnt from, (S,)."""
    tested: Bool
    """Samples that are left out and predicted, (S,)."""


def make_folds(lengths: Sequence[int], dances: Choreographies) -> list[Fold]:
    """Return folds that leave out every sample once, with all takes of a choreography in the same fold.

    `lengths` (n,) are the takes' samples. If there is only one choreography, its parts are left out in turn, the same
    part of all takes, without the samples next to it.
    """
    starts = np.concatenate(([0], np.cumsum(lengths)))
    at = np.arange(int(starts[-1]))
    take = np.searchsorted(starts, at, side="right") - 1
    if dances.count > 1:
        sizes = np.bincount(dances.number, weights=np.asarray(lengths, np.float64))
        fold_of = np.zeros(len(sizes), np.int64)
        filled = np.zeros(min(MAX_FOLDS, len(sizes)))
        for one in np.argsort(-sizes, kind="stable").tolist():
            fold_of[one] = int(np.argmin(filled))
            filled[fold_of[one]] += sizes[one]
        fold = fold_of[dances.number][take]
        return [Fold(fold != n, fold == n) for n in range(len(filled))]
    time = at - starts[take] + dances.offset[take]
    first, length = int(time.min()), int(time.max() - time.min()) + 1
    folds = []
    for n in range(BLOCKS):
        begin, end = first + n * length // BLOCKS, first + (n + 1) * length // BLOCKS
        far = (time < begin - GAP_S * RATE) | (time >= end + GAP_S * RATE)
        folds.append(Fold(far, (time >= begin) & (time < end)))
    return [fold for fold in folds if fold.learnt.any() and fold.tested.any()]
