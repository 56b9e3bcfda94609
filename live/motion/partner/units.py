"""Units: synchronised stretches of a leader's and a follower's recording that mean something together (H001).

Complete-linkage clustering: of units that say nearly the same only one stays (H011).

Examples in beats: recordings retimed so that every unit is so many beats long, whatever tempo it was danced at.

On the stage the clock knows the beats: a leader is looked at so many times a beat, and a unit that lasts two of them is
as many frames long at any tempo.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from live.motion.clip import Clip, read_clip
from live.motion.partner.point_clouds import Cloud, stretched

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


SAMPLES = 8
"""Steps in which two units are compared, stretched to each other."""


def unit_distances(units: Units) -> Float64:
    """Distances (1) of all units from each other [m], rms over points and samples of controls and targets, (N, N).

    One motion M, that of the controls, lies on both: units whose leaders do the same and whose followers do not are
    far from each other. Units whose lengths differ are compared at one length.
    """
    pairs = [
        (
            stretched(of.control, float(start), float(length), SAMPLES),
            stretched(of.target, float(start), float(length), SAMPLES),
        )
        for of, start, length in (
            (units.examples[int(units.example[n])], units.start[n], units.length[n]) for n in range(units.count)
        )
    ]
    control = np.array([a.floor.ravel() for a, _ in pairs])
    middle = control.mean(axis=1)
    control = control - middle[:, None]
    product = control @ control.conj().T  # x conj(a): a is laid on x
    norm = np.abs(product)
    turn = np.where(norm > 1e-12, product / np.maximum(norm, 1e-12), 1.0)
    height = np.array([a.height.ravel() for a, _ in pairs])
    target = np.array([b.floor.ravel() for _, b in pairs]) - middle[:, None]
    target_height = np.array([b.height.ravel() for _, b in pairs])
    size = (np.abs(control) ** 2).sum(axis=1)
    size_b = (np.abs(target) ** 2).sum(axis=1)
    square = size[:, None] + size[None] - 2.0 * norm + _squares(height)
    across = (target @ target.conj().T) * turn.conj()
    square += size_b[:, None] + size_b[None] - 2.0 * across.real + _squares(target_height)
    count = control.shape[1] + target.shape[1]
    root = np.sqrt(np.maximum(square, 0.0) / count)
    np.fill_diagonal(root, 0.0)
    return np.asarray(0.5 * (root + root.T))


def _squares(rows: Float64) -> Float64:
    size = (rows**2).sum(axis=1)
    return np.asarray(size[:, None] + size[None] - 2.0 * rows @ rows.T)


def thin_out(units: Units, threshold: float, *, seed: int) -> Units:
    """One unit, drawn by `seed`, of each cluster in which no two are farther apart than `threshold` [m]."""
    if units.count < 2 or threshold <= 0.0:
        return units
    tree = linkage(squareform(unit_distances(units), checks=False), method="complete")
    cluster = fcluster(tree, threshold, criterion="distance")
    chance = np.random.default_rng(seed)
    kept = [int(chance.choice(np.flatnonzero(cluster == one))) for one in np.unique(cluster)]
    return units.kept(np.sort(kept))


def in_beats(units: Units, *, unit_beats: int, samples: int, period: float) -> Units:
    """The same units, each `unit_beats` long, with `samples` a beat, as if a beat lasted `period` [s].

    Before the first and after the last unit of a recording it goes on at its neighbour's tempo, as far as it goes.
    """
    return cut_units([_retimed(one, unit_beats * samples, samples / period) for one in units.examples])


def _retimed(example: Example, size: int, rate: float) -> Example:
    """One example whose units are `size` samples long at `rate` [Hz]."""
    cuts, last = example.cuts, example.follower.sample_count - 1.0
    first, final = size / (cuts[1] - cuts[0]), size / (cuts[-1] - cuts[-2])
    before = int(np.floor(cuts[0] * first + 1e-9))
    after = int(np.floor((last - cuts[-1]) * final + 1e-9))
    units = len(cuts) - 1
    at = np.concatenate(([-before / first + cuts[0]], cuts, [cuts[-1] + after / final]))
    new = np.concatenate(([0.0], before + size * np.arange(units + 1.0), [before + size * units + after]))
    places = np.asarray(np.interp(np.arange(int(new[-1]) + 1), new, at), np.float64)
    control, target = example.control.at(places), example.target.at(places)
    return Example(
        example.name, replace(control, rate=rate), replace(target, rate=rate), _read(example.follower, places, rate),
        np.asarray(new[1:-1]), np.asarray(np.interp(example.beats, at, new)),
        tuple(_moved(hold, at, new) for hold in example.holds),
    )  # fmt: skip


def _read(clip: Clip, places: Float64, rate: float) -> Clip:
    root, rotation, contact = read_clip(clip, places)
    return Clip(
        clip.name, np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32), rate,
        np.ascontiguousarray(contact),
    )  # fmt: skip


def _moved(hold: Hold, at: Float64, new: Float64) -> Hold:
    return replace(hold, begin=float(np.interp(hold.begin, at, new)), end=float(np.interp(hold.end, at, new)))
