"""Hand holds between dancers: which hands are held and how closed each hold is; advanced at ticks, applied to poses."""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Int32
from live.motion.pose.hand_hold_kernels import join_hands
from live.motion.skeleton import SKELETON

LEFT: Final = 0
RIGHT: Final = 1
NOBODY: Final = -1
CLOSE_HALFLIFE: Final = 0.25
"""Half-life with which hands close [beats] ..."""
RELEASE_HALFLIFE: Final = 0.2
"""... and open [beats]: they are free within a beat."""
OPEN_THRESHOLD: Final = 0.03
"""A hold less closed than this is open, and one as near to 1 is closed; between them it is eased at both ends."""
ARM_JOINTS: Final = np.array(
    [SKELETON.index(side + joint) for side in ("left", "right") for joint in ("UpperArm", "LowerArm", "Hand")]
    + [SKELETON.index("upperChest")],
    np.int32,
)
"""The joints that `join_hands` needs, shape (7,)."""


class HeldArms:
    """Arms of A dancers that hold a partner's hand, and dancers who dance in a partner's arms."""

    def __init__(self, dancer_count: int) -> None:
        self.share: Float32 = np.zeros((dancer_count, 2), np.float32)
        """How far the left and the right hand of each dancer are in a hold, 0 to 1, shape (A, 2)."""
        self.partner: Int32 = np.full(dancer_count, NOBODY, np.int32)
        """Partner of each dancer, NOBODY for none, shape (A,)."""
        self.together: Float32 = np.zeros(dancer_count, np.float32)
        """How far each dancer's distance to the partner is that of recorded couples, 0 to 1, shape (A,): all arms of
        such a couple may touch."""

    def add_holds(self, who: Int32, hand: Int32, share: Float32) -> None:
        """Add H holds: two dancers `who` (H, 2), the hand of each `hand` (H, 2), and how far it is closed (H,)."""
        shown = share > 0.0
        np.maximum.at(self.share, (who[shown], hand[shown]), share[shown, None])
        self.partner[who[shown]] = who[shown][:, ::-1]

    def of(self, rows: npt.NDArray[np.intp]) -> "HeldArms":
        """Return those of the dancers `rows` (n,), numbered as there; partners who are not among them are nobody."""
        found, place = HeldArms(len(rows)), np.full(len(self.partner) + 1, NOBODY, np.int32)
        place[rows] = np.arange(len(rows), dtype=np.int32)
        found.share[:], found.together[:] = self.share[rows], self.together[rows]
        found.partner[:] = place[self.partner[rows]]  # the last entry is NOBODY
        return found


class HandHolds:
    """Hand holds of A dancers: each may hold one partner by up to two hands."""

    def __init__(self, dancer_count: int) -> None:
        shape = (dancer_count, 2)
        self.partner: Int32 = np.full(shape, NOBODY, np.int32)
        """Partner of each of a dancer's holds, NOBODY for none, shape (A, 2); each hold is stored with one of the
        two."""
        self.hand: Int32 = np.zeros((*shape, 2), np.int32)
        """The dancer's own hand and the partner's, LEFT or RIGHT, shape (A, 2, 2)."""
        self.state: Float32 = np.zeros((2, *shape), np.float32)
        """How far each hold is closed, 0 to 1, and its rate of change [1/beat], shape (2, A, 2)."""
        self._tempo = 120.0
        self.active = False
        """Whether any hold is closed or moving."""

    def tick(self, other: Int32, hand: Int32, dt: float, tempo: float) -> None:
        """Advance by `dt` [s] at `tempo` [bpm]; wanted are holds with `other` (A, 2) by `hand` (A, 2, 2).

        A hold that is no longer wanted opens first; the next one closes when both hands are free.
        """
        closed, speed = self.state
        self._tempo, beats = tempo, dt * tempo / 60.0
        same = (other == self.partner) & (hand == self.hand).all(axis=-1)
        if not same.all():
            self._take_free(other, hand, same)
            same = (other == self.partner) & (hand == self.hand).all(axis=-1)
        goal = (same & (self.partner >= 0)).astype(np.float32)
        rate = 2.0 * math.log(2.0) / np.where(goal > 0.0, CLOSE_HALFLIFE, RELEASE_HALFLIFE).astype(np.float32)
        away = closed - goal
        fall, bend = np.exp(-rate * np.float32(beats)), speed + away * rate  # critically damped, like free feet
        closed[:] = goal + fall * (away + bend * np.float32(beats))
        speed[:] = fall * (speed - bend * rate * np.float32(beats))
        rest = (goal == 0.0) & (closed < OPEN_THRESHOLD) & (speed <= 0.0)
        self.state[:, rest] = 0.0
        self.active = bool(self.state.any())

    def _take_free(self, other: Int32, hand: Int32, same: npt.NDArray[np.bool_]) -> None:
        """Take wanted holds where neither of the two dancers holds anything any more."""
        holding = self.state[0] > 0.0
        busy = np.zeros(len(other) + 1, np.bool_)  # the last entry is NOBODY
        busy[:-1] = holding.any(axis=1)
        busy[self.partner[holding]] = True
        busy[-1] = False
        free = ~same & ~(busy[:-1, None] | busy[other])
        self.partner[free], self.hand[free] = other[free], hand[free]

    def apply(self, position: Float32, rotation: Float32, age: float) -> None:
        """Join the hands in poses (A, J, 3) [m] and (A, J, 4), in place, `age` [s] after the last tick."""
        if self.active:
            who, hand, share = self.closed_holds(age)
            join_hands(position, rotation, who, hand, share, ARM_JOINTS)

    def closed_holds(self, age: float) -> tuple[Int32, Int32, Float32]:
        """Return the H holds `age` [s] after the last tick: dancers (H, 2), their hands (H, 2), how far closed (H,)."""
        rows, slots = np.nonzero(self.state[0] > 0.0)
        closed = self.state[0, rows, slots] + np.float32(age * self._tempo / 60.0) * self.state[1, rows, slots]
        t = np.clip((closed - OPEN_THRESHOLD) / (1.0 - 2.0 * OPEN_THRESHOLD), 0.0, 1.0)
        who = np.stack([rows.astype(np.int32), self.partner[rows, slots]], axis=1)
        share = np.asarray(t * t * (3.0 - 2.0 * t), np.float32)
        return who, np.ascontiguousarray(self.hand[rows, slots]), share
