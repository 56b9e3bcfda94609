"""Partners: two dancers at arm's length as one; a pair travels and turns together.

In a group with `partners` its members 1 and 2, 3 and 4 ... are pairs: one leads, the other follows. Their agents are
the two ends of a rod (`pair_steering.py`); where the leader's measure ends, and which way she faces there, says where
the follower's measure should end. An odd member dances alone. Whoever leaves her group or the stage lets go at once;
who is left over finds a new partner at the next measure line.

Pair steering: the agents of partners advance as the two ends of a rod, on the stage and in the look-ahead.

Following: partners who follow choose their next measures after their leaders have, to end at their side.
"""

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import Wants
from live.agents.crowd.agent_state import AgentState, Steering
from live.agents.crowd.crowd_step import Advance
from live.agents.crowd.obstacles import Surroundings
from live.graph.select.candidates import turn_vectors, wrapped
from live.graph.select.selector import Choosing, with_direction
from live.motion.pose.hand_hold import LEFT, NOBODY, RIGHT
from live.show.group.casting import Casting
from live.show.patch.patch import Patch
from live.show.selection.choices import Choices

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

ALONE: Final = 0
FACING: Final = 1
BESIDE: Final = 2
SHADOW: Final = 3
MANNERS: Final = {None: ALONE, "facing": FACING, "beside": BESIDE, "shadow": SHADOW}
SHADOW_ANGLE: Final = math.radians(35.0)
"""So far behind the line of her leader's shoulders a shadow stands, at her left."""
TURN: Final = math.radians(30.0)
"""A pair turns by this much in a measure at most: each of the two has to go round the middle."""
MEET: Final = 0.3
"""Two who are this much [m] farther apart than their arms' length are still on the way to each other."""
CLOSE: Final = 0.2
"""Partners nearer than their arms' length by this much [m] are not moved as one."""
MOST: Final = 0.4
"""What is amiss between the two of a pair at the end of a measure is mended by this much [m] at most."""
_PLACE: Final = np.array(
    [[0.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [math.cos(SHADOW_ANGLE), -math.sin(SHADOW_ANGLE)]]
)  # of the follower, seen by her leader who faces 0, for each manner
_AHEAD: Final = np.array([0.0, math.pi, 0.0, 0.0])  # how far her heading is ahead of her leader's
_HANDS: Final = {  # which hand of the leader holds which hand of the follower
    FACING: ((LEFT, RIGHT), (RIGHT, LEFT)),
    BESIDE: ((RIGHT, LEFT),),
    SHADOW: ((LEFT, RIGHT),),
}


class Partners:
    """Who dances with whom among A dancers."""

    def __init__(self, patch: Patch, casting: Casting) -> None:
        count = len(casting.group)
        self._group = casting.group
        self._manner = np.array([MANNERS[section.partners] for section in patch.group], np.int32)
        self._arm = np.array([section.arm_length for section in patch.group])
        self._holds = [_holds(int(m), s.hands) for m, s in zip(self._manner, patch.group, strict=True)]
        self.of: Int32 = np.full(count, NOBODY, np.int32)
        """Partner of each dancer, NOBODY for none, shape (A,)."""
        self.leader: Int32 = np.zeros(0, np.int32)
        """The leaders of the P pairs, shape (P,)."""
        self.follower: Int32 = np.zeros(0, np.int32)
        """Their followers, shape (P,)."""
        self.other: Int32 = np.full((count, 2), NOBODY, np.int32)
        self.hand: Int32 = np.zeros((count, 2, 2), np.int32)
        """The hands that are to be held, as `Hands.tick` takes them."""
        self._meeting: Bool = np.zeros(count, np.bool_)
        self._own: Int32 = np.arange(count, dtype=np.int32)
        self._dance = bool(self._manner.any())  # whether there is any group with partners
        self.offset: Float64 = np.zeros((2, count, 2))
        """From each follower's leader to her [m] when the present and the coming measure end, shape (2, A, 2)."""

    @property
    def arm(self) -> Float64:
        """How far the two of each pair are apart [m], shape (P,)."""
        return np.asarray(self._arm[self._group[self.leader]])

    @property
    def mirrored(self) -> Bool:
        """Who dances the mirror image of what her partner does, shape (A,): followers who face their leaders."""
        mirrored = np.zeros(len(self.of), np.bool_)
        mirrored[self.follower] = self._manner[self._group[self.leader]] == FACING
        return mirrored

    def timing(self) -> Int32:
        """Whose timing each dancer has: her leader's or her own, shape (A,)."""
        if not len(self.leader):
            return self._own
        like = self._own.copy()
        like[self.follower] = self.leader
        return like

    # -- who with whom -------------------------------------------------------------------------------------------

    def part(self, there: Bool) -> None:
        """Pairs end whose dancers are not both `there` (A,) and in one group with partners any more."""
        lead, follow = self.leader, self.follower
        if not len(lead):
            return
        manner = self._manner[self._group[lead]]
        stay = there[lead] & there[follow] & (self._group[lead] == self._group[follow]) & (manner != ALONE)
        if not stay.all():
            self._set(lead[stay], follow[stay])

    def pair(self, there: Bool) -> None:
        """At a measure line: those `there` (A,) who have no partner take one, in the order of their numbers."""
        if not self._dance:
            return
        self.part(there)
        self.offset[0] = self.offset[1]
        leaders, followers = [self.leader], [self.follower]
        for index in np.flatnonzero(self._manner).tolist():
            single = np.flatnonzero((self._group == index) & there & (self.of < 0)).astype(np.int32)
            pairs = len(single) // 2
            leaders.append(single[0 : 2 * pairs : 2])
            followers.append(single[1 : 2 * pairs : 2])
        if sum(map(len, leaders)) > len(self.leader):
            self._set(np.concatenate(leaders), np.concatenate(followers))

    def _set(self, leader: Int32, follower: Int32) -> None:
        order = np.argsort(leader)
        self.leader, self.follower = leader[order], follower[order]
        self.of[:] = NOBODY
        self.of[leader], self.of[follower] = follower, leader
        self.other[:], self.hand[:] = NOBODY, 0
        for lead, follow in zip(self.leader.tolist(), self.follower.tolist(), strict=True):
            for n, hands in enumerate(self._holds[self._group[lead]]):
                self.other[lead, n], self.hand[lead, n] = follow, hands

    # -- places --------------------------------------------------------------------------------------------------

    def places(self, heading: Float64) -> Float64:
        """From leaders who face `heading` (P,) [rad] to their followers [m], shape (P, 2)."""
        manner = self._manner[self._group[self.leader]]
        return turn_vectors(_PLACE[manner] * self.arm[:, None], heading)

    def faces(self, heading: Float64) -> Float64:
        """Where the followers of leaders who face `heading` (P,) face [rad], shape (P,)."""
        return np.asarray(heading + _AHEAD[self._manner[self._group[self.leader]]])

    def begin(self, position: Float32, heading: Float64) -> None:
        """Everybody stands at `position` (A, 2) [m]: pairs about their leaders' places; both face as pairs do."""
        lead, follow = self.leader, self.follower
        half = 0.5 * self.places(heading[lead])
        middle = position[lead].astype(np.float64)
        position[lead], position[follow] = middle - half, middle + half
        heading[follow] = self.faces(heading[lead])
        self.offset[:, follow] = 2.0 * half

    # -- what the next measure shall be --------------------------------------------------------------------------

    def aim(self, wish: Float64, heading: Float64, stand: Float64, now: Float64, known: Bool) -> None:
        """Change what is wanted, `wish` (A, 2) [m] and `heading` (A,) [rad], so that pairs stay pairs.

        `stand` (A, 2) and `now` (A,): where everybody will be and face when the measure begins. The leader's heading
        turns the pair, as fast as pairs can; their middle goes where the middle of both would, or where the leader's
        formation wants it (`known`).
        """
        lead, follow = self.leader, self.follower
        self._meeting[follow] = np.hypot(*(stand[follow] - stand[lead]).T) > self.arm + MEET
        turn = wrapped(heading[lead] - now[lead])
        heading[lead] = now[lead] + np.clip(turn, -TURN, TURN)
        heading[follow] = self.faces(heading[lead])
        half = 0.5 * self.places(heading[lead])
        middle = np.where(known[lead, None], wish[lead], 0.5 * (wish[lead] + wish[follow]))
        wish[lead], wish[follow] = middle - half, middle + half

    def gather(self, target: npt.NDArray[np.floating], heading: Float64) -> None:
        """Bring the places `target` (A, 2) [m] of pairs to arm's length, whose leaders face `heading` (A,); the middle
        of each two stays."""
        lead, follow = self.leader, self.follower
        half = 0.5 * self.places(heading[lead])
        middle = 0.5 * (target[lead] + target[follow])
        target[lead], target[follow] = middle - half, middle + half

    def follow(self, reached: Float64, facing: Float64, target: Float64, heading: Float64) -> None:
        """The leaders' measures will end at `reached` (P, 2) [m], `facing` (P,): their followers go there, too."""
        offset = self.places(facing)
        self.offset[1, self.follower] = offset
        target[self.leader] = reached
        target[self.follower] = reached + offset
        heading[self.leader], heading[self.follower] = facing, self.faces(facing)

    def sides(self, node_side: Int32) -> Int32:
        """The sides followers want whose leaders dance nodes of these sides, (P,): who face each other mirror."""
        return np.where(self._manner[self._group[self.leader]] == FACING, -node_side, node_side).astype(np.int32)

    def own_sides(self, side: Int32, now: Int32) -> Int32:
        """The sides (A,) that everybody wants, who dance nodes of the sides `now` (A,): leaders keep theirs, for from a
        measure on the other foot there is seldom a way to follow."""
        side = side.copy()
        side[self.leader] = np.where(side[self.leader] == 0, now[self.leader], side[self.leader])
        return side

    def move(self, moved: Float64, place: Float32) -> None:
        """Who is pushed aside, `moved` (A, 2) [m] from her `place` (A, 2), takes her partner along, unless these two
        are pushed off each other."""
        lead, follow = self.leader, self.follower
        if len(lead):
            held = (np.hypot(*(place[follow] - place[lead]).T) > self.arm - CLOSE)[:, None]
            both = moved[lead] + moved[follow]
            moved[lead], moved[follow] = np.where(held, both, moved[lead]), np.where(held, both, moved[follow])

    def level(self, ends: Float64, *, coming: bool) -> None:
        """Move the ends (A, 2) [m] of the present or the `coming` measures so that pairs are at arm's length, each of
        the two by half of what is amiss, MOST at most; who are on the way to each other are left."""
        lead, follow = self.leader, self.follower
        if not len(lead):
            return
        amiss = ends[follow] - ends[lead] - self.offset[int(coming), follow]
        size = np.hypot(*amiss.T)
        amiss *= (np.minimum(size, MOST) / np.maximum(size, 1e-9) * ~self._meeting[follow])[:, None]
        ends[lead] += 0.5 * amiss
        ends[follow] -= 0.5 * amiss


def _holds(manner: int, hands: str) -> tuple[tuple[int, int], ...]:
    """The hands held by partners of a manner."""
    if manner == ALONE or hands == "none":
        return ()
    return _HANDS[manner] if hands == "both" else _HANDS[manner][:1]


CLOSING_S: Final = 0.6
"""Two who are on the way to each other would meet in this time [s], if they were fast enough."""
RATE: Final = 1.0
"""A rod gets its length back at this speed [m/s] at most."""
FIRM: Final = 0.5
"""From this firmness on what the leader is asked to do counts for both."""


class PairSteering:
    """Advances agents as `Advance` does, pairs as one."""

    def __init__(self, advance: Advance, partners: Partners) -> None:
        self._advance, self._partners = advance, partners

    def resize(self, half_width: float, half_depth: float) -> None:
        """The stage's half sizes [m] are these from now on."""
        self._advance.resize(half_width, half_depth)

    def steer(self, steering: Steering) -> None:
        """Other parameters from now on; the stage's size stays."""
        self._advance.steer(steering)

    def yield_to(self, rows: npt.NDArray[np.integer], responsibility: npt.NDArray[np.floating]) -> None:
        """The agents `rows` (n,) take this share of avoiding from now on, (n,)."""
        self._advance.yield_to(rows, responsibility)

    def __call__(
        self,
        current: AgentState,
        out: AgentState,
        *,
        wants: Wants,
        surroundings: Surroundings,
        time: float,
        dt: float,
    ) -> None:
        """Read `current`, write `out`, `dt` [s] later; `wants` is changed to what both of a pair want."""
        if len(self._partners.leader):
            self._ask(wants, current)
        self._advance(current, out, wants=wants, surroundings=surroundings, time=time, dt=dt)
        if len(self._partners.leader):
            self._hold(out, dt)

    def _ask(self, wants: Wants, state: AgentState) -> None:
        """Both of a pair want the same; who are still apart go to each other."""
        lead, follow, arm = self._partners.leader, self._partners.follower, self._partners.arm
        firm = wants.firm[lead] > FIRM
        both = 0.5 * (wants.velocity[lead] + wants.velocity[follow])
        both = np.where(firm[:, None], wants.velocity[lead], both)
        wants.firm[follow] = wants.firm[lead]
        wants.alignment[follow], wants.cohesion[follow] = wants.alignment[lead], wants.cohesion[lead]
        speed = np.minimum(wants.speed[lead], wants.speed[follow])
        wants.speed[lead], wants.speed[follow] = speed, speed
        between = (state.position[follow] - state.position[lead]).astype(np.float64)
        apart = np.maximum(np.hypot(*between.T), 1e-6)
        far = np.where(apart - arm > MEET, apart - arm, 0.0)
        close = between * (np.minimum(0.5 * far / CLOSING_S, speed) / apart)[:, None]
        wants.velocity[lead] = both + close
        wants.velocity[follow] = both - close
        for rows in (lead, follow):  # nobody is pushed off by her own partner
            wants.separation[rows] = np.minimum(wants.separation[rows], arm)

    def _hold(self, state: AgentState, dt: float) -> None:
        """The rod keeps its length, and neither end moves along it faster than the other."""
        lead, follow, arm = self._partners.leader, self._partners.follower, self._partners.arm
        between = (state.position[follow] - state.position[lead]).astype(np.float64)
        apart = np.maximum(np.hypot(*between.T), 1e-6)
        way = between / apart[:, None]
        amiss = apart - arm
        held = amiss <= MEET
        move = np.where(held, np.clip(0.5 * amiss, -RATE * dt, RATE * dt), 0.0)[:, None] * way
        state.position[lead] += move
        state.position[follow] -= move
        along = ((state.velocity[follow] - state.velocity[lead]) * way).sum(axis=1)
        change = np.where(held, 0.5 * along, 0.0)[:, None] * way
        state.velocity[lead] += change
        state.velocity[follow] -= change


TOO_FAR: Final = 0.4
"""A follower whose measure would end so far [m] from her place may dance any side of the step."""


def place_followers(
    partners: Partners, choosing: Choosing, choices: Choices, heading: Float64, asked: tuple[Any, ...]
) -> tuple[Int32, Int32]:
    """Say where followers should end, once everybody has chosen, `asked` with these arguments of `Choosing.choose`.

    Leaders end where their clips and corrections take them, and face what their turns reach: both are written into
    the targets and `heading` (A,) [rad], and their followers' places and headings beside them. Returns the followers
    (P,) and the sides they want: the mirror image of what their leaders dance where they face them, else the same.
    """
    node, _, wish, _, _, _, manner, _ = asked
    lead, follow = partners.leader, partners.follower
    end, edge = choices.end[lead], choices.edge[lead, 0]
    chosen = np.where(edge < 0, node[lead], choosing.graph.edge_target[np.maximum(edge, 0)])
    way = choices.target[lead] - end[:, :2]
    most = manner[lead, 2] * choosing.facts[chosen, 0]
    reached = end[:, :2] + way * np.minimum(1.0, most / np.maximum(np.hypot(*way.T), 1e-9))[:, None]
    facing = heading[lead] - end[:, 3]
    lost = edge < 0  # cannot happen in a pruned graph
    reached[lost], facing[lost] = choices.target[lead][lost], heading[lead][lost]
    partners.follow(reached, facing, choices.target, heading)
    wish[follow] = with_direction(np.column_stack([choices.target[follow], heading[follow]]))
    return follow, partners.sides(choosing.graph.library.node_side[chosen])


def choose_following(rows: Int32, sides: Int32, choosing: Choosing, choices: Choices, asked: tuple[Any, ...]) -> None:
    """Choose anew for the followers `rows` (n,) who want these `sides` (n,); to stay together is more than to dance on
    the same feet."""
    _choose(rows, sides, choosing, asked)
    off = np.hypot(*(choices.end[rows, :2] - choices.target[rows]).T)
    far = rows[off > TOO_FAR]
    if len(far):
        _choose(far, np.zeros(len(far), np.int32), choosing, asked)


def _choose(rows: Int32, sides: Int32, choosing: Choosing, asked: tuple[Any, ...]) -> None:
    node, placement, wish, row, ahead, _, manner, out = asked
    results: Any = tuple(np.ascontiguousarray(array[rows]) for array in out)
    choosing.choose(
        slice(0, len(rows)), node[rows], placement[rows], wish[rows], row[rows], ahead, sides, manner[rows], results
    )
    for array, result in zip(out, results, strict=True):
        array[rows] = result
