"""What one press or tap of a musician does to the states: what it excludes is given up at once."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.bar_pointer.model import FIRST_SLOT, METRES, SLOTS, slot_metre
from live.clock.bar_pointer.states import States

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
