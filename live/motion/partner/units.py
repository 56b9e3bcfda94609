"""Units: synchronised stretches of a leader's and a follower's recording that mean something together (H001)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.partner.cloud import Cloud

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

BEATS_OF_UNIT: Final = 2
"""A unit of dance is two beats long (H001)."""


@dataclass(frozen=True, slots=True)
class Hold:
    """Two hands that hold each other for a while; hands are 0 left, 1 right."""

    leader_hand: int
    follower_hand: int
    begin: float
    """Sample at which it begins."""
    end: float


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """One pair of recordings, sample by sample beside each other, in one frame of the world."""

    name: str
    control: Cloud
    """What the leader does."""
    target: Cloud
    """What the follower does, at the same times."""
    follower: Clip
    """The follower's motion that is copied from."""
    cuts: Float64
    """Samples at which one unit ends and the next begins, ascending, (n + 1,)."""
    beats: Float64
    """Samples of all beats, (n,); empty where none are known."""
    holds: tuple[Hold, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Units:
    """N units of some examples, all at one rate; the database of the mapping."""

    examples: tuple[Example, ...]
    example: Int64
    """Which example each unit is of, (N,)."""
    start: Float64
    """Sample of its recording at which each unit begins, (N,)."""
    length: Float64
    """How many samples it is long, (N,)."""

    @property
    def count(self) -> int:
        """Number of units N."""
        return len(self.start)

    @property
    def rate(self) -> float:
        """Samples per second of `start` and `length` [Hz]."""
        return self.examples[0].control.rate

    @property
    def seconds(self) -> Float64:
        """Length of each unit [s], (N,)."""
        return np.asarray(self.length / self.rate)

    def label(self, unit: int) -> str:
        """What a unit is called: its recording and its number there, from 1."""
        of = self.examples[int(self.example[unit])]
        return f"{of.name}/{int(np.searchsorted(of.cuts, self.start[unit] + 1e-6))}"

    def kept(self, which: npt.ArrayLike) -> "Units":
        """Only the units `which` (indices or truth values), in that order."""
        index = np.asarray(which)
        return replace(self, example=self.example[index], start=self.start[index], length=self.length[index])


def cut_units(examples: Sequence[Example]) -> Units:
    """All units between the cuts of all examples."""
    example = [np.full(max(len(one.cuts) - 1, 0), n) for n, one in enumerate(examples)]
    return Units(
        tuple(examples),
        np.concatenate(example).astype(np.int64),
        np.concatenate([one.cuts[:-1] for one in examples]),
        np.concatenate([np.diff(one.cuts) for one in examples]),
    )


def beat_cuts(beats: Float64, last: float, every: int = BEATS_OF_UNIT) -> Float64:
    """Every second beat (or each `every`th), as far as they lie within samples 0 to `last`."""
    return np.asarray(beats[::every][(beats[::every] >= 0.0) & (beats[::every] <= last)])


def beat_samples(period: float, first: float, rate: float, last: float) -> Float64:
    """Samples of all beats `period` [s] apart, one of them at `first` [s], within samples 0 to `last`."""
    earliest = -np.floor(first / period + 1e-9)
    count = int(np.floor((last / rate - first) / period + 1e-9) - earliest) + 1
    return np.asarray((first + (earliest + np.arange(max(count, 0))) * period) * rate)
