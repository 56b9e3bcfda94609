"""States of a couple, recognised from the motion of both dancers (H020-H022).

The paper describes Lindy Hop as a state machine (Hsu, Gentry, Popović, *Example-Based Control of Human Motion*, 2004,
section 6.2). Four stances: *open* and *closed* (apart, or in embrace), each also *crosshand* (right hand in right
hand). Three transitions, of four beats each: a step, an inside turn, an outside turn; the handhold may change at their
ends. The paper's states are set by hand; here they are recognised, so that an answer and the real follower can be
compared by the same measure. What a couple shows between two dances is not in it.

Recognition is by distances and angles on the floor, so it holds for any partner dance with a leader and a follower:

- closed: hips are near, both dancers face each other, and a palm of the leader is at the follower's back or side, with
  hysteresis;
- crosshand: the leader's right palm holds the follower's right one;
- a turn: the leader's bearing, as the follower sees it, goes around by most of a circle, and she has turned half of
  one at least. A couple that revolves in embrace, a follower who walks past her leader and faces him again, and a
  leader who walks around her, are no turns by this measure.

Inside and outside are named by the follower's hand that is held, or was until just before: with her right hand an
inside turn goes to her left, with her left hand to her right. A turn without a held hand is free.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64
from live.motion.clip import Clip
from live.motion.editing.facing import heading_of, wrap
from live.motion.partner.answer import palms
from live.motion.partner.evaluation import HoldCriterion, detect_holds, joint_positions
from live.motion.partner.units import Hold
from live.motion.skeleton import SKELETON


class Stance(IntEnum):
    """How a couple stands (H020)."""

    OPEN = 0
    CLOSED = 1
    OPEN_CROSSHAND = 2
    CLOSED_CROSSHAND = 3

    @property
    def words(self) -> str:
        """Its name for readers."""
        return self.name.lower().replace("_", " ")


TurnKind = Literal["inside", "outside", "free"]

CLOSED_DISTANCE: Final = 0.75
"""Hips nearer than this may be in embrace [m];"""
OPEN_DISTANCE: Final = 0.9
"""an embrace ends when they are farther apart than this [m]."""
EMBRACE_REACH: Final = 0.27
"""In embrace a palm of the leader is so near to the axis of the follower's trunk [m]: half her width and a hand;"""
RELEASE_REACH: Final = 0.4
"""it ends when both are farther away than this [m]."""
FACING_RAD: Final = np.radians(80.0)
"""In embrace each dancer has the other within this angle of straight ahead."""
STANCE_S: Final = 0.3
"""A shorter stance is taken for the one around it [s]."""
PALM_CRITERION: Final = HoldCriterion(0.2, 0.4)
"""Palms that hold each other: those of recordings that were fitted to one skeleton come so near."""
TURN_SPEED: Final = np.radians(50.0)
"""While turning, the bearing of the leader changes faster than this [rad/s]."""
TURN_GAP_S: Final = 0.3
"""Two parts of a turn in one direction may be so far apart [s]."""
TURN_RAD: Final = np.radians(230.0)
"""Least change of the bearing of a turn: more than to look away and back, less than a whole turn, whose ends are
uncertain."""
OWN_TURN_RAD: Final = np.radians(150.0)
"""Of these the follower has turned so much herself, at least [rad]."""
SMOOTHING_S: Final = 0.08
"""Standard deviation of the smoothing of the bearing [s]."""
RELEASED_S: Final = 0.5
"""A hand that was held until so long before a turn has led it [s]."""
RAISED_SHARE: Final = 0.3
"""A turn is under a raised hand if a held palm is as high as the follower's eyes in so much of it."""
_HEAD: Final = SKELETON.index("head")
_TRUNK: Final = (SKELETON.index("spine"), SKELETON.index("upperChest"))


@dataclass(frozen=True, slots=True)
class Turn:
    """A turn of the follower."""

    begin: float
    """Sample at which it begins."""
    end: float
    turns: float
    """Whole turns about the vertical, to the nearest half, positive to her left."""
    kind: TurnKind
    raised: bool
    """Whether it goes under a raised held hand."""

    @property
    def words(self) -> str:
        """Its name for readers."""
        size = abs(self.turns)
        many = "half " if size < 0.75 else "" if size < 1.25 else f"{size:g} "
        return f"{many}{self.kind} turn{'s' if size > 1.25 else ''}"


@dataclass(frozen=True, slots=True, eq=False)
class CoupleStates:
    """What a couple does at T samples."""

    rate: float
    """Samples per second [Hz]."""
    stance: npt.NDArray[np.int8]
    """`Stance` at each sample, (T,)."""
    holds: tuple[Hold, ...]
    """Held hands, in samples."""
    turns: tuple[Turn, ...]
    """The follower's turns in their order, in samples."""
    distance: Float64
    """Distance of the hips over the floor [m], (T,)."""
    facing: Float64
    """Bearing of the leader, as the follower sees it [rad], (T,): 0 straight ahead, positive to her right."""

    def turn_at(self, sample: float) -> Turn | None:
        """Return the turn that goes on at a sample."""
        return next((one for one in self.turns if one.begin <= sample <= one.end), None)

    def hands_at(self, sample: float) -> tuple[tuple[int, int], ...]:
        """Return the held hands at a sample, as (leader's, follower's); 0 left, 1 right."""
        return tuple((one.leader_hand, one.follower_hand) for one in self.holds if one.begin <= sample <= one.end)


def recognise_states(leader: Clip, follower: Clip, *, holds: tuple[Hold, ...] | None = None) -> CoupleStates:
    """Return the states of two clips at one rate in one world frame, cut to the shorter one.

    `holds` [samples]: what is known of held hands; None: found by the distance of the palms.
    """
    count = min(leader.sample_count, follower.sample_count)
    rate = follower.sample_rate
    held = detect_holds(leader, follower, PALM_CRITERION) if holds is None else holds
    own = joint_positions(follower)[:count]
    away = follower.root_position[:count].astype(np.float64) - leader.root_position[:count]
    distance = np.hypot(away[:, 0], away[:, 2])
    to_follower = np.arctan2(away[:, 0], away[:, 2])
    ahead = heading_of(follower.rotation[:count, 0])
    leader_sees = wrap(to_follower - heading_of(leader.rotation[:count, 0]))
    follower_sees = wrap(ahead - (to_follower + np.pi))
    reach = _distance_to_trunk(palms(leader)[:count], own).min(axis=1)
    together = _embraced(distance, reach, np.maximum(np.abs(leader_sees), np.abs(follower_sees)), rate)
    cross = np.zeros(count, np.bool_)
    for hold in held:
        if (hold.leader_hand, hold.follower_hand) == (1, 1):
            cross[max(int(np.ceil(hold.begin)), 0) : int(hold.end) + 1] = True
    stance = np.where(cross, 2, 0) + together
    palm = palms(follower)[:count, :, 1]
    turns = _turns(follower_sees, np.asarray(np.unwrap(ahead)), held, palm, own[:, _HEAD, 1], rate)
    return CoupleStates(rate, np.asarray(stance, np.int8), held, turns, np.asarray(distance), follower_sees)


def _distance_to_trunk(points: Float64, joints: Float64) -> Float64:
    """Return the distances of points (T, n, 3) from the axis of the trunk of joints (T, J, 3) [m], (T, n)."""
    low, high = joints[:, _TRUNK[0], None], joints[:, _TRUNK[1], None]
    axis = high - low
    share = np.clip(((points - low) * axis).sum(axis=-1) / (axis**2).sum(axis=-1), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - (low + share[..., None] * axis), axis=-1))


def _embraced(distance: Float64, reach: Float64, away: Float64, rate: float) -> Bool:
    """Return where the couple is in embrace, (T,), from the distance of the hips [m], of the leader's nearer palm from
    the follower's trunk [m], and the larger angle between a dancer's heading and the other dancer [rad], (T,) each."""
    facing = away <= FACING_RAD
    begins = facing & (distance <= CLOSED_DISTANCE) & (reach <= EMBRACE_REACH)
    ends = ~facing | (distance > OPEN_DISTANCE) | (reach > RELEASE_REACH)
    change = np.where(begins, 1, np.where(ends, -1, 0))
    latest = np.maximum.accumulate(np.where(change != 0, np.arange(len(change)), -1))
    raw = (latest >= 0) & (change[np.maximum(latest, 0)] > 0)
    return _without_short_runs(raw, round(STANCE_S * rate))


def _without_short_runs(state: Bool, least: int) -> Bool:
    """Return `state` (T,) with runs of fewer than `least` samples joined to what is around them, the shortest first."""
    found = state.copy()
    while True:
        edges = np.concatenate(([0], np.flatnonzero(np.diff(found)) + 1, [len(found)]))
        sizes = np.diff(edges)
        if len(sizes) < 2 or sizes.min() >= least:
            return found
        shortest = int(np.argmin(sizes))
        found[edges[shortest] : edges[shortest + 1]] ^= True


def _turns(
    sees: Float64, ahead: Float64, holds: tuple[Hold, ...], palm: Float64, head: Float64, rate: float
) -> tuple[Turn, ...]:
    """Return the turns, from the bearing `sees` and the heading `ahead` without jumps (T,) [rad], and the heights of
    the follower's palms (T, 2) and head (T,) [m]."""
    from scipy.ndimage import gaussian_filter1d

    if len(sees) < 3:
        return ()
    angle = gaussian_filter1d(np.unwrap(sees), SMOOTHING_S * rate, mode="nearest")
    speed = np.gradient(angle) * rate
    way = np.where(speed > TURN_SPEED, 1, np.where(speed < -TURN_SPEED, -1, 0))
    edges = np.concatenate(([0], np.flatnonzero(np.diff(way)) + 1, [len(way)]))
    runs: list[tuple[int, int, int]] = []
    for first, after in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        if way[first] == 0:
            continue
        same = runs and runs[-1][2] == way[first] and first - runs[-1][1] <= TURN_GAP_S * rate
        runs.append((runs.pop()[0] if same else first, after - 1, int(way[first])))
    found = []
    for first, last, _ in runs:
        seen, own = float(angle[last] - angle[first]), float(ahead[last] - ahead[first])
        if abs(seen) >= TURN_RAD and abs(own) >= OWN_TURN_RAD and seen * own > 0.0:
            turns = round(own / np.pi) / 2.0
            kind, raised = _led(first, last, own, holds, palm, head, rate)
            found.append(Turn(float(first), float(last), turns, kind, raised))
    return tuple(found)


def _led(
    first: int, last: int, amount: float, holds: tuple[Hold, ...], palm: Float64, head: Float64, rate: float
) -> tuple[TurnKind, bool]:
    """Return how a turn is led, and whether under a raised hand."""
    led = [one for one in holds if min(one.end, last) > max(one.begin, first - RELEASED_S * rate)]
    if not led:
        return "free", False
    under = np.zeros(last + 1 - first, np.bool_)
    for hold in led:
        inside = slice(max(int(hold.begin) - first, 0), max(int(hold.end) + 1 - first, 0))
        rows = slice(first, last + 1)
        under[inside] |= (palm[rows, hold.follower_hand] >= head[rows])[inside]
    raised = bool(under.mean() >= RAISED_SHARE)
    # the hand that is held for longer leads the turn, of two alike the higher one
    lead = max(
        led,
        key=lambda one: (
            round(10.0 * (min(one.end, last) - max(one.begin, first)) / (last + 1 - first)),
            float(palm[first : last + 1, one.follower_hand].mean()),
        ),
    )
    to_left = amount > 0.0
    return ("inside" if to_left == (lead.follower_hand == 1) else "outside"), raised


@dataclass(frozen=True, slots=True)
class Transition:
    """From one stance to another within some beats (H020)."""

    begin: float
    """Sample at which it begins."""
    end: float
    before: Stance
    after: Stance
    turn: str
    """`step`, `inside turn`, `outside turn` or `free turn`."""

    @property
    def words(self) -> str:
        """It for readers, as `open, inside turn, closed`."""
        return f"{self.before.words}, {self.turn}, {self.after.words}"

    def same(self, other: "Transition") -> bool:
        """Whether both are the same transition of the state machine, at whatever time."""
        return (self.before, self.turn, self.after) == (other.before, other.turn, other.after)


TRANSITION_BEATS: Final = 4
"""Beats of a transition (H020)."""
PATTERN_BEATS: Final = 8
"""Beats of a pattern, of two transitions (H021)."""


def transitions(states: CoupleStates, cuts: Float64) -> tuple[Transition, ...]:
    """Return the transitions between `cuts` [samples] (n + 1,), ascending.

    The stance at a cut is the most frequent one within a quarter of the transition around it. A turn belongs to the
    transition in which most of it lies.
    """
    if len(cuts) < 2:
        return ()
    quarter = 0.125 * np.diff(cuts, append=2.0 * cuts[-1] - cuts[-2])
    at = [_stance_around(states, float(cut), float(half)) for cut, half in zip(cuts, quarter, strict=True)]
    middle = np.array([0.5 * (one.begin + one.end) for one in states.turns])
    found = []
    for n in range(len(cuts) - 1):
        inside = np.flatnonzero((middle >= cuts[n]) & (middle < cuts[n + 1]))
        longest = max((states.turns[int(m)] for m in inside), key=lambda one: abs(one.turns), default=None)
        kind = "step" if longest is None else f"{longest.kind} turn"
        found.append(Transition(float(cuts[n]), float(cuts[n + 1]), at[n], at[n + 1], kind))
    return tuple(found)


def _stance_around(states: CoupleStates, sample: float, half: float) -> Stance:
    first = max(min(round(sample - half), len(states.stance) - 1), 0)
    part = states.stance[first : max(round(sample + half), first) + 1]
    return Stance(int(np.argmax(np.bincount(part, minlength=len(Stance)))))
