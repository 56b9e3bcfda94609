"""Cutting of curves into fragments at turning points of one band of one angle, and joining without jumps and kinks.

Cutting is P006, joining P014-P017.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64, Int64

MIN_LENGTH: Final = 3
"""Fewest samples between cuts: a shorter fragment is no movement and leaves no room for a join."""


@dataclass(frozen=True, slots=True, eq=False)
class Fragments:
    """F fragments of one or several concatenated clips. Neighbours share the sample of the cut."""

    begin: Int64
    """First sample of each fragment, (F,), increasing."""
    end: Int64
    """Last sample of each, (F,)."""
    clip: Int64
    """Index of the clip of each, (F,)."""

    @property
    def count(self) -> int:
        """Number of fragments F."""
        return len(self.begin)

    @property
    def length(self) -> Int64:
        """Number of samples of each, minus one, (F,)."""
        return self.end - self.begin

    def follows(self, first: int, second: int) -> bool:
        """Whether `second` comes right after `first` in the data (P011)."""
        return bool(second == first + 1 and self.clip[first] == self.clip[second])


def find_cuts(curve: Float64, min_length: int = MIN_LENGTH) -> Int64:
    """Return the samples at which `curve` (T,) is cut: its ends and the sign changes of its derivative.

    A constant stretch keeps the sign before it. Cuts are at least `min_length` samples apart.
    """
    sign = np.sign(np.diff(curve))
    moving = np.flatnonzero(sign)
    turns = moving[1:][sign[moving[1:]] != sign[moving[:-1]]] if len(moving) else moving
    last = len(curve) - 1
    cuts = [0]
    for turn in turns.tolist():
        if turn - cuts[-1] >= min_length and last - turn >= min_length:
            cuts.append(turn)
    return np.array([*cuts, last] if last > 0 else cuts, np.int64)


def make_fragments(cuts: list[Int64], starts: list[int]) -> Fragments:
    """Return the fragments between the `cuts` of each clip; clip n starts at sample `starts[n]` of the whole data."""
    begin = [c[:-1] + start for c, start in zip(cuts, starts, strict=True)]
    end = [c[1:] + start for c, start in zip(cuts, starts, strict=True)]
    clip = [np.full(len(c) - 1, n, np.int64) for n, c in enumerate(cuts)]
    return Fragments(np.concatenate(begin), np.concatenate(end), np.concatenate(clip))


BLEND_REACH: Final = 10
"""N of P016 [samples at 24 Hz]; 5 to 20 are useful."""
MIN_REACH: Final = 2
"""With fewer samples on each side of the join there is nothing to fit."""
FIT_GAP: Final = 2
"""Samples next to the join that are excluded from the quadratic fit (P016)."""


def skew_to_meet(parts: list[Float64]) -> list[Float64]:
    """Return the fragments (n_i, D) skewed so that neighbours meet at the mean of their ends.

    The line through a fragment's old ends is subtracted and the line through its new ends added (P014, P015).
    """
    first = [part[0] for part in parts]
    last = [part[-1] for part in parts]
    meet = [0.5 * (end + begin) for end, begin in zip(last[:-1], first[1:], strict=True)]
    begins, ends = [first[0], *meet], [*meet, last[-1]]
    out = []
    for part, begin, end in zip(parts, begins, ends, strict=True):
        share = np.linspace(0.0, 1.0, len(part))[:, None]
        line = (begin - part[0]) * (1.0 - share) + (end - part[-1]) * share
        out.append(part + line)
    return out


def concatenate_fragments(parts: list[Float64]) -> Float64:
    """Return the fragments concatenated, with shared samples where they meet, (T, D)."""
    return np.concatenate([parts[0], *(part[1:] for part in parts[1:])])


def blend_weights(reach: int) -> Float64:
    """Return the weight of the quadratic at -reach to reach samples from the join: cos²(π t / 2 N), (2 N + 1,).

    It is 1 at the join and 0, with zero slope, at the ends. (The paper prints (cos + 1)², which is 4 and 1 there, and
    calls it sine squared; P017.)
    """
    return np.cos(0.5 * np.pi * np.arange(-reach, reach + 1) / max(reach, 1)) ** 2


def fit_quadratic(signal: Float64, join: int, reach: int) -> Float64:
    """Fit a parabola to `signal` (T, D) from `reach` to LEFT_OUT samples away from `join` on both sides (P016).

    Return it at all samples within `reach`, (2 reach + 1, D). The fit needs at least two points on each side, so with
    a reach of 2 the samples next to the join are included.
    """
    t = np.arange(-reach, reach + 1.0)
    fitted = np.abs(t) >= min(FIT_GAP, reach - 1)
    powers = t[:, None] ** np.arange(3)
    return np.asarray(powers @ (np.linalg.pinv(powers[fitted]) @ signal[join - reach : join + reach + 1][fitted]))


def smooth_joins(
    signal: Float64, joins: Int64, max_reach: int = BLEND_REACH, consecutive: Bool | None = None
) -> Float64:
    """Return `signal` (T, D) with its kinks at `joins` (n,) blended into parabolas (P016, P017), (T, D).

    N, for fit and blend, is the smaller of `max_reach` and half of the shorter of the two fragments. So no two blends
    overlap and the parabola is never extrapolated. Joins that are `consecutive` (n,) in the data are unchanged.
    """
    out = signal.copy()
    edges = np.concatenate(([0], joins, [len(signal) - 1]))
    for index, join in enumerate(joins.tolist()):
        reach = int(min(max_reach, (join - edges[index]) // 2, (edges[index + 2] - join) // 2))
        if reach < MIN_REACH or (consecutive is not None and consecutive[index]):
            continue
        part = slice(join - reach, join + reach + 1)
        f = blend_weights(reach)[:, None]
        out[part] = f * fit_quadratic(signal, join, reach) + (1.0 - f) * signal[part]
    return out
