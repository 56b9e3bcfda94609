"""Held: which hands the unit that answers a leader now holds (H014).

A hold goes on as long as the units danced have it: where the next one is not clear yet, as at the end of the last one.

Holding: how far hands are closed that the answers to leaders hold (H014).

Where the leader's palm is out of reach a hold is let go, or not taken. All is advanced at ticks; drawing reads it.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.partner_live.online_player import LivePartner
from live.motion.pose.hand_hold import ARM_JOINTS
from live.motion.pose.hand_hold_kernels import reach_palms, see_palms

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


Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]
See = Callable[[Int32], tuple[Float32, Float32]]

HALFLIFE: Final = 0.06
"""Half-life [s] in which palms meet and part, ..."""
SLOWER: Final = 0.12
"""... and by how much it is longer for each metre that is between them [s/m]."""
WAITS: Final = 0.12
"""A hold is taken once it has been within reach and wanted for so long [s]: who goes over to another unit at once
would only twitch."""
OPEN: Final = 0.03
"""A hold less closed than this is open, and one as near to 1 is closed: the way between is eased at both ends."""
TAKES: Final = -0.03
"""A palm that is so much farther from the shoulder than the arm reaches [m] is taken ..."""
LEAVES: Final = 0.1
"""... and one that is so much farther is let go: till then fingers hold on."""
BEFORE: Final = 0.0
"""A palm is taken whose cosine to where the chest faces is above this ..."""
BEHIND: Final = -0.25
"""... and let go below this: hands are not held behind the back."""
CLOSE: Final = 0.2
"""A palm that is nearer to the shoulder than this [m] is let go ..."""
CLOSER: Final = 0.05
"""... and taken if it is so much farther off."""
SOON: Final = 0.1
"""Where palms will be so much later [s], as they go now, counts as well."""
LEFT: Final = 0.1
"""So long [s] after it is let go a hand is followed no more, wherever it goes, behind the back or past the shoulder."""
EVERY: Final = 2
"""Ticks from one look at what is in reach to the next."""
FADE_HALFLIFE: Final = 0.15
"""Half-life [s] of the way to where the fader is."""


class Holding:
    """The holds of A dancers with whom each of them answers."""

    def __init__(self, count: int) -> None:
        self.leader: Int32 = np.full((count, 2), NOBODY, np.int32)
        """Whose hand each dancer's left and right hold, or are still on the way from, NOBODY for none, (A, 2)."""
        self.hand: Int32 = np.zeros((count, 2), np.int32)
        """Which hand that is, 0 left, 1 right, (A, 2)."""
        self.closed: Float64 = np.zeros((2, count, 2))
        """How far each hold is closed, 0 to 1, and how fast that changes [1/s], (2, A, 2)."""
        self.within: Bool = np.zeros((count, 2), np.bool_)
        """Whether that hand is within reach, (A, 2)."""
        self.apart: Float64 = np.zeros((count, 2))
        """How far the palms would be from each other if nobody reached [m], (A, 2)."""
        self.missed = 0
        """How often a hold was let go, or not taken, because the other hand was out of reach."""
        self._left: Float64 = np.zeros((count, 2))  # for how long each is being let go: it opens wholly first [s]
        self._place: Float32 = np.zeros((count, 2, 3), np.float32)  # of palms, seen from the own chest and shoulder [m]
        self._wanted: Float64 = np.zeros((count, 2))  # for how long each has been, within reach [s]
        self._told: Bool = np.zeros((count, 2), np.bool_)
        self._amount: Float64 = np.ones(count)
        self._ticks = 0
        self._rows: list[tuple[int, int]] = []  # who holds, by which hand; leaders first
        self._last: dict[
            tuple[int, int], tuple[float, float, float]
        ] = {}  # how far and where palms were at the last look
        self._laid: list[tuple[int, int, int, int]] = []
        self._lay()

    @property
    def held(self) -> int:
        """How many hands are held now, more than half closed."""
        return int((self.closed[0] > 0.5).sum())

    def figures(self) -> dict[str, int]:
        """How many hands are held, and how often one was out of reach so far."""
        return {"held": self.held, "out_of_reach": self.missed}

    def tick(self, wanted: Sequence[Held], see: See, dt: float) -> None:
        """A tick of `dt` [s]: these holds are wanted, leaders before those who answer them. `see` tells how some
        dancers look now."""
        self._ticks += 1
        asked: dict[tuple[int, int], bool] = {}
        for one in wanted:
            self._fade(one, dt)
            for side, hand in enumerate(one.hands):
                asked[one.follower, side] = self._want(one.follower, side, one.leader, hand)
        self._rows = [row for row in (*asked, *(row for row in self._rows if row not in asked)) if self._holds(*row)]
        if not self._rows:
            return
        self._lay()
        if self._ticks % EVERY == 0:
            self._look(asked, see, dt)
        for row in self._rows:
            takes = asked.get(row, False) and bool(self.within[row]) and not self._left[row]
            self._wanted[row] = self._wanted[row] + dt if takes else 0.0
            if not takes and self.closed[0, row[0], row[1]]:
                self._left[row] += dt
            self._advance(*row, 1.0 if takes and self._wanted[row] >= WAITS else 0.0, dt)
            if not (asked.get(row, False) or self.closed[0, row[0], row[1]]):
                self.leader[row] = NOBODY
                self._last.pop(row, None)

    def _fade(self, one: Held, dt: float) -> None:
        """The fader, smoothly; at once where nothing is held."""
        row = one.follower
        share = 1.0 - math.exp2(-dt / FADE_HALFLIFE) if self.closed[0, row].any() else 1.0
        self._amount[row] += share * (one.amount - self._amount[row])

    def _holds(self, row: int, side: int) -> bool:
        return bool(self.leader[row, side] != NOBODY)

    def _want(self, row: int, side: int, leader: int, hand: int) -> bool:
        """Whether what this hand has is wanted; a free hand takes up what is. One that has another lets go first."""
        if hand == NOBODY:
            return False
        if self.leader[row, side] == NOBODY:
            self.leader[row, side], self.hand[row, side] = leader, hand
            self.within[row, side] = self._told[row, side] = False
        return bool(self.leader[row, side] == leader and self.hand[row, side] == hand)

    def _lay(self) -> None:
        """The rows as kernels ask for them, anew where they are others than at the last tick."""
        laid = [(int(self.leader[row]), row[0], int(self.hand[row]), row[1]) for row in self._rows]
        if laid and laid == self._laid:
            return
        self._laid = laid
        table = np.array(laid, np.int32).reshape(-1, 4)
        self._who, self._hands = table[:, :2].copy(), table[:, 2:].copy()
        self._looked, where = np.unique(self._who, return_inverse=True)
        self._where = np.array(where.reshape(-1, 2), np.int32)
        self._far: Float32 = np.zeros((len(laid), 6), np.float32)

    def _look(self, asked: dict[tuple[int, int], bool], see: See, dt: float) -> None:
        """What is within reach now, and soon."""
        position, rotation = see(self._looked)
        see_palms(position, rotation, self._where, self._hands, ARM_JOINTS, self._far)
        looks = SOON / (EVERY * dt)
        for row, (over, ahead, apart, *place) in zip(self._rows, self._far.tolist(), strict=True):
            size = math.hypot(*place)
            was_over, was_ahead, was_size = self._last.get(row, (over, ahead, size))
            self._last[row] = over, ahead, size
            over = max(over, over + looks * (over - was_over))
            ahead = min(ahead, ahead + looks * (ahead - was_ahead))
            size = min(size, size + looks * (size - was_size))
            limits = (LEAVES, BEHIND, CLOSE) if self.within[row] else (TAKES, BEFORE, CLOSE + CLOSER)
            near = over < limits[0] and ahead > limits[1] and size > limits[2]
            self.apart[row], self.within[row] = apart, near
            if not self._left[row]:
                self._place[row] = place
            if near:
                self._told[row] = False
            elif asked.get(row, False) and not self._told[row] and self._amount[row[0]] > OPEN:
                self._told[row] = True
                self.missed += 1

    def _advance(self, row: int, side: int, goal: float, dt: float) -> None:
        """Closes or opens as a critically damped spring."""
        closed, speed = self.closed[:, row, side].tolist()
        rate = 2.0 * math.log(2.0) / (HALFLIFE + SLOWER * float(self.apart[row, side]))
        away = closed - goal
        fall, bend = math.exp(-rate * dt), speed + away * rate
        closed, speed = goal + fall * (away + bend * dt), fall * (speed - bend * rate * dt)
        if goal == 0.0 and closed < OPEN and speed <= 0.0:
            closed = speed = self._left[row, side] = 0.0
        self.closed[0, row, side], self.closed[1, row, side] = closed, speed

    def reach(self, position: Float32, rotation: Float32, share: Float64, age: float) -> None:
        """Bring held palms together in poses (A, J, 3) [m] and (A, J, 4), world, in place, `age` [s] after the last
        tick; of each dancer's answer so much is in, `share` (A,)."""
        if not self._laid:
            return
        parts, kept = np.empty(len(self._laid), np.float32), np.zeros((len(self._laid), 4), np.float32)
        for n, (_, row, _, side) in enumerate(self._laid):
            closed = self.closed[0, row, side] + age * self.closed[1, row, side]
            t = min(max((closed - OPEN) / (1.0 - 2.0 * OPEN), 0.0), 1.0)
            if self._left[row, side]:
                left = min((self._left[row, side] + age) / LEFT, 1.0)
                kept[n, :3], kept[n, 3] = self._place[row, side], left * left * (3.0 - 2.0 * left)
            parts[n] = t * t * (3.0 - 2.0 * t) * self._amount[row] * share[row]
        if parts.any():
            reach_palms(position, rotation, self._who, self._hands, parts, kept, ARM_JOINTS)
