"""Transition model of the bar pointer, constrained by manual settings of tempo, beat, downbeat and metre.

A tap or setting removes the states that it excludes at once.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32
from live.clock.bar_pointer.metre import FIRST_SLOT, METRES, SLOTS, USED, Metre, slot_metre, slot_shares
from live.clock.bar_pointer.state_space import BarPointerModel, StateSpace

Floats = npt.NDArray[np.float64]

TAP_WIDTH: Final = 0.03
"""Accuracy of a tapped tempo (standard deviation, natural logarithm)."""

BEAT_TAP_WIDTH: Final = 0.045
"""Accuracy of a tapped beat [s]."""

MAX_DEVIATIONS: Final = 4.0
"""States further away than this many deviations are removed, ..."""

MAX_DEVIATION_BEATS: Final = 0.25
"""... and so are states further than this many beats from a tap."""

MIN_TAPPED_SHARE: Final = 0.02
"""If the tapped states had less than this share of all states, a default distribution is added to fill the share."""


def constrain_tempo(states: StateSpace, interval: float) -> None:
    """Keep only states near a tempo [frames]."""
    off = np.log(states.row_interval / interval) / TAP_WIDTH
    near = np.where(np.abs(off) < MAX_DEVIATIONS, np.exp(-0.5 * off**2), 0.0)
    fresh = near / states.row_interval
    _reweight(states, near[:, None] * np.ones(SLOTS), fresh[:, None] * states.slot_share)


def constrain_beat(states: StateSpace, age: float) -> None:
    """Keep only states with a beat, of any position in its measure, `age` frames before this one."""
    off = states.positions() - states.model.centre - age
    near = _tap_agreement(states, off, states.row_interval)
    _reweight(states, near[:, None] * np.ones(SLOTS), (_by_tempo(states) * near)[:, None] * states.slot_share)


def constrain_downbeat(states: StateSpace, age: float) -> None:
    """Keep only states with a measure start `age` frames before this one (negative: in the future)."""
    since = states.positions() - states.model.centre - age
    near = np.zeros((states.row_interval.size, SLOTS))
    for slot in range(USED):
        beats, beat = slot_metre(slot)
        near[:, slot] = _tap_agreement(states, since + beat * states.row_interval, beats * states.row_interval)
    _reweight(states, near, _by_tempo(states)[:, None] * near * states.slot_share)


def change_level(states: StateSpace, factor: float, interval: float, since: float, slot: int) -> float:
    """Change the grid `interval` [frames], whose beat `slot` began `since` frames ago, to `factor` times the tempo.

    If every second beat is dropped, these are the even ones of the measure (second, fourth ...). Returns the new
    interval, or 0 without a change if that tempo is outside the model's range.
    """
    wanted = interval / factor
    if not states.length[0] <= wanted <= states.length[-1]:
        return 0.0
    falls_away = wanted > interval and slot_metre(slot)[1] % 2 == 1
    place = (since + interval if falls_away else since) % wanted
    states.set_grid(wanted, place / wanted, states.slot_share, 0.0)
    return wanted


def constrain_metre(states: StateSpace, beats: int) -> None:
    """Keep only states of a metre."""
    first = FIRST_SLOT[METRES.index(beats)]
    near = np.zeros((states.row_interval.size, SLOTS))
    near[:, first : first + beats] = 1.0
    fresh = states.share.sum(axis=1, dtype=np.float64)[:, None] * near / beats
    _reweight(states, near, fresh)


def _tap_agreement(states: StateSpace, off: npt.NDArray[np.floating], round_: npt.NDArray[np.integer]) -> Floats:
    """Return the agreement of rows with a tap that they expect `off` frames away, modulo `round_`."""
    off = off - np.round(off / round_) * round_
    width = BEAT_TAP_WIDTH * states.model.frame_rate
    near = (np.abs(off) < MAX_DEVIATIONS * width) & (np.abs(off) < MAX_DEVIATION_BEATS * states.row_interval)
    agreement: Floats = np.where(near, np.exp(-0.5 * (off / width) ** 2), 0.0)
    return agreement


def _by_tempo(states: StateSpace) -> Floats:
    """Return the share of each row for the present tempi and uniform phases, shape (N,)."""
    tempo = np.add.reduceat(states.share.sum(axis=1, dtype=np.float64), states.offset)
    share: Floats = np.repeat(tempo / states.length, states.length)
    return share


def _reweight(states: StateSpace, near: Floats, fresh: Floats) -> None:
    """Multiply the states by `near`, (N, SLOTS); add `fresh` (N, SLOTS) if few of them were near."""
    total = float(states.share.sum(dtype=np.float64))
    if total <= 0.0:
        states.reset()
        total = 1.0
    kept = states.share * near / total
    missing = MIN_TAPPED_SHARE * max(1.0 - float(kept.sum()), 0.0) / max(float(fresh.sum()), 1e-30)
    states.share[:] = kept + missing * fresh
    states.normalize()


BAND_OCTAVES: Final = 0.5
"""A manual tempo keeps the metrical level: the grid stays within this many octaves of it."""

HELD_OCTAVES: Final = 0.25
HELD_PULL: Final = 1.0
"""Prior around the manual tempo: deviation, and weight per second."""

DRIFT: Final = 0.04
"""If the music's tempo moves this far [octaves], the manual tempo follows."""

MANUAL_LINE_SHARPNESS: Final = 0.4
"""After a manual downbeat no other line, metre and level begins: the music only decides between those that were
possible when it was pressed, the exponent of downbeat likelihoods multiplied by this."""

FREE_RANGE: Final = (0.01, 0.99)
MANUAL_LINE_RANGE: Final = (0.25, 0.5)
"""Limits of the probability of a downbeat among beats. After a manual downbeat they are narrow, so that music which
contradicts loudly does not win much sooner than music that does so softly.
"""


class ManualConstraints:
    """Applies manual settings to the states and to all later transitions.

    Each frame uses the transition probabilities that it holds as attributes.
    """

    def __init__(self, states: StateSpace) -> None:
        self._states = states
        self._model: BarPointerModel = states.model
        self.clear()

    def clear(self) -> None:
        """Remove all manual settings."""
        self._middle = 0.0  # interval about which the level is kept; 0: free
        self._metre = 0
        self._line_metre = 0
        self._line_is_set = False
        self.keeps_phase = False
        """Whether a beat was tapped: another phase is accepted only if the music has left the present one."""
        self._update_transitions()

    @property
    def keeps_level(self) -> bool:
        """Whether a tempo was tapped, halved or doubled."""
        return self._middle > 0.0

    @property
    def keeps_line(self) -> bool:
        """Whether a downbeat was set."""
        return self._line_is_set

    @property
    def held_interval(self) -> float:
        """The interval [frames] about which the level is kept; 0 if none was set."""
        return self._middle

    @property
    def held_metre(self) -> int:
        """Manual number of beats in a measure; 0: as detected."""
        return self._metre

    def set_tempo(self, interval: float) -> None:
        """Set the tempo [frames]: remove states far from it, and keep the level from now on."""
        constrain_tempo(self._states, interval)
        self._hold(interval)

    def set_beat(self, age: float) -> None:
        """Set a beat `age` frames before this one, and keep this phase from now on."""
        constrain_beat(self._states, age)
        self.keeps_phase = True

    def set_downbeat(self, age: float, metre: int = 0) -> None:
        """Start a measure `age` frames before this one (negative: in the future), and keep this line from now on.

        `metre`: the beats of its measures, kept as long as the line is; 0: as detected.
        """
        if metre and not self._metre:
            constrain_metre(self._states, metre)
            self._line_metre = metre
            self._update_transitions()  # the downbeat is one of this metre's
        constrain_downbeat(self._states, age)
        self._line_is_set = self.keeps_phase = True
        self._update_transitions()

    def release_line(self) -> None:
        """Let the music find line and metre: the beats by which a manual line counts are gone."""
        if self._line_is_set:
            self._line_is_set, self._line_metre = False, 0
            self._update_transitions()

    def scale(self, factor: float, interval: float, since: float, slot: int) -> bool:
        """Multiply the tempo of the grid by `factor`, see `change_level`; False if it is outside the model's range."""
        wanted = change_level(self._states, factor, interval, since, slot)
        if wanted > 0.0:
            self._hold(wanted)
        return wanted > 0.0

    def set_metre(self, beats: int) -> None:
        """Set the number of beats in a measure (0: as detected). Raises ValueError for an unsupported metre."""
        if beats not in (0, *METRES):
            raise ValueError(f"a measure of {beats} beats: one of {METRES} expected, or 0")
        self._metre, self._line_metre = beats, 0
        if beats:
            constrain_metre(self._states, beats)
        self._update_transitions()

    def births(self, grid_is_lost: bool) -> Float32:
        """Return the new grids of each frame; none after a tapped beat, unless `grid_is_lost`."""
        return self.birth_shares if grid_is_lost or not self.keeps_phase else self._no_births

    def follow_drift(self, interval: float) -> None:
        """Adapt the manual tempo to a slow change of the music's interval [frames]."""
        if self._middle > 0.0 and abs(math.log2(interval / self._middle)) > DRIFT:
            self._hold(math.sqrt(self._middle * interval))

    def _hold(self, interval: float) -> None:
        self._middle = interval
        self._update_transitions()

    def _update_transitions(self) -> None:
        model, states = self._model, self._states
        weight, share, allowed = self._preference()
        reach = states.constant_tempo.shape[1] // 2
        tempo = model.tempo_transitions().astype(np.float64)
        for step in range(-reach, reach + 1):
            there = np.clip(np.arange(states.count) + step, 0, states.count - 1)
            tempo[:, step + reach] *= allowed[there]
        tempo *= (weight / np.maximum(tempo.sum(axis=1), 1e-12))[:, None]
        self.tempo = np.ascontiguousarray(tempo, np.float32)
        self.birth_shares = (model.birth * share).astype(np.float32)
        self._no_births = np.zeros_like(self.birth_shares)
        partner = states.partner.reshape(-1, 2)
        calm = 0.0 if self._line_is_set else 1.0  # at half the tempo and back the line would be lost
        octave = calm * model.octave_change
        self.octave_change_odds = (octave * np.where(partner >= 0, allowed[partner], 0.0)).astype(np.float32)
        self.line_change = model.line_change * calm
        self.downbeat_sharpness = model.downbeat_sharpness * (MANUAL_LINE_SHARPNESS if self._line_is_set else 1.0)
        metre = self._metre or self._line_metre
        change = 0.0 if metre else calm
        self.downbeat_range = MANUAL_LINE_RANGE if self._line_is_set else FREE_RANGE
        self.metre = (change * model.metre_transitions() + (1.0 - change) * states.same_metre).astype(np.float32)
        states.slot_share = _slot_share(model, metre)

    def _preference(self) -> tuple[Float32, Float32, Float32]:
        """Return per interval: factor of one more beat, probability for a new grid (sum 1), whether it is allowed."""
        model, length = self._model, self._states.length
        if self._middle == 0.0:
            return model.tempo_weight(), model.tempo_share(), np.ones(length.size, np.float32)
        octaves = np.log2(length / self._middle)
        allowed = (np.abs(octaves) <= BAND_OCTAVES).astype(np.float32)
        likely = np.exp(-0.5 * (octaves / HELD_OCTAVES) ** 2)
        share = likely * allowed * np.gradient(length.astype(np.float64)) / length
        weight = likely ** (HELD_PULL * length / model.frame_rate)
        return weight.astype(np.float32), (share / share.sum()).astype(np.float32), allowed


def _slot_share(model: BarPointerModel, metre: int) -> Float32:
    return slot_shares((Metre(metre),)) if metre else model.slot_share()


def tempo_to_interval(bpm: float, model: BarPointerModel) -> float:
    """Return the frames from beat to beat at a tempo; ValueError for a tempo outside the model's range."""
    if not (math.isfinite(bpm) and model.slowest_bpm <= bpm <= model.fastest_bpm):
        raise ValueError(f"a tempo of {bpm} bpm: {model.slowest_bpm:g} to {model.fastest_bpm:g} expected")
    return 60.0 * model.frame_rate / bpm
