"""Units: synchronized segments of a leader's and a follower's recording (H001).

Near-duplicate units are removed by complete-linkage clustering (H011). For real-time use, recordings are retimed to a
fixed number of samples a beat, so that a unit has the same number of frames at any tempo.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64, Int64
from live.motion.clip import Clip, read_clip
from live.motion.partner.point_clouds import Cloud, time_scaled

BEATS_OF_UNIT: Final = 2
"""A unit of dance is two beats long (H001)."""


@dataclass(frozen=True, slots=True)
class Hold:
    """A hold between two hands, over a span of samples; hands are 0 left, 1 right."""

    leader_hand: int
    follower_hand: int
    begin: float
    """Sample at which it begins."""
    end: float


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """One pair of synchronized recordings in one world frame."""

    name: str
    control: Cloud
    """Cloud of the leader."""
    target: Cloud
    """Cloud of the follower, at the same times."""
    follower: Clip
    """The follower's motion, from which answers are copied."""
    cuts: Float64
    """Samples at which one unit ends and the next begins, ascending, (n + 1,)."""
    beats: Float64
    """Samples of all beats, (n,); empty if unknown."""
    holds: tuple[Hold, ...] = ()
    leader: Cloud | None = None
    """Cloud of LEADER_JOINTS that leads a live follower; None where `control` does, because it begins with the hips."""

    @property
    def live_control(self) -> Cloud:
        """The cloud that leads a live follower: its first two points are the leader's left and right hip joint."""
        return self.control if self.leader is None else self.leader


@dataclass(frozen=True, slots=True, eq=False)
class Units:
    """N units of some examples at one rate: the database of the mapping."""

    examples: tuple[Example, ...]
    example: Int64
    """Index of the example of each unit, (N,)."""
    start: Float64
    """Sample of its recording at which each unit begins, (N,)."""
    length: Float64
    """Length of each in samples, (N,)."""

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
        """Return the label of a unit: its recording and its number there, from 1."""
        of = self.examples[int(self.example[unit])]
        return f"{of.name}/{int(np.searchsorted(of.cuts, self.start[unit] + 1e-6))}"

    def select(self, which: npt.ArrayLike) -> "Units":
        """Return only the units `which` (indices or booleans), in that order."""
        index = np.asarray(which)
        return replace(self, example=self.example[index], start=self.start[index], length=self.length[index])


def cut_units(examples: Sequence[Example]) -> Units:
    """Return all units between the cuts of all examples."""
    example = [np.full(max(len(one.cuts) - 1, 0), n) for n, one in enumerate(examples)]
    return Units(
        tuple(examples),
        np.concatenate(example).astype(np.int64),
        np.concatenate([one.cuts[:-1] for one in examples]),
        np.concatenate([np.diff(one.cuts) for one in examples]),
    )


def beat_cuts(beats: Float64, last: float, every: int = BEATS_OF_UNIT) -> Float64:
    """Return every second beat (or each `every`th) within samples 0 to `last`."""
    return np.asarray(beats[::every][(beats[::every] >= 0.0) & (beats[::every] <= last)])


def beat_samples(period: float, first: float, rate: float, last: float) -> Float64:
    """Return the samples of all beats `period` [s] apart, one at `first` [s], within samples 0 to `last`."""
    earliest = -np.floor(first / period + 1e-9)
    count = int(np.floor((last / rate - first) / period + 1e-9) - earliest) + 1
    return np.asarray((first + (earliest + np.arange(max(count, 0))) * period) * rate)


COMPARISON_STEPS = 8
"""Number of steps to which units are time-scaled for comparison."""


def unit_distances(units: Units) -> Float64:
    """Return the pairwise distances (1) of units [m], rms over points and samples of controls and targets, (N, N).

    The motion M of the controls is applied to both controls and targets, so units with the same leader and different
    followers are far apart. Units of different lengths are scaled to one length.
    """
    pairs = [
        (
            time_scaled(of.control, float(start), float(length), COMPARISON_STEPS),
            time_scaled(of.target, float(start), float(length), COMPARISON_STEPS),
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


def remove_duplicates(units: Units, threshold: float, *, seed: int) -> Units:
    """Return one unit, drawn with `seed`, from each cluster with pairwise distances up to `threshold` [m]."""
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import squareform

    if units.count < 2 or threshold <= 0.0:
        return units
    tree = linkage(squareform(unit_distances(units), checks=False), method="complete")
    cluster = fcluster(tree, threshold, criterion="distance")
    chance = np.random.default_rng(seed)
    kept = [int(chance.choice(np.flatnonzero(cluster == one))) for one in np.unique(cluster)]
    return units.select(np.sort(kept))


def retime_to_beats(units: Units, *, unit_beats: int, samples: int, period: float) -> Units:
    """Return the units retimed to `unit_beats` each, with `samples` a beat, as if a beat lasted `period` [s].

    Before the first and after the last unit a recording continues, to its end, at the tempo of that unit.
    """
    return cut_units([_retime_example(one, unit_beats * samples, samples / period) for one in units.examples])


def _retime_example(example: Example, size: int, rate: float) -> Example:
    """Return the example with units of `size` samples at `rate` [Hz]."""
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
        example.name, replace(control, rate=rate), replace(target, rate=rate),
        _resample_clip(example.follower, places, rate),
        np.asarray(new[1:-1]), np.asarray(np.interp(example.beats, at, new)),
        tuple(_retime_hold(hold, at, new) for hold in example.holds),
        None if example.leader is None else replace(example.leader.at(places), rate=rate),
    )  # fmt: skip


def _resample_clip(clip: Clip, places: Float64, rate: float) -> Clip:
    root, rotation, contact = read_clip(clip, places)
    return Clip(
        clip.name, np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32), rate,
        np.ascontiguousarray(contact),
    )  # fmt: skip


def _retime_hold(hold: Hold, at: Float64, new: Float64) -> Hold:
    return replace(hold, begin=float(np.interp(hold.begin, at, new)), end=float(np.interp(hold.end, at, new)))
