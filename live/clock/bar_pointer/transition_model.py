"""Hand: the transitions in force: those of the model, narrowed by what people have said about tempo, line and metre.

What one press or tap of a musician does to the states: what it excludes is given up at once.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.bar_pointer.state_space import FIRST_SLOT, METRES, SLOTS, Float32, Model, States, slot_metre

Floats = npt.NDArray[np.float64]

TAP_WIDTH: Final = 0.03
"""How exactly a tempo is tapped (standard deviation, natural logarithm)."""

PRESS_WIDTH: Final = 0.045
"""How exactly a beat is pressed [s]."""

FAR: Final = 4.0
"""Beyond so many deviations nothing is believed any more, ..."""

FAR_BEATS: Final = 0.25
"""... nor beyond so many beats from a press."""

UNHEARD: Final = 0.02
"""Where what is pressed had less than this share of all states, the press counts as much as what they say of it."""


def take_tempo(states: States, interval: float) -> None:
    """The tempo is this [frames]."""
    off = np.log(states.interval_of / interval) / TAP_WIDTH
    near = np.where(np.abs(off) < FAR, np.exp(-0.5 * off**2), 0.0)
    fresh = near / states.interval_of
    _believe(states, near[:, None] * np.ones(SLOTS), fresh[:, None] * states.slot_share)


def take_beat(states: States, age: float) -> None:
    """A beat, whichever of its measure, lay `age` frames before this one."""
    off = states.positions() - states.model.centre - age
    near = _pressed(states, off, states.interval_of)
    _believe(states, near[:, None] * np.ones(SLOTS), (_by_tempo(states) * near)[:, None] * states.slot_share)


def take_one(states: States, age: float) -> None:
    """A measure began `age` frames before this one (negative: it will begin)."""
    since = states.positions() - states.model.centre - age
    near = np.zeros((states.interval_of.size, SLOTS))
    for slot in range(SLOTS - 1):
        beats, beat = slot_metre(slot)
        near[:, slot] = _pressed(states, since + beat * states.interval_of, beats * states.interval_of)
    _believe(states, near, _by_tempo(states)[:, None] * near * states.slot_share)


def take_level(states: States, factor: float, interval: float, since: float, slot: int) -> float:
    """The grid `interval` [frames], whose beat `slot` began `since` frames ago, gets `factor` times the tempo.

    Where every second beat falls away it is the even ones of the measure (its second, fourth ...). Returns the new
    interval, or 0, and changes nothing, where no such tempo is looked for.
    """
    wanted = interval / factor
    if not states.length[0] <= wanted <= states.length[-1]:
        return 0.0
    falls_away = wanted > interval and slot_metre(slot)[1] % 2 == 1
    place = (since + interval if falls_away else since) % wanted
    states.gather(wanted, place / wanted, states.slot_share, 0.0)
    return wanted


def take_metre(states: States, beats: int) -> None:
    """The measure has so many beats."""
    first = FIRST_SLOT[METRES.index(beats)]
    near = np.zeros((states.interval_of.size, SLOTS))
    near[:, first : first + beats] = 1.0
    fresh = states.share.sum(axis=1, dtype=np.float64)[:, None] * near / beats
    _believe(states, near, fresh)


def _pressed(states: States, off: npt.NDArray[np.floating], round_: npt.NDArray[np.integer]) -> Floats:
    """How well rows agree with a press that they expect `off` frames away, give or take whole `round_`s."""
    off = off - np.round(off / round_) * round_
    width = PRESS_WIDTH * states.model.frame_rate
    near = (np.abs(off) < FAR * width) & (np.abs(off) < FAR_BEATS * states.interval_of)
    agreement: Floats = np.where(near, np.exp(-0.5 * (off / width) ** 2), 0.0)
    return agreement


def _by_tempo(states: States) -> Floats:
    """The share of each row if tempi were as believed and all phases alike, shape (N,)."""
    tempo = np.add.reduceat(states.share.sum(axis=1, dtype=np.float64), states.offset)
    share: Floats = np.repeat(tempo / states.length, states.length)
    return share


def _believe(states: States, near: Floats, fresh: Floats) -> None:
    """Keep the states so far as they are near, (N, SLOTS); where few of them were, believe `fresh` (N, SLOTS)."""
    total = float(states.share.sum(dtype=np.float64))
    if total <= 0.0:
        states.fill()
        total = 1.0
    kept = states.share * near / total
    missing = UNHEARD * max(1.0 - float(kept.sum()), 0.0) / max(float(fresh.sum()), 1e-30)
    states.share[:] = kept + missing * fresh
    states.settle()


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
