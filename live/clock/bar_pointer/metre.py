"""Metres: beats of a measure and how they group, and the slots that the bar pointer has for them.

A slot is one beat of one metre. The slots of a metre follow each other: its downbeat first, then its other beats.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64

Indices = npt.NDArray[np.int64]

METRES: Final = (2, 3, 4, 5, 6, 7, 8, 9)
"""Metres with slots: beats in a measure."""
FIRST_SLOT: Final = tuple(accumulate(METRES[:-1], initial=0))
"""The slot of each metre's downbeat."""
USED: Final = sum(METRES)
SLOTS: Final = 48
"""Slots of each (interval, position); those from `USED` on fill the processor's registers."""
MAX_METRE: Final = METRES[-1]

USUAL: Final = {2: 0.015, 3: 0.2, 4: 0.735, 5: 0.008, 6: 0.05, 7: 0.006, 8: 0.01, 9: 0.006}
"""Prior of each metre; many measures of four also fit a metre of two."""
GROUPS: Final = {
    2: ((2,),), 3: ((3,),), 4: ((2, 2),), 5: ((3, 2), (2, 3)), 6: ((3, 3),), 7: ((2, 2, 3), (3, 2, 2)), 8: ((4, 4),),
    9: ((2, 2, 2, 3), (3, 3, 3)),
}  # fmt: skip
"""Usual groupings of a metre whose grouping is not given."""


@dataclass(frozen=True, slots=True)
class Metre:
    """Beats of a measure; `groups`: the beats between its accents, empty if that is unknown."""

    beats: int
    groups: tuple[int, ...] = ()

    @classmethod
    def parse(cls, text: str | int) -> "Metre":
        """Return the metre of a number of beats, such as 5, or of groups, such as "3+2"; ValueError with a remedy."""
        words = str(text).strip()
        if not re.fullmatch(r"[0-9]{1,2}(\+[0-9]{1,2})*", words):
            raise ValueError(f'{text!r}: a number of beats such as 5, or groups such as "3+2", expected')
        groups = tuple(int(word) for word in words.split("+"))
        beats = sum(groups)
        if beats not in METRES or (len(groups) > 1 and min(groups) < 1):
            raise ValueError(f"{text!r}: a measure has {METRES[0]} to {MAX_METRE} beats")
        return cls(beats, groups if len(groups) > 1 else ())


DEFAULT: Final = tuple(Metre(beats) for beats in METRES if beats != 8)
"""Metres that are looked for if none are given. A measure of eight is heard as two of four."""


def counted_metre(beats: int, metres: Sequence[Metre]) -> int:
    """Return the metre in which measures of so many beats are counted: their own, or the largest that divides it.

    8 is counted as two of 4, unless it is among `metres`. 0 if there is none.
    """
    known = {metre.beats for metre in metres} | {metre.beats for metre in DEFAULT}
    return max((metre for metre in known if beats % metre == 0), default=0) if beats > 0 else 0


def slot_metre(slot: int) -> tuple[int, int]:
    """Return (beats in the measure, beat from 0) of a slot."""
    for metre, first in zip(METRES, FIRST_SLOT, strict=True):
        if slot < first + metre:
            return metre, slot - first
    raise ValueError(f"slot {slot}: 0 to {USED - 1} expected")


def _neighbours(step: int) -> Indices:
    """Return the slot `step` beats later in the same metre, (SLOTS,); unused slots are their own."""
    found = np.arange(SLOTS)
    for metre, first in zip(METRES, FIRST_SLOT, strict=True):
        found[first : first + metre] = first + (np.arange(metre) + step) % metre
    return found


NEXT: Final = _neighbours(1)
PREVIOUS: Final = _neighbours(-1)


def metre_shares(metres: Sequence[Metre]) -> Float64:
    """Return the prior of each of METRES, (M,), sum 1: those that are not among `metres` have none."""
    allowed = {metre.beats for metre in metres}
    share = np.array([USUAL[beats] if beats in allowed else 0.0 for beats in METRES])
    return np.asarray(share / share.sum())


def slot_shares(metres: Sequence[Metre]) -> Float32:
    """Return the prior of each slot, (SLOTS,), sum 1."""
    share = np.zeros(SLOTS, np.float32)
    for beats, first, part in zip(METRES, FIRST_SLOT, metre_shares(metres).tolist(), strict=True):
        share[first : first + beats] = part / beats
    return share


def accents(metres: Sequence[Metre], strength: float) -> Float32:
    """Return how often each slot sounds like a downbeat, (SLOTS,), 0 to 1: 1 for those that are one.

    The first beat of a group does in a share `strength` of the measures, divided by the groupings that are possible.
    """
    found = np.zeros(SLOTS, np.float32)
    for beats, first in zip(METRES, FIRST_SLOT, strict=True):
        given = tuple(metre.groups for metre in metres if metre.beats == beats and metre.groups)
        groupings = given or GROUPS[beats]
        for groups in groupings:
            for begin in list(accumulate(groups))[:-1]:
                found[first + begin] += strength / len(groupings)
        found[first] = 1.0
    return found
