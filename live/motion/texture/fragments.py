"""Fragments: where curves are broken, at the turning points of one band of one angle (P006).

Joining: fragments laid end to end become one curve without jumps and kinks (P014-P017).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

LEAST: Final = 3
"""Samples between cuts: a fragment of fewer is no movement, and nothing could be joined in it."""


@dataclass(frozen=True, slots=True, eq=False)
class Fragments:
    """F fragments of one or several clips laid one after the other; neighbours share the sample of the cut."""

    begin: Int64
    """First sample of each, (F,), increasing."""
    end: Int64
    """Its last sample, (F,)."""
    clip: Int64
    """The clip each is of, (F,)."""

    @property
    def count(self) -> int:
        """Number of fragments F."""
        return len(self.begin)

    @property
    def length(self) -> Int64:
        """Samples of each less one, (F,)."""
        return self.end - self.begin

    def follows(self, first: int, second: int) -> bool:
        """Whether `second` comes right after `first` in the data (P011)."""
        return bool(second == first + 1 and self.clip[first] == self.clip[second])


def find_cuts(curve: Float64, least: int = LEAST) -> Int64:
    """Samples at which `curve` (T,) is cut: its ends, and wherever its derivative changes sign between them.

    A curve that rests goes on as it went before. Cuts are at least `least` samples apart.
    """
    sign = np.sign(np.diff(curve))
    moving = np.flatnonzero(sign)
    turns = moving[1:][sign[moving[1:]] != sign[moving[:-1]]] if len(moving) else moving
    last = len(curve) - 1
    cuts = [0]
    for turn in turns.tolist():
        if turn - cuts[-1] >= least and last - turn >= least:
            cuts.append(turn)
    return np.array([*cuts, last] if last > 0 else cuts, np.int64)


def fragments_of(cuts: list[Int64], starts: list[int]) -> Fragments:
    """The fragments between the `cuts` of each clip, whose first sample is `starts[n]` in all."""
    begin = [c[:-1] + start for c, start in zip(cuts, starts, strict=True)]
    end = [c[1:] + start for c, start in zip(cuts, starts, strict=True)]
    clip = [np.full(len(c) - 1, n, np.int64) for n, c in enumerate(cuts)]
    return Fragments(np.concatenate(begin), np.concatenate(end), np.concatenate(clip))


Bool = npt.NDArray[np.bool_]

REACH: Final = 10
"""N of P016 in samples of 24 a second; 5 to 20 are useful."""
SHORTEST: Final = 2
"""With less beside the join there is nothing to fit to."""
LEFT_OUT: Final = 2
"""Samples beside the join that the quadratic is not fitted to (P016)."""


def skewed(parts: list[Float64]) -> list[Float64]:
    """Fragments (n_i, D) whose neighbours meet: at the mean of what the one ends and the next one begins with.

    The line through a fragment's old ends is taken away and the line through its new ones added (P014, P015).
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


def laid(parts: list[Float64]) -> Float64:
    """Fragments one after the other, sharing the sample at which they meet, (T, D)."""
    return np.concatenate([parts[0], *(part[1:] for part in parts[1:])])


def blend(reach: int) -> Float64:
    """How much of the quadratic there is at -reach to reach samples from the join: cos²(π t / 2 N), (2 N + 1,).

    1 at the join and 0, without slope, at the ends. (The paper prints (cos + 1)², which is 4 and 1 there, and says
    sine squared; P017.)
    """
    return np.cos(0.5 * np.pi * np.arange(-reach, reach + 1) / max(reach, 1)) ** 2


def quadratic(signal: Float64, join: int, reach: int) -> Float64:
    """The parabola fitted to `signal` (T, D) from `reach` to LEFT_OUT samples away from `join` on both sides, at all of
    these samples, (2 reach + 1, D) (P016).

    Two points on each side, at least, decide it: with a reach of 2 those 1 sample away count, too.
    """
    t = np.arange(-reach, reach + 1.0)
    fitted = np.abs(t) >= min(LEFT_OUT, reach - 1)
    powers = t[:, None] ** np.arange(3)
    return np.asarray(powers @ (np.linalg.pinv(powers[fitted]) @ signal[join - reach : join + reach + 1][fitted]))


def smoothed(signal: Float64, joins: Int64, most: int = REACH, consecutive: Bool | None = None) -> Float64:
    """`signal` (T, D) with its kinks at `joins` (n,) blended into parabolas (P016, P017), (T, D).

    N, for the fit as for the blend, is `most` or half of the shorter of the two fragments, whichever is less: so no
    two blends overlap and the parabola is nowhere used beyond what it was fitted to. Joins that are `consecutive` (n,)
    in the data are left alone.
    """
    out = signal.copy()
    edges = np.concatenate(([0], joins, [len(signal) - 1]))
    for index, join in enumerate(joins.tolist()):
        reach = int(min(most, (join - edges[index]) // 2, (edges[index + 2] - join) // 2))
        if reach < SHORTEST or (consecutive is not None and consecutive[index]):
            continue
        part = slice(join - reach, join + reach + 1)
        f = blend(reach)[:, None]
        out[part] = f * quadratic(signal, join, reach) + (1.0 - f) * signal[part]
    return out
