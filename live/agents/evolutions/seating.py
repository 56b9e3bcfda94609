"""Seating: which dancer gets which slot of a formation, and where those stand for whom there is none (T097-T100)."""

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.divided import DividedMatching
from live.agents.evolutions.intention import By, Matching
from live.agents.evolutions.matching import by_id
from live.agents.evolutions.pieces import Pieces
from live.agents.evolutions.sections import sections
from live.agents.evolutions.segment_start import Departure
from live.agents.evolutions.standing_clear import clear_places
from live.agents.evolutions.trajectory import Float64

CLEAR_GAP = 1.0
"""Metres between dancers who stand clear of a formation."""


def seated(
    matching: Matching, slots: Float64, marks: object, departure: Departure
) -> Pieces[tuple[npt.NDArray[np.int32], Float64]]:
    """Everybody's row of the places: the slots, and after them places to stand clear for those without one."""
    count = len(departure.numbers)
    words = tuple(marks) if isinstance(marks, list | tuple) and len(marks) == len(slots) else ("",) * len(slots)
    dancer_section, slot_section = sections(departure.words, words)
    left_over = count - _seats(dancer_section, slot_section)
    clear = clear_places(left_over, departure.position, slots, half=departure.half, gap=CLEAR_GAP)
    places = np.concatenate([slots, clear])
    slot_section = np.concatenate([slot_section, np.zeros(len(clear), np.int32)])
    if matching.by is By.ID:
        slot = by_id(count, len(slots))
        slot[slot < 0] = len(slots) + np.arange((slot < 0).sum())
        return slot, (places if len(clear) else slots)
    solver = DividedMatching()
    solver.begin(
        departure.position,
        places,
        cost=matching.cost,
        equal_weight=matching.equal_weight,
        fill=matching.fill,
        dancer_section=dancer_section,
        slot_section=slot_section,
    )
    while not solver.done:
        solver.work()
        yield
    return solver.slot, places


def _seats(dancer_section: npt.NDArray[np.int32], slot_section: npt.NDArray[np.int32]) -> int:
    """How many dancers find a slot: on those of their section, and the rest on those without a mark."""
    placed, rest = 0, 0
    for section in np.unique(dancer_section):
        members, own = int((dancer_section == section).sum()), int((slot_section == section).sum())
        if section == 0:
            rest += members
        else:
            placed += min(members, own)
            rest += max(members - own, 0)
    return placed + min(rest, int((slot_section == 0).sum()))
