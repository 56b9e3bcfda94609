"""What each dancer looks like: drawn from the names and tones of their group or part, by their number and the seed."""

from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Float64, Int32
from live.base.body.appearance import (
    APPEARANCE_SIZE,
    BODY,
    BY_CHANCE,
    COSTUME,
    HAIR,
    HAIR_COLOUR,
    SHOES_WORN,
    SKIN,
)
from live.base.picture_parameters import (
    GROUP_PARAMETERS,
    PART_COUNT,
    STYLE_ADDRESS_PREFIX,
    STYLE_SIZE,
    STYLES_START,
)
from live.show.group.division import Division

if TYPE_CHECKING:
    from live.show.desk.parameters import Parameters

_SEED: Final = 37
_NAMES: Final = {COSTUME: "costume", SHOES_WORN: "shoes", HAIR: "hair"}
_TONES: Final = {SKIN: ("skin", "skin/variety"), HAIR_COLOUR: ("hair/tone", "hair/variety")}
_PLACES: Final = {
    name: GROUP_PARAMETERS[STYLE_ADDRESS_PREFIX + name].first - STYLES_START
    for name in (*_NAMES.values(), *(name for names in _TONES.values() for name in names))
}
_READ: Final = np.array(list(_PLACES.values()))


class Appearances:
    """The appearance of every dancer of one show. Thread: the show's."""

    def __init__(self, seed: int, division: Division, parameters: "Parameters") -> None:
        self._seed, self._division, self._parameters = seed, division, parameters
        self._drawn: tuple[Float64, Int32, Int32] | None = None  # values and parts of the last rows, and these

    def rows(self) -> Int32:
        """Return the appearance of all dancers, shape (A, APPEARANCE_SIZE): the columns of
        `live.base.body.appearance`. The array changes with the parameters: copy what is kept."""
        said = self._parameters.picture[STYLES_START:].reshape(PART_COUNT, STYLE_SIZE)[:, _READ]
        part = self._division.part
        drawn = self._drawn
        if drawn is None or not (np.array_equal(said, drawn[0]) and np.array_equal(part, drawn[1])):
            self._drawn = drawn = said, part.copy(), draw_appearances(said, part, self._seed)
        return drawn[2]


def draw_appearances(said: Float64, part: Int32, seed: int) -> Int32:
    """Return the appearance of A dancers, shape (A, APPEARANCE_SIZE).

    said (PART_COUNT, len(_READ)): the values of each part in the order of `_READ`; part (A,). A dancer has one of the
    names of their part, by a number of their own.
    """
    column = {name: place for place, name in enumerate(_PLACES)}
    chance = np.random.default_rng([seed, _SEED]).random((len(part), APPEARANCE_SIZE))
    rows = np.full((len(part), APPEARANCE_SIZE), BY_CHANCE, np.int32)
    for place, name in _NAMES.items():
        rows[:, place] = pick_names(said[part, column[name]].astype(np.int64), chance[:, place])
    for place, (tone, variety) in _TONES.items():
        level = said[part, column[tone]] + said[part, column[variety]] * (chance[:, place] - 0.5)
        rows[:, place] = np.rint(255.0 * np.clip(level, 0.0, 1.0))
    rows[:, BODY] = BY_CHANCE
    return rows


def pick_names(names: np.ndarray[tuple[int, ...], np.dtype[np.int64]], chance: Float64) -> Int32:
    """Return for each dancer the place of one of the bits in `names` (A,), evenly by `chance` (A,) of 0 to 1."""
    bits = (names[:, None] >> np.arange(16)) & 1
    wanted = np.floor(chance * bits.sum(axis=1)).astype(np.int64)  # how many set bits come before it
    return np.asarray(((np.cumsum(bits, axis=1) > wanted[:, None]) & (bits == 1)).argmax(axis=1), np.int32)
