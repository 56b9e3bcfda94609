"""Parameters and state space of the bar pointer (Krebs, Böck and Widmer, ISMIR 2015).

A state is (interval, position, metre, beat): `interval` frames from beat to beat, `position` frames since the beat's
window began, and a slot for beat and metre. The position advances by one each frame; the interval may change only at
a beat. The states of each interval form a ring.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Int32
from live.clock.bar_pointer.metre import DEFAULT, METRES, SLOTS, USED, Metre, accents, metre_shares, slot_shares

REACH: Final = 8
"""Number of intervals to each side that the tempo can change to at one beat."""

SLOWEST_BPM: Final = 38.0
FASTEST_BPM: Final = 260.0
COARSE: Final = 90
"""From this interval on [frames] only every second one is used: 57 bpm and slower."""

MAX_PRIOR_OCTAVES: Final = 0.9
"""The prior of the tempo is constant beyond this distance from its mean [octaves]."""

LIKELY_OCTAVES: Final = 0.3
"""Spread of the tempi about one that the operator calls likely [octaves]."""

MIN_TRANSITION: Final = 1e-5
"""Changes of tempo with a lower probability are left out."""


@dataclass(frozen=True, slots=True)
class BarPointerModel:
    """Prior parameters of the bar pointer. Rates are per frame, shares between 0 and 1."""

    frame_rate: float = 44100.0 / 512.0
    """Frames of activations per second."""
    slowest_bpm: float = SLOWEST_BPM
    fastest_bpm: float = FASTEST_BPM
    tempo_bpm: float = 115.0
    """Centre of the tempi that people tap (log-normal)."""
    tempo_octaves: float = 0.5
    tempo_pull: float = 1.5
    """Weight of that prior per second."""
    tempo_change: float = 60.0
    """The larger, the more constant the tempo: a change from i to j frames weighs exp(-x |j / i - 1|)."""
    octave_change: float = 1e-4
    """Probability at each beat that the beat interval doubles or halves."""
    birth: float = 2e-5
    """Probability in each frame that a new grid begins."""
    metre_change: float = 1e-3
    """Probability at each measure line that another metre begins."""
    line_change: float = 2e-4
    """Probability at each beat that it is any other beat of its metre."""
    metres: tuple[Metre, ...] = DEFAULT
    """The metres that a measure may have, unless another is set by hand."""
    beat_share: float = 0.12
    """Share of frames with a beat, for the activations."""
    downbeat_share: float = 0.25
    """Share of the beats that are downbeats, for the activations."""
    accent_share: float = 0.5
    """Share of the measures in which the first beat of a group sounds like a downbeat."""
    sharpness: float = 0.6
    """Exponent of the likelihoods, because neighbouring frames are correlated."""
    downbeat_sharpness: float = 0.6
    """Exponent of the likelihoods of downbeats."""
    ratio_max: float = 60.0
    ratio_min: float = 0.02
    """Bounds of one frame's likelihood ratio for a beat."""
    half_beat: float = 0.1
    """Exponent of the beats' likelihood in the middle between beats: above 0, off-beats are expected to sound."""
    window: tuple[float, float, float, float, float, float, float] = (0.0, 0.2, 0.8, 1.0, 0.8, 0.2, 0.0)
    """Expected share of the activation in each frame of a beat's window."""

    centre: float = 3.0
    """Position of the beat in its window [frames]."""
    near_tempo: float = 0.08
    near_phase: float = 0.12
    """States within this ratio of an interval and this many beats of a phase belong to one grid."""
    switch_ratio: float = 3.0
    """The grid is replaced by another one with this many times its share of the states ..."""
    level_ratio: float = 10.0
    """... or this many times, if it is half or double the tempo ..."""
    switch_surveys: int = 2
    """... in more than this many searches."""
    line_ratio: float = 2.0
    """Another beat of the measure, or another metre, replaces the present one if its share is larger by this factor."""

    @classmethod
    def expecting(cls, metres: Iterable[str | int] = (), likely_bpm: float | None = None) -> "BarPointerModel":
        """Return the model of music in one of `metres` (empty: the usual ones), whose beat has about this tempo.

        Raises ValueError for an unknown metre or a tempo out of range.
        """
        known = tuple(Metre.parse(metre) for metre in metres) or DEFAULT
        if likely_bpm is None:
            return cls(metres=known)
        if not SLOWEST_BPM <= likely_bpm <= FASTEST_BPM:
            raise ValueError(f"a tempo of {likely_bpm} bpm: {SLOWEST_BPM:g} to {FASTEST_BPM:g} expected")
        return cls(metres=known, tempo_bpm=likely_bpm, tempo_octaves=LIKELY_OCTAVES)

    @property
    def intervals(self) -> Int32:
        """Frames from beat to beat of each tempo, ascending, shape (K,): all integers, from `COARSE` on even ones."""
        shortest = round(60.0 * self.frame_rate / self.fastest_bpm)
        longest = round(60.0 * self.frame_rate / self.slowest_bpm)
        fine, coarse = np.arange(shortest, min(COARSE, longest + 1)), np.arange(COARSE, longest + 1, 2)
        return np.concatenate([fine, coarse]).astype(np.int32)

    def tempo_share(self) -> Float32:
        """Return the prior of each interval, shape (K,), sum 1."""
        octaves = np.log2(60.0 * self.frame_rate / self.intervals / self.tempo_bpm)
        spacing = np.gradient(self.intervals.astype(np.float64))
        share = np.exp(-0.5 * (octaves / self.tempo_octaves) ** 2) * spacing / self.intervals
        total: Float32 = (share / share.sum()).astype(np.float32)
        return total

    def tempo_weight(self) -> Float32:
        """Return the factor of one more beat of each interval, by the tempi that people tap, shape (K,), at most 1.

        Equal times have equal weight: two beats of half the length count as much as one.
        """
        octaves = np.log2(60.0 * self.frame_rate / self.intervals / self.tempo_bpm)
        octaves = np.minimum(np.abs(octaves), MAX_PRIOR_OCTAVES)
        seconds = self.intervals / self.frame_rate
        weight: Float32 = np.exp(-0.5 * self.tempo_pull * seconds * (octaves / self.tempo_octaves) ** 2)
        return weight.astype(np.float32)

    def tempo_transitions(self) -> Float32:
        """Return transitions from interval k to k - REACH … k + REACH, shape (K, 2 REACH + 1); rows sum to 1."""
        lengths = self.intervals.astype(np.float64)
        index = np.arange(lengths.size)[:, None] + np.arange(-REACH, REACH + 1)
        other = lengths[np.clip(index, 0, lengths.size - 1)]
        spacing = np.gradient(lengths)[np.clip(index, 0, lengths.size - 1)]
        weight = spacing * np.exp(-self.tempo_change * np.abs(other / lengths[:, None] - 1.0))
        weight[(index < 0) | (index >= lengths.size)] = 0.0
        weight /= weight.sum(axis=1, keepdims=True)
        weight[weight < MIN_TRANSITION] = 0.0
        return np.ascontiguousarray(weight / weight.sum(axis=1, keepdims=True), np.float32)

    def metre_transitions(self) -> Float32:
        """Return transitions from the metre of a measure to the next one's, shape (M, M); rows sum to 1."""
        stay = np.eye(len(METRES)) * (1.0 - self.metre_change)
        return (stay + self.metre_change * metre_shares(self.metres)[None, :]).astype(np.float32)

    def slot_share(self) -> Float32:
        """Return the prior of each slot, shape (SLOTS,), sum 1."""
        return slot_shares(self.metres)

    def accents(self) -> Float32:
        """Return how often each slot sounds like a downbeat, shape (SLOTS,), 0 to 1."""
        return accents(self.metres, self.accent_share)


BINS: Final = 24
"""Phase bins of a beat, as in bar_pointer_kernels.py."""

TEMPO_WIDTH: Final = 0.01
PLACE_WIDTH: Final = 2.0
"""Spread of states about a grid that was kept (standard deviations: natural logarithm, frames)."""


class StateSpace:
    """Arrays of the kernels.

    `share` (N, SLOTS) float32: interval k has length[k] rows from offset[k] on, a ring whose position 0 is at head[k].
    """

    def __init__(self, model: BarPointerModel) -> None:
        self.model = model
        self.length = model.intervals
        """Frames from beat to beat, shape (K,)."""
        self.count = int(self.length.size)
        self.offset = (np.cumsum(self.length) - self.length).astype(np.int32)
        self.head = np.zeros(self.count, np.int32)
        self.share = np.zeros((int(self.length.sum()), SLOTS), np.float32)
        self.flat = self.share.reshape(-1)
        """The same data as a vector."""
        self.leaving = np.zeros((self.count, SLOTS), np.float32)
        self.entering = np.zeros((self.count, SLOTS), np.float32)
        self.histogram = np.zeros((self.count, BINS), np.float32)
        """Share of each interval and phase bin, shape (K, 24)."""
        self.boxes = np.zeros((self.count + 1, BINS))
        self.slot_share = model.slot_share()
        self.constant_tempo = np.zeros((self.count, 2 * REACH + 1), np.float32)
        """Transitions of a constant tempo."""
        self.constant_tempo[:, REACH] = 1.0
        self.same_metre = np.eye(len(METRES), dtype=np.float32)
        self.near = self._near(model.near_tempo)
        self.partner = self._partners()
        self.row_interval = np.repeat(self.length, self.length)
        """The interval of each row, shape (N,)."""

    def reset(self) -> None:
        """Set the prior: tempi by their distribution, all phases and beats alike."""
        self.head[:] = 0
        tempo = self.model.tempo_share() / self.length
        self.share[:] = np.repeat(tempo, self.length)[:, None] * self.slot_share[None, :]

    def set_grid(self, interval: float, phase: float, slots: Float32, doubt: float) -> None:
        """Set all states near one grid, except for a share `doubt`, which gets the prior.

        interval [frames], place [beats since the beat's window began], slots (SLOTS,): shares of each slot.
        """
        off_tempo = np.log(self.row_interval / interval) / TEMPO_WIDTH
        off = self.positions() / self.row_interval - phase
        off = (off - np.round(off)) * interval / PLACE_WIDTH
        near = np.exp(-0.5 * (off_tempo**2 + off**2))
        tempo = self.model.tempo_share() / self.length
        total = float(near.sum())
        self.share[:] = ((1.0 - doubt) / max(total, 1e-30) * near)[:, None] * slots[None, :]
        self.share += np.float32(doubt) * np.repeat(tempo, self.length)[:, None] * self.slot_share[None, :]

    def positions(self) -> Float32:
        """Return the present position of each row [frames], shape (N,)."""
        at = np.arange(self.share.shape[0]) - np.repeat(self.offset + self.head, self.length)
        return np.mod(at, self.row_interval).astype(np.float32)

    def normalize(self) -> None:
        """Normalise the shares to the sum 1 and clear unused slots; set the prior if all are 0."""
        self.share[:, USED:] = 0.0
        total = float(self.share.sum(dtype=np.float64))
        if total > 0.0:
            self.share *= np.float32(1.0 / total)
        else:
            self.reset()

    def _near(self, width: float) -> "np.typing.NDArray[np.int32]":
        lengths = self.length.astype(np.float64)
        low = np.searchsorted(lengths, lengths * (1.0 - width))
        high = np.searchsorted(lengths, lengths * (1.0 + width), side="right")
        return np.ascontiguousarray(np.stack([low, high], axis=1), np.int32)

    def _partners(self) -> "np.typing.NDArray[np.int32]":
        """Return the interval of half and of double the tempo for each k, shape (2 K,), -1 if there is none."""
        partner = np.full((self.count, 2), -1, np.int32)
        for k, length in enumerate(self.length.tolist()):
            for way, wanted in enumerate((2.0 * length, 0.5 * length)):
                nearest = int(np.argmin(np.abs(self.length - wanted)))
                if abs(self.length[nearest] - wanted) <= 1.0:
                    partner[k, way] = nearest
        return partner.reshape(-1)
