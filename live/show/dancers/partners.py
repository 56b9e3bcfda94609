"""Partner dancing: pairs of a leader and a follower who travel and turn together at arm's length.

In a group with `partners`, members 1 and 2, 3 and 4 ... form pairs. A last odd member dances alone. The two agents of a
pair move as the ends of a rod. Followers choose their next step after their leaders: the end and heading of the
leader's measure give the target of the follower's. A pair ends as soon as one of the two leaves the group or the stage.
Dancers left alone are paired again at the next measure line.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentState, Steering
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings
from live.base.arrays import Bool, Float32, Float64, Int32
from live.graph.select.candidates import turn_vectors, wrap_angle
from live.motion.pose.hand_hold import LEFT, NOBODY, RIGHT
from live.show.group.casting import Casting
from live.show.patch.patch import Patch

ALONE: Final = 0
FACING: Final = 1
BESIDE: Final = 2
SHADOW: Final = 3
ARRANGEMENTS: Final = {None: ALONE, "facing": FACING, "beside": BESIDE, "shadow": SHADOW}
SHADOW_ANGLE: Final = math.radians(35.0)
"""Angle of a shadow behind the line of the leader's shoulders, on the leader's left [rad]."""
MAX_TURN: Final = math.radians(30.0)
"""Largest turn of a pair in one measure [rad]: both dancers have to walk around the middle."""
APPROACH_DISTANCE: Final = 0.3
"""Partners farther apart than arm's length by more than this [m] are still approaching each other."""
TOO_CLOSE: Final = 0.2
"""Partners closer than arm's length by more than this [m] are not moved together."""
MAX_END_CORRECTION: Final = 0.4
"""Largest correction of a pair's distance error at the end of a measure [m]."""
_PLACE: Final = np.array(
    [[0.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [math.cos(SHADOW_ANGLE), -math.sin(SHADOW_ANGLE)]]
)  # of the follower relative to a leader with heading 0, per manner
_AHEAD: Final = np.array([0.0, math.pi, 0.0, 0.0])  # the follower's heading minus the leader's, per manner
_HANDS: Final = {  # (hand of the leader, hand of the follower)
    FACING: ((LEFT, RIGHT), (RIGHT, LEFT)),
    BESIDE: ((RIGHT, LEFT),),
    SHADOW: ((LEFT, RIGHT),),
}


class Partners:
    """The pairs among A dancers."""

    def __init__(self, patch: Patch, casting: Casting) -> None:
        count = len(casting.group)
        self._group = casting.group
        self._arrangement = np.array([ARRANGEMENTS[section.partners] for section in patch.group], np.int32)
        self._arm = np.array([section.arm_length for section in patch.group])
        self._holds = [_held_hands(int(m), s.hands) for m, s in zip(self._arrangement, patch.group, strict=True)]
        self.partner: Int32 = np.full(count, NOBODY, np.int32)
        """Partner of each dancer, NOBODY for none, shape (A,)."""
        self.leader: Int32 = np.zeros(0, np.int32)
        """Leaders of the P pairs, shape (P,)."""
        self.follower: Int32 = np.zeros(0, np.int32)
        """Followers of the P pairs, shape (P,)."""
        self.other: Int32 = np.full((count, 2), NOBODY, np.int32)
        self.hand: Int32 = np.zeros((count, 2, 2), np.int32)
        """The hands to be held, as `LiveHandHolds.tick` expects them."""
        self._meeting: Bool = np.zeros(count, np.bool_)
        self._own: Int32 = np.arange(count, dtype=np.int32)
        self._dance = bool(self._arrangement.any())  # whether any group has partners
        self.offset: Float64 = np.zeros((2, count, 2))
        """From leader to follower [m] at the end of the present and of the coming measure, by follower, (2, A, 2)."""

    @property
    def arm_length(self) -> Float64:
        """Distance of the two dancers of each pair [m], shape (P,)."""
        return np.asarray(self._arm[self._group[self.leader]])

    @property
    def mirrored(self) -> Bool:
        """Dancers who dance the mirror image of their partner's steps, shape (A,): followers who face their leaders."""
        mirrored = np.zeros(len(self.partner), np.bool_)
        mirrored[self.follower] = self._arrangement[self._group[self.leader]] == FACING
        return mirrored

    def timing_source(self) -> Int32:
        """The dancer whose timing each dancer uses, shape (A,): a follower's leader, else the dancer."""
        if not len(self.leader):
            return self._own
        like = self._own.copy()
        like[self.follower] = self.leader
        return like

    # -- pairing -------------------------------------------------------------------------------------------------

    def end_pairs(self, there: Bool) -> None:
        """End the pairs whose dancers are not both `there` (A,) and in the same group with partners."""
        lead, follow = self.leader, self.follower
        if not len(lead):
            return
        manner = self._arrangement[self._group[lead]]
        stay = there[lead] & there[follow] & (self._group[lead] == self._group[follow]) & (manner != ALONE)
        if not stay.all():
            self._set(lead[stay], follow[stay])

    def form_pairs(self, there: Bool) -> None:
        """Pair dancers who are `there` (A,) and have no partner, in index order. Called at measure lines."""
        if not self._dance:
            return
        self.end_pairs(there)
        self.offset[0] = self.offset[1]
        leaders, followers = [self.leader], [self.follower]
        for index in np.flatnonzero(self._arrangement).tolist():
            single = np.flatnonzero((self._group == index) & there & (self.partner < 0)).astype(np.int32)
            pairs = len(single) // 2
            leaders.append(single[0 : 2 * pairs : 2])
            followers.append(single[1 : 2 * pairs : 2])
        if sum(map(len, leaders)) > len(self.leader):
            self._set(np.concatenate(leaders), np.concatenate(followers))

    def _set(self, leader: Int32, follower: Int32) -> None:
        order = np.argsort(leader)
        self.leader, self.follower = leader[order], follower[order]
        self.partner[:] = NOBODY
        self.partner[leader], self.partner[follower] = follower, leader
        self.other[:], self.hand[:] = NOBODY, 0
        for lead, follow in zip(self.leader.tolist(), self.follower.tolist(), strict=True):
            for n, hands in enumerate(self._holds[self._group[lead]]):
                self.other[lead, n], self.hand[lead, n] = follow, hands

    # -- relative placement --------------------------------------------------------------------------------------

    def follower_offsets(self, heading: Float64) -> Float64:
        """Offsets from leaders with `heading` (P,) [rad] to their followers [m], shape (P, 2)."""
        manner = self._arrangement[self._group[self.leader]]
        return turn_vectors(_PLACE[manner] * self.arm_length[:, None], heading)

    def follower_headings(self, heading: Float64) -> Float64:
        """Headings of the followers of leaders with `heading` (P,) [rad], shape (P,)."""
        return np.asarray(heading + _AHEAD[self._arrangement[self._group[self.leader]]])

    def place_pairs(self, position: Float32, heading: Float64) -> None:
        """Change starting positions (A, 2) [m] and headings (A,) so that each pair stands around its leader's place."""
        lead, follow = self.leader, self.follower
        half = 0.5 * self.follower_offsets(heading[lead])
        middle = position[lead].astype(np.float64)
        position[lead], position[follow] = middle - half, middle + half
        heading[follow] = self.follower_headings(heading[lead])
        self.offset[:, follow] = 2.0 * half

    # -- targets of the next measure -----------------------------------------------------------------------------

    def adjust_targets(self, wish: Float64, heading: Float64, stand: Float64, now: Float64, known: Bool) -> None:
        """Change the targets `wish` (A, 2) [m] and `heading` (A,) [rad] so that pairs stay together.

        `stand` (A, 2) and `now` (A,) are positions and headings at the beginning of the measure. The leader's heading
        turns the pair, by TURN at most. The pair's middle goes to the middle of both targets or, for leaders in a
        formation (`known`), to the leader's target.
        """
        lead, follow = self.leader, self.follower
        self._meeting[follow] = np.hypot(*(stand[follow] - stand[lead]).T) > self.arm_length + APPROACH_DISTANCE
        turn = wrap_angle(heading[lead] - now[lead])
        heading[lead] = now[lead] + np.clip(turn, -MAX_TURN, MAX_TURN)
        heading[follow] = self.follower_headings(heading[lead])
        half = 0.5 * self.follower_offsets(heading[lead])
        middle = np.where(known[lead, None], wish[lead], 0.5 * (wish[lead] + wish[follow]))
        wish[lead], wish[follow] = middle - half, middle + half

    def gather(self, target: npt.NDArray[np.floating], heading: Float64) -> None:
        """Bring the targets `target` (A, 2) [m] of pairs to arm's length for leaders with `heading` (A,). The middle of
        each pair stays."""
        lead, follow = self.leader, self.follower
        half = 0.5 * self.follower_offsets(heading[lead])
        middle = 0.5 * (target[lead] + target[follow])
        target[lead], target[follow] = middle - half, middle + half

    def set_follower_targets(self, reached: Float64, facing: Float64, target: Float64, heading: Float64) -> None:
        """Write the targets of pairs whose leaders' measures will end at `reached` (P, 2) [m] with `facing` (P,)."""
        offset = self.follower_offsets(facing)
        self.offset[1, self.follower] = offset
        target[self.leader] = reached
        target[self.follower] = reached + offset
        heading[self.leader], heading[self.follower] = facing, self.follower_headings(facing)

    def follower_sides(self, node_side: Int32) -> Int32:
        """Sides wanted by followers whose leaders dance nodes of `node_side` (P,), (P,): mirrored for facing pairs."""
        return np.where(self._arrangement[self._group[self.leader]] == FACING, -node_side, node_side).astype(np.int32)

    def follower_nodes(self, node: Int32) -> Int32:
        """Measures wanted by followers whose leaders dance `node` (P,), (P,): the same for pairs who look the same way,
        below 0 (any) for facing pairs, whose ways are opposite."""
        return np.where(self._arrangement[self._group[self.leader]] == FACING, -1, node).astype(np.int32)

    def wanted_sides(self, side: Int32, now: Int32) -> Int32:
        """Sides wanted by all dancers (A,), who now dance nodes of the sides `now` (A,).

        Leaders without a preference keep their side: after a change of feet, followers seldom find a matching step.
        """
        side = side.copy()
        side[self.leader] = np.where(side[self.leader] == 0, now[self.leader], side[self.leader])
        return side

    def share_push(self, moved: Float64, place: Float32) -> None:
        """Apply the displacement `moved` (A, 2) [m] of a dancer at `place` (A, 2) to the partner too.

        Partners who are too close to each other are moved separately.
        """
        lead, follow = self.leader, self.follower
        if len(lead):
            held = (np.hypot(*(place[follow] - place[lead]).T) > self.arm_length - TOO_CLOSE)[:, None]
            both = moved[lead] + moved[follow]
            moved[lead], moved[follow] = np.where(held, both, moved[lead]), np.where(held, both, moved[follow])

    def align_ends(self, ends: Float64, *, coming: bool) -> None:
        """Move the ends (A, 2) [m] of the present or the `coming` measures so that pairs end at arm's length.

        Each of the two takes half of the error, which is limited to MOST. Pairs that are still approaching are skipped.
        """
        lead, follow = self.leader, self.follower
        if not len(lead):
            return
        amiss = ends[follow] - ends[lead] - self.offset[int(coming), follow]
        size = np.hypot(*amiss.T)
        amiss *= (np.minimum(size, MAX_END_CORRECTION) / np.maximum(size, 1e-9) * ~self._meeting[follow])[:, None]
        ends[lead] += 0.5 * amiss
        ends[follow] -= 0.5 * amiss


def _held_hands(arrangement: int, hands: str) -> tuple[tuple[int, int], ...]:
    """Return the hands that partners of a manner hold."""
    if arrangement == ALONE or hands == "none":
        return ()
    return _HANDS[arrangement] if hands == "both" else _HANDS[arrangement][:1]


CLOSING_S: Final = 0.6
"""Time in which approaching partners should meet, if their speed allows [s]."""
RATE: Final = 1.0
"""Largest speed at which each end of a rod is moved to restore its length [m/s]."""
FIRM_THRESHOLD: Final = 0.5
"""From this firmness on, the leader's command counts for both."""


class PairSteering:
    """Advances agents as `Advance` does, with the two agents of a pair as the ends of a rod."""

    def __init__(self, advance: CrowdStepper, partners: Partners) -> None:
        self._advance, self._partners = advance, partners

    def resize(self, half_width: float, half_depth: float) -> None:
        """Set the stage's half sizes [m]."""
        self._advance.resize(half_width, half_depth)

    def steer(self, steering: Steering) -> None:
        """Set the steering parameters. The stage's size stays."""
        self._advance.set_steering(steering)

    def yield_to(self, rows: npt.NDArray[np.integer], responsibility: npt.NDArray[np.floating]) -> None:
        """Set the share of avoidance, (n,), that the agents `rows` (n,) take."""
        self._advance.set_responsibility(rows, responsibility)

    def __call__(
        self,
        current: AgentState,
        out: AgentState,
        *,
        commands: AgentCommand,
        surroundings: Surroundings,
        time: float,
        dt: float,
    ) -> None:
        """Read `current` and write `out`, `dt` [s] later. `commands` is changed to common commands for each pair."""
        if len(self._partners.leader):
            self._share_commands(commands, current)
        self._advance(current, out, commands=commands, surroundings=surroundings, time=time, dt=dt)
        if len(self._partners.leader):
            self._restore_rods(out, dt)

    def _share_commands(self, commands: AgentCommand, state: AgentState) -> None:
        """Give both agents of a pair the same command. Partners who are still apart approach each other."""
        lead, follow, arm = self._partners.leader, self._partners.follower, self._partners.arm_length
        firm = commands.firmness[lead] > FIRM_THRESHOLD
        both = 0.5 * (commands.velocity[lead] + commands.velocity[follow])
        both = np.where(firm[:, None], commands.velocity[lead], both)
        commands.firmness[follow] = commands.firmness[lead]
        commands.alignment[follow], commands.cohesion[follow] = commands.alignment[lead], commands.cohesion[lead]
        speed = np.minimum(commands.speed[lead], commands.speed[follow])
        commands.speed[lead], commands.speed[follow] = speed, speed
        between = (state.position[follow] - state.position[lead]).astype(np.float64)
        apart = np.maximum(np.hypot(*between.T), 1e-6)
        far = np.where(apart - arm > APPROACH_DISTANCE, apart - arm, 0.0)
        close = between * (np.minimum(0.5 * far / CLOSING_S, speed) / apart)[:, None]
        commands.velocity[lead] = both + close
        commands.velocity[follow] = both - close
        for rows in (lead, follow):  # separation must not push partners apart
            commands.separation[rows] = np.minimum(commands.separation[rows], arm)

    def _restore_rods(self, state: AgentState, dt: float) -> None:
        """Restore the rod's length, and equalize the velocities of its ends along it."""
        lead, follow, arm = self._partners.leader, self._partners.follower, self._partners.arm_length
        between = (state.position[follow] - state.position[lead]).astype(np.float64)
        apart = np.maximum(np.hypot(*between.T), 1e-6)
        way = between / apart[:, None]
        amiss = apart - arm
        held = amiss <= APPROACH_DISTANCE
        move = np.where(held, np.clip(0.5 * amiss, -RATE * dt, RATE * dt), 0.0)[:, None] * way
        state.position[lead] += move
        state.position[follow] -= move
        along = ((state.velocity[follow] - state.velocity[lead]) * way).sum(axis=1)
        change = np.where(held, 0.5 * along, 0.0)[:, None] * way
        state.velocity[lead] += change
        state.velocity[follow] -= change
