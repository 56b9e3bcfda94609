"""Held: which hands the unit that answers a leader now holds (H014).

A hold goes on as long as the units danced have it: where the next one is not clear yet, as at the end of the last one.
"""

from dataclasses import dataclass
from typing import Final

from live.motion.partner_live.player import LivePartner

NOBODY: Final = -1
AHEAD: Final = 0.35
"""So long [s] before a hold begins hands make for it: the recording says so ahead."""


@dataclass(frozen=True, slots=True)
class Held:
    """What one follower is to hold."""

    leader: int
    follower: int
    hands: tuple[int, int]
    """Which of the leader's hands (0 left, 1 right) her left and her right hold, NOBODY for none."""
    amount: float
    """Where the fader is, 0 to 1."""


def hands_of(partner: LivePartner) -> tuple[int, int]:
    """Which of the leader's hands the unit that is danced holds now, by left and right hand; NOBODY for none."""
    found = [NOBODY, NOBODY]
    if not partner.known:
        return NOBODY, NOBODY
    units, unit = partner.reader.units, partner.unit
    holds = units.examples[int(units.example[unit])].holds
    if holds:
        end = float(units.start[unit] + units.length[unit])
        now = min(partner.place, end)
        soon = min(partner.place + AHEAD * partner.pace, end)
        for hold in holds:  # one that is held already goes before the next one
            if hold.begin <= soon and hold.end >= now and found[hold.follower_hand] == NOBODY:
                found[hold.follower_hand] = hold.leader_hand
    return found[0], found[1]
