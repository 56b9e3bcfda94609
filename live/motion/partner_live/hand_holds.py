"""Hand holds between a live follower and the leader (H014): which hands the current unit holds, and how closed they
are.

A hold lasts as long as the danced units contain it, also while the next unit is undecided. If the leader's palm is out
of reach a hold is released or not taken. State advances at ticks; drawing only reads it.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int32
from live.motion.pose.hand_hold import ARM_JOINTS
from live.motion.pose.hand_hold_kernels import measure_reach, reach_palms

NOBODY: Final = -1


@dataclass(frozen=True, slots=True)
class HoldRequest:
    """The hands one follower should hold."""

    leader: int
    follower: int
    hands: tuple[int, int]
    """The leader's hands (0 left, 1 right) that the follower's left and right hand hold, NOBODY for none."""
    amount: float
    """Fader value, 0 to 1."""


PoseReader = Callable[[Int32], tuple[Float32, Float32]]

HALFLIFE: Final = 0.06
"""Half-life [s] with which palms meet and part, ..."""
HALFLIFE_PER_METRE: Final = 0.12
"""... and its increase per metre between them [s/m]."""
HOLD_DELAY: Final = 0.12
"""A hold is taken after it has been wanted and within reach for this long [s], so that a unit change does not
twitch."""
OPEN_THRESHOLD: Final = 0.03
"""A hold less closed than this is open, and one as near to 1 is closed; between them it is eased at both ends."""
TAKE_EXCESS: Final = -0.03
"""A palm is taken if its distance from the shoulder exceeds the arm's reach by at most this [m] ..."""
RELEASE_EXCESS: Final = 0.1
"""... and released if it exceeds it by this."""
TAKE_COSINE: Final = 0.0
"""A palm is taken if the cosine of its direction to the chest's forward axis is above this ..."""
RELEASE_COSINE: Final = -0.25
"""... and released below this: hands are not held behind the back."""
RELEASE_DISTANCE: Final = 0.2
"""A palm nearer to the shoulder than this [m] is released ..."""
TAKE_MARGIN: Final = 0.05
"""... and taken if it is farther by this margin."""
PREDICTION_TIME: Final = 0.1
"""Palm positions extrapolated by this time [s] count as well."""
RELEASE_TIME: Final = 0.1
"""This long [s] after release an arm no longer follows the leader's hand, wherever that moves."""
CHECK_INTERVAL: Final = 2
"""Reach is checked once per this many ticks."""
FADE_HALFLIFE: Final = 0.15
"""Half-life [s] with which the fader is followed."""


class LiveHandHolds:
    """The hand holds of A dancers with their leaders."""

    def __init__(self, count: int) -> None:
        self.leader: Int32 = np.full((count, 2), NOBODY, np.int32)
        """Leader whose hand each dancer's left and right hold or are releasing, NOBODY for none, (A, 2)."""
        self.hand: Int32 = np.zeros((count, 2), np.int32)
        """Which hand of the leader, 0 left, 1 right, (A, 2)."""
        self.closed: Float64 = np.zeros((2, count, 2))
        """How far each hold is closed, 0 to 1, and its rate of change [1/s], (2, A, 2)."""
        self.reachable: Bool = np.zeros((count, 2), np.bool_)
        """Whether that hand is within reach, (A, 2)."""
        self.palm_distance: Float64 = np.zeros((count, 2))
        """Distance between the palms without any reaching [m], (A, 2)."""
        self.missed_count = 0
        """Number of holds released, or not taken, because the other hand was out of reach."""
        self._release_time: Float64 = np.zeros((count, 2))  # time since release began; a hold opens fully first [s]
        self._leader_palm: Float32 = np.zeros(
            (count, 2, 3), np.float32
        )  # leader's palm from the follower's shoulder [m]
        self._wanted_time: Float64 = np.zeros((count, 2))  # time wanted and within reach [s]
        self._miss_counted: Bool = np.zeros((count, 2), np.bool_)
        self._amount: Float64 = np.ones(count)
        self._ticks = 0
        self._rows: list[tuple[int, int]] = []  # (dancer, hand) of all holds; leaders first
        self._last_check: dict[
            tuple[int, int], tuple[float, float, float]
        ] = {}  # reach, direction and distance at the last check
        self._row_keys: list[tuple[int, int, int, int]] = []
        self._rebuild_rows()

    @property
    def held_count(self) -> int:
        """Number of hands held now (more than half closed)."""
        return int((self.closed[0] > 0.5).sum())

    def statistics(self) -> dict[str, int]:
        """Return the number of hands held, and how often one was out of reach so far."""
        return {"held": self.held_count, "out_of_reach": self.missed_count}

    def tick(self, wanted: Sequence[HoldRequest], read_poses: PoseReader, dt: float) -> None:
        """Advance by a tick of `dt` [s] with the `wanted` holds, leaders before their followers.

        `read_poses` returns the current poses of dancers.
        """
        self._ticks += 1
        asked: dict[tuple[int, int], bool] = {}
        for one in wanted:
            self._fade(one, dt)
            for side, hand in enumerate(one.hands):
                asked[one.follower, side] = self._request(one.follower, side, one.leader, hand)
        self._rows = [row for row in (*asked, *(row for row in self._rows if row not in asked)) if self._has_hold(*row)]
        if not self._rows:
            return
        self._rebuild_rows()
        if self._ticks % CHECK_INTERVAL == 0:
            self._check_reach(asked, read_poses, dt)
        for row in self._rows:
            takes = asked.get(row, False) and bool(self.reachable[row]) and not self._release_time[row]
            self._wanted_time[row] = self._wanted_time[row] + dt if takes else 0.0
            if not takes and self.closed[0, row[0], row[1]]:
                self._release_time[row] += dt
            self._advance(*row, 1.0 if takes and self._wanted_time[row] >= HOLD_DELAY else 0.0, dt)
            if not (asked.get(row, False) or self.closed[0, row[0], row[1]]):
                self.leader[row] = NOBODY
                self._last_check.pop(row, None)

    def _fade(self, one: HoldRequest, dt: float) -> None:
        """Follow the fader smoothly; immediately if nothing is held."""
        row = one.follower
        share = 1.0 - math.exp2(-dt / FADE_HALFLIFE) if self.closed[0, row].any() else 1.0
        self._amount[row] += share * (one.amount - self._amount[row])

    def _has_hold(self, row: int, side: int) -> bool:
        return bool(self.leader[row, side] != NOBODY)

    def _request(self, row: int, side: int, leader: int, hand: int) -> bool:
        """Whether the hold that this hand has is wanted. A free hand takes the wanted hold; a busy one releases
        first."""
        if hand == NOBODY:
            return False
        if self.leader[row, side] == NOBODY:
            self.leader[row, side], self.hand[row, side] = leader, hand
            self.reachable[row, side] = self._miss_counted[row, side] = False
        return bool(self.leader[row, side] == leader and self.hand[row, side] == hand)

    def _rebuild_rows(self) -> None:
        """Rebuild the rows for the kernels if they changed since the last tick."""
        laid = [(int(self.leader[row]), row[0], int(self.hand[row]), row[1]) for row in self._rows]
        if laid and laid == self._row_keys:
            return
        self._row_keys = laid
        table = np.array(laid, np.int32).reshape(-1, 4)
        self._dancers, self._hands = table[:, :2].copy(), table[:, 2:].copy()
        self._seen_dancers, where = np.unique(self._dancers, return_inverse=True)
        self._pose_rows = np.array(where.reshape(-1, 2), np.int32)
        self._palm_table: Float32 = np.zeros((len(laid), 6), np.float32)

    def _check_reach(self, asked: dict[tuple[int, int], bool], see: PoseReader, dt: float) -> None:
        """Check what is within reach now and shortly."""
        position, rotation = see(self._seen_dancers)
        measure_reach(position, rotation, self._pose_rows, self._hands, ARM_JOINTS, self._palm_table)
        looks = PREDICTION_TIME / (CHECK_INTERVAL * dt)
        for row, (over, ahead, apart, *place) in zip(self._rows, self._palm_table.tolist(), strict=True):
            size = math.hypot(*place)
            was_over, was_ahead, was_size = self._last_check.get(row, (over, ahead, size))
            self._last_check[row] = over, ahead, size
            over = max(over, over + looks * (over - was_over))
            ahead = min(ahead, ahead + looks * (ahead - was_ahead))
            size = min(size, size + looks * (size - was_size))
            limits = (
                (RELEASE_EXCESS, RELEASE_COSINE, RELEASE_DISTANCE)
                if self.reachable[row]
                else (TAKE_EXCESS, TAKE_COSINE, RELEASE_DISTANCE + TAKE_MARGIN)
            )
            near = over < limits[0] and ahead > limits[1] and size > limits[2]
            self.palm_distance[row], self.reachable[row] = apart, near
            if not self._release_time[row]:
                self._leader_palm[row] = place
            if near:
                self._miss_counted[row] = False
            elif asked.get(row, False) and not self._miss_counted[row] and self._amount[row[0]] > OPEN_THRESHOLD:
                self._miss_counted[row] = True
                self.missed_count += 1

    def _advance(self, row: int, side: int, goal: float, dt: float) -> None:
        """Close or open as a critically damped spring."""
        closed, speed = self.closed[:, row, side].tolist()
        rate = 2.0 * math.log(2.0) / (HALFLIFE + HALFLIFE_PER_METRE * float(self.palm_distance[row, side]))
        away = closed - goal
        fall, bend = math.exp(-rate * dt), speed + away * rate
        closed, speed = goal + fall * (away + bend * dt), fall * (speed - bend * rate * dt)
        if goal == 0.0 and closed < OPEN_THRESHOLD and speed <= 0.0:
            closed = speed = self._release_time[row, side] = 0.0
        self.closed[0, row, side], self.closed[1, row, side] = closed, speed

    def apply(self, position: Float32, rotation: Float32, share: Float64, age: float) -> None:
        """Bring held palms together in poses (A, J, 3) [m] and (A, J, 4), world, in place, `age` [s] after the last
        tick.

        `share` (A,) is the blend weight of each dancer's answer.
        """
        if not self._row_keys:
            return
        who, hand, parts = self.closed_holds(share, age)
        kept = np.zeros((len(parts), 4), np.float32)
        for n, (_, row, _, side) in enumerate(self._row_keys):
            if self._release_time[row, side]:
                left = min((self._release_time[row, side] + age) / RELEASE_TIME, 1.0)
                kept[n, :3], kept[n, 3] = self._leader_palm[row, side], left * left * (3.0 - 2.0 * left)
        if parts.any():
            reach_palms(position, rotation, who, hand, parts, kept, ARM_JOINTS)

    def closed_holds(self, share: Float64, age: float) -> tuple[Int32, Int32, Float32]:
        """Return the H holds `age` [s] after the last tick: leader and follower (H, 2), their hands (H, 2), how far
        closed (H,); `share` (A,) as for `apply`."""
        parts = np.empty(len(self._row_keys), np.float32)
        for n, (_, row, _, side) in enumerate(self._row_keys):
            closed = self.closed[0, row, side] + age * self.closed[1, row, side]
            t = min(max((closed - OPEN_THRESHOLD) / (1.0 - 2.0 * OPEN_THRESHOLD), 0.0), 1.0)
            parts[n] = t * t * (3.0 - 2.0 * t) * self._amount[row] * share[row]
        return self._dancers, self._hands, parts
