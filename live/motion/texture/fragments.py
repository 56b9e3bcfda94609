"""Fragments: where curves are broken, at the turning points of one band of one angle (P006)."""

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
