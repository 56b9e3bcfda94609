"""Hand: what people say about tempo, level, measure line and metre, written into states and transitions."""

import math
from typing import Final

import numpy as np

from live.clock.bar_pointer.model import FIRST_SLOT, METRES, SLOTS, Float32, Model, slot_metre
from live.clock.bar_pointer.states import States, beats_since_line

TAP_WIDTH: Final = 0.03
"""How exactly a tempo is tapped (standard deviation, natural logarithm)."""

PRESS_WIDTH: Final = 0.045
"""How exactly "this is the one" is pressed [s]."""

DOUBT: Final = 1e-9
"""The ear must find something else this much more likely before it overrules the hand."""

BAND_OCTAVES: Final = 0.5
"""A tempo set by hand keeps the level: its grid stays within so many octaves of it."""

CALM: Final = 0.02
"""Once the line is set by hand, chances of another line and metre are multiplied by this, ..."""

CALM_SHARPNESS: Final = 0.3
"""... and so is the exponent of what is heard of downbeats."""


class Hand:
    """Holds the transitions in force: those of the model, narrowed by what was set by hand."""

    def __init__(self, states: States) -> None:
        self._states = states
        self._model: Model = states.model
        self._middle = 0.0
        self._metre = 0
        self._line_is_set = False
        self._odds = np.full((states.count, 2), self._model.octave_change, np.float32)
        self.tempo: Float32
        self._renew()

    def let_go(self) -> None:
        """Nothing is set by hand any more."""
        self._middle, self._metre, self._line_is_set = 0.0, 0, False
        self._renew()

    @property
    def middle(self) -> float:
        """The interval [frames] about which the level is held; 0 where it is free."""
        return self._middle

    def tap(self, interval: float) -> None:
        """The tempo is this [frames]: states far from it are given up, and the level is held from now on."""
        states = self._states
        off = np.log(states.interval_of / interval) / TAP_WIDTH
        states.share *= np.maximum(np.exp(-0.5 * off**2), DOUBT)[:, None].astype(np.float32)
        states.settle()
        self.hold(interval)

    def hold(self, interval: float) -> None:
        """The level is held about this interval [frames]."""
        self._middle = interval
        self._renew()

    def one(self, age: float) -> None:
        """A measure began `age` frames before this one (negative: after it)."""
        states, rate = self._states, self._model.frame_rate
        width = PRESS_WIDTH * rate
        since = states.positions() - states.model.centre - age
        for slot, beats in enumerate(beats_since_line()[: SLOTS - 1]):
            length = states.interval_of * slot_metre(slot)[0]
            off = since + beats * states.interval_of
            off -= np.round(off / length) * length
            states.share[:, slot] *= np.maximum(np.exp(-0.5 * (off / width) ** 2), DOUBT).astype(np.float32)
        states.settle()
        self._line_is_set = True
        self._renew()

    def beat(self, age: float) -> None:
        """A beat lay `age` frames before this one."""
        states = self._states
        off = states.positions() - states.model.centre - age
        off -= np.round(off / states.interval_of) * states.interval_of
        states.share *= np.maximum(np.exp(-0.5 * (off / (PRESS_WIDTH * self._model.frame_rate)) ** 2), DOUBT)[:, None]
        states.settle()

    def scale(self, factor: float, interval: float, since: float, slot: int) -> bool:
        """The grid `interval` [frames], whose beat `slot` began `since` frames ago, gets `factor` times the tempo.

        Where every second beat falls away it is the even ones of the measure (its second, fourth ...). Returns False,
        and changes nothing, where no such tempo is looked for.
        """
        states = self._states
        wanted = interval / factor
        if not states.length[0] <= wanted <= states.length[-1]:
            return False
        falls_away = wanted > interval and slot_metre(slot)[1] % 2 == 1
        place = (since + interval if falls_away else since) % wanted
        off_tempo = np.log(states.interval_of / wanted) / TAP_WIDTH
        off = states.positions() / states.interval_of - place / wanted
        off = (off - np.round(off)) * wanted / (PRESS_WIDTH * self._model.frame_rate)
        near = np.exp(-0.5 * (off_tempo**2 + off**2)) + DOUBT
        states.share[:] = (near / near.sum())[:, None] * states.slot_share[None, :]
        self.hold(wanted)
        states.settle()
        return True

    def set_metre(self, beats: int) -> None:
        """The measure has so many beats (0: as heard). Raises ValueError for a metre that is not looked for."""
        if beats not in (0, *METRES):
            raise ValueError(f"a measure of {beats} beats: one of {METRES} expected, or 0")
        self._metre = beats
        states = self._states
        if beats:
            first = FIRST_SLOT[METRES.index(beats)]
            total = states.share.sum(axis=1)
            kept = np.zeros(SLOTS, bool)
            kept[first : first + beats] = True
            states.share[:, ~kept] = 0.0
            rest = total - states.share.sum(axis=1)
            states.share[:, first : first + beats] += (rest / beats)[:, None]
            states.settle()
        self._renew()

    def _renew(self) -> None:
        model, states = self._model, self._states
        allowed = np.ones(states.count)
        if self._middle > 0.0:
            allowed[np.abs(np.log2(states.length / self._middle)) > BAND_OCTAVES] = 0.0
        reach = states.still.shape[1] // 2
        tempo = model.tempo_transitions().astype(np.float64)
        tempo_weight = model.tempo_weight() if self._middle == 0.0 else np.ones(states.count)
        for step in range(-reach, reach + 1):
            there = np.clip(np.arange(states.count) + step, 0, states.count - 1)
            tempo[:, step + reach] *= allowed[there]
        total = tempo.sum(axis=1, keepdims=True)
        tempo *= tempo_weight[:, None] / np.maximum(total, 1e-12)
        self.tempo = np.ascontiguousarray(tempo, np.float32)
        calm = CALM if self._line_is_set else 1.0
        born = model.tempo_share() * allowed
        self.born = (model.birth * calm * born / max(born.sum(), 1e-12)).astype(np.float32)
        partner = states.partner.reshape(-1, 2)
        self.leap = self._odds * np.where(partner >= 0, allowed[partner], 0.0).astype(np.float32)
        self.line_change = model.line_change * calm
        self.downbeat_sharpness = model.downbeat_sharpness * (CALM_SHARPNESS if self._line_is_set else 1.0)
        self.metre = states.same_metre.copy()
        if not self._metre:
            self.metre = model.metre_transitions() if calm == 1.0 else _between(model.metre_transitions(), calm)
        states.slot_share = _slot_share(model, self._metre)


def _between(full: Float32, share: float) -> Float32:
    return (share * full + (1.0 - share) * np.eye(full.shape[0])).astype(np.float32)


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
