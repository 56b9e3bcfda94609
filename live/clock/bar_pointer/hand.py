"""Hand: the transitions in force: those of the model, narrowed by what people have said about tempo, line and metre."""

import math
from typing import Final

import numpy as np

from live.clock.bar_pointer.model import FIRST_SLOT, METRES, Float32, Model
from live.clock.bar_pointer.presses import take_beat, take_level, take_metre, take_one, take_tempo
from live.clock.bar_pointer.states import States

BAND_OCTAVES: Final = 0.5
"""A tempo set by hand keeps the level: its grid stays within so many octaves of it."""

HELD_OCTAVES: Final = 0.25
HELD_PULL: Final = 1.0
"""How near a tempo stays to the one that is held: deviation, and how much of it counts anew each second."""

DRIFT: Final = 0.04
"""When the music has moved this far [octaves], the tempo that is held moves with it."""

CALM: Final = 0.02
"""Once the line is set by hand, chances of another line and metre are multiplied by this, ..."""

CALM_SHARPNESS: Final = 0.4
"""... and so is the exponent of what is heard of downbeats."""

FREE_RANGE: Final = (0.01, 0.99)
CALM_RANGE: Final = (0.25, 0.5)
"""Chances of a downbeat among beats are taken for no less and no more; once the line is set by hand these bounds are
narrow, so that music which contradicts loudly is not believed much sooner than music that does so softly."""


class Hand:
    """Takes what is said by hand, into the states and for all time to come.

    `tempo`, `metre`, `born`, `leap`, `line_change`, `downbeat_sharpness`, `downbeat_range` are what each frame is
    weighed with.
    """

    def __init__(self, states: States) -> None:
        self._states = states
        self._model: Model = states.model
        self.let_go()

    def let_go(self) -> None:
        """Nothing is set by hand any more."""
        self._middle = 0.0  # interval about which the level is held; 0: it is free
        self._metre = 0
        self._line_is_set = False
        self.keeps_phase = False
        """Whether a beat was pressed: another phase is believed only when the music has left the present one."""
        self._renew()

    @property
    def keeps_level(self) -> bool:
        """Whether a tempo was tapped, halved or doubled."""
        return self._middle > 0.0

    @property
    def held_interval(self) -> float:
        """The interval [frames] about which the level is held; 0 where nobody has said one."""
        return self._middle

    @property
    def held_metre(self) -> int:
        """Beats of a measure as somebody has set them; 0: as heard."""
        return self._metre

    def tap(self, interval: float) -> None:
        """The tempo is this [frames]: states far from it are given up, and the level is held from now on."""
        take_tempo(self._states, interval)
        self._hold(interval)

    def beat(self, age: float) -> None:
        """A beat lay `age` frames before this one: this phase is kept from now on."""
        take_beat(self._states, age)
        self.keeps_phase = True

    def one(self, age: float) -> None:
        """A measure began `age` frames before this one (negative: it will): this line is kept from now on."""
        take_one(self._states, age)
        self._line_is_set = self.keeps_phase = True
        self._renew()

    def scale(self, factor: float, interval: float, since: float, slot: int) -> bool:
        """The grid gets `factor` times the tempo, see `take_level`; False where no such tempo is looked for."""
        wanted = take_level(self._states, factor, interval, since, slot)
        if wanted > 0.0:
            self._hold(wanted)
        return wanted > 0.0

    def set_metre(self, beats: int) -> None:
        """The measure has so many beats (0: as heard). Raises ValueError for a metre that is not looked for."""
        if beats not in (0, *METRES):
            raise ValueError(f"a measure of {beats} beats: one of {METRES} expected, or 0")
        self._metre = beats
        if beats:
            take_metre(self._states, beats)
        self._renew()

    def births(self, left: bool) -> Float32:
        """New grids that begin in each frame; once a beat was pressed only where the music has `left` the grid."""
        return self.born if left or not self.keeps_phase else self._none_born

    def drift(self, interval: float) -> None:
        """The music is at this interval [frames] now: what is held goes along with a slow change."""
        if self._middle > 0.0 and abs(math.log2(interval / self._middle)) > DRIFT:
            self._hold(math.sqrt(self._middle * interval))

    def _hold(self, interval: float) -> None:
        self._middle = interval
        self._renew()

    def _renew(self) -> None:
        model, states = self._model, self._states
        weight, share, allowed = self._preference()
        reach = states.still.shape[1] // 2
        tempo = model.tempo_transitions().astype(np.float64)
        for step in range(-reach, reach + 1):
            there = np.clip(np.arange(states.count) + step, 0, states.count - 1)
            tempo[:, step + reach] *= allowed[there]
        tempo *= (weight / np.maximum(tempo.sum(axis=1), 1e-12))[:, None]
        self.tempo = np.ascontiguousarray(tempo, np.float32)
        self.born = (model.birth * share).astype(np.float32)
        self._none_born = np.zeros_like(self.born)
        partner = states.partner.reshape(-1, 2)
        self.leap = (model.octave_change * np.where(partner >= 0, allowed[partner], 0.0)).astype(np.float32)
        calm = CALM if self._line_is_set else 1.0
        self.line_change = model.line_change * calm
        self.downbeat_sharpness = model.downbeat_sharpness * (CALM_SHARPNESS if self._line_is_set else 1.0)
        change = 0.0 if self._metre else calm
        self.downbeat_range = CALM_RANGE if self._line_is_set else FREE_RANGE
        self.metre = (change * model.metre_transitions() + (1.0 - change) * states.same_metre).astype(np.float32)
        states.slot_share = _slot_share(model, self._metre)

    def _preference(self) -> tuple[Float32, Float32, Float32]:
        """Per interval: what one more beat is worth, how likely a new grid has it (sum 1), whether it may be at all."""
        model, length = self._model, self._states.length
        if self._middle == 0.0:
            return model.tempo_weight(), model.tempo_share(), np.ones(length.size, np.float32)
        octaves = np.log2(length / self._middle)
        allowed = (np.abs(octaves) <= BAND_OCTAVES).astype(np.float32)
        likely = np.exp(-0.5 * (octaves / HELD_OCTAVES) ** 2)
        share = likely * allowed * np.gradient(length.astype(np.float64)) / length
        weight = likely ** (HELD_PULL * length / model.frame_rate)
        return weight.astype(np.float32), (share / share.sum()).astype(np.float32), allowed


def _slot_share(model: Model, metre: int) -> Float32:
    share = model.slot_share()
    if metre:
        first = FIRST_SLOT[METRES.index(metre)]
        share[:] = 0.0
        share[first : first + metre] = 1.0 / metre
    return share


def interval_of(bpm: float, model: Model) -> float:
    """Frames from beat to beat at a tempo; ValueError for one that is not looked for."""
    if not (math.isfinite(bpm) and model.slowest_bpm <= bpm <= model.fastest_bpm):
        raise ValueError(f"a tempo of {bpm} bpm: {model.slowest_bpm:g} to {model.fastest_bpm:g} expected")
    return 60.0 * model.frame_rate / bpm
