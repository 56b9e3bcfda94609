"""Root motion of answering dancers: fade of each answer, and the path it takes the dancer along.

The answer fades in and out over one measure. A follower far from the answer's position goes there first. An answering
dancer moves by a blend of the answer and the own steps, weighted by the fade.
"""

import math
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64
from live.motion.partner_live.stage_partner import LeaderReader
from live.motion.partner_live.stage_partner_kernels import heading_difference
from live.show.partner.leader_input import answer_position
from live.show.partner.partner_pairs import Pair, PartnerSettings

MIN_SEEK_DISTANCE: Final = 0.9
"""Distance [m] to the answer below which the dancer does not go there first."""
MAX_SEEK_MEASURES: Final = 3.0
"""Measures after which the answer fades in regardless of the distance."""
MAX_PULL_SPEED: Final = 0.7
"""Maximum speed [m/s] of the pull to the answer's position, in addition to the dancer's own motion."""
PULL_TIME_CONSTANT_S: Final = 0.4
"""Time constant of that pull [s]."""
FADE_HALFLIFE: Final = 0.15
"""Half-life [s] of the approach to the amount setting."""
MAX_AGENT_DISTANCE: Final = 0.12
"""Maximum distance [m] between a path-led dancer and the agent."""


class ResponsePath:
    """Fade and root motion of the answers of A dancers. Thread: the show's."""

    def __init__(self, count: int) -> None:
        self.level: Float64 = np.zeros(count)
        """Fade level of each dancer's answer, 0 to 1, linear in time, (A,)."""
        self.weight: Float64 = np.zeros(count)
        """Visible weight of the answer, (A,)."""
        self.following: Bool = np.zeros(count, np.bool_)
        """Dancers moved by an answer to a leader, (A,)."""
        self.answering: Bool = np.zeros(count, np.bool_)
        """Dancers moved by any answer, including path-led ones, (A,)."""
        self.leading: Bool = np.zeros(count, np.bool_)
        """Leaders of following dancers, (A,)."""
        self.seeking: Bool = np.zeros(count, np.bool_)
        """Dancers on their way to the answer's position `goal` (A, 2) [m], (A,)."""
        self.goal: Float64 = np.zeros((count, 2))
        self.displacement: Float64 = np.zeros((count, 2))
        """Displacement of each dancer in this tick [m], (A, 2)."""
        self.answer_position: Float64 = np.zeros((count, 2))
        """Position of the answer at the last tick [m], (A, 2)."""
        self.last_position: Float64 = np.zeros((count, 2))
        """Position of the dancer at the last tick [m], (A, 2)."""
        self.turn: Float64 = np.zeros(count)
        """Angle from the dancer's facing to the answer's [rad], (A,)."""
        self._last_target: Float64 = np.zeros((count, 2))  # target position at the last tick
        self._amount: Float64 = np.zeros(count)
        self._waited: Float64 = np.zeros(count)
        self._has_last: Bool = np.zeros(count, np.bool_)

    def begin_tick(self) -> None:
        """Clear the results of the last tick."""
        self.displacement[:] = 0.0
        for those in (self.following, self.answering, self.leading, self.seeking):
            those[:] = False

    def reset(self, row: int) -> None:
        """Forget the answer's last position of a dancer, because the answer is a new one."""
        self._has_last[row] = False

    def move_follower(
        self, pair: Pair, one: PartnerSettings, read: LeaderReader, *, wanted: bool, danced_beats: float,
        measures: float, hips: Float32, agents: Float32, dt: float,
    ) -> None:  # fmt: skip
        """Move the follower of a pair by the faded answer, which fades in while it is `wanted`.

        The leader is at the danced beat `danced_beats`; `measures` have passed since the last tick, `dt` [s] ago.
        Dancers have their `hips` at (A, 2) [m], their agents at `agents` (A, 2) [m].
        """
        row = pair.follower
        seen = answer = answer_position(read, danced_beats)
        if one.by_path:  # a path-led dancer stays near the agent, and does not overstep where it stops
            away = answer - agents[row]
            answer = agents[row] + away * min(1.0, MAX_AGENT_DISTANCE / max(float(np.hypot(*away)), 1e-9))
        if not read.has_answer or (read.held and not self.level[row]):
            return
        if not self._has_last[row] or self.level[row] == 0.0:
            self._has_last[row] = True
            self._record(row, seen, answer, hips[row])
        gap = answer - hips[row]
        far = not pair.own_place and float(np.hypot(*gap)) > MIN_SEEK_DISTANCE
        if wanted and self.level[row] == 0.0 and far and self._waited[row] < MAX_SEEK_MEASURES:
            self._waited[row] += measures
            self.seeking[row], self.goal[row] = True, answer
            self._record(row, seen, answer, hips[row])
            return
        self._waited[row] = 0.0
        level = min(max(self.level[row] + (measures if wanted else -measures), 0.0), 1.0)
        self.level[row] = level
        self._amount[row] += (1.0 - math.exp2(-dt / FADE_HALFLIFE)) * (one.amount - self._amount[row])
        if not level:
            self._amount[row] = one.amount
        share = level * level * (3.0 - 2.0 * level) * float(self._amount[row])
        self.weight[row] = share
        if share > 0.0:
            self._blend_motion(pair, one, share, answer, hips, dt)
        self._record(row, seen, answer, hips[row] + self.displacement[row])
        self.answering[row] = share > 0.0
        self.following[row] = share > 0.0 and not one.by_path
        self.leading[pair.leader] |= self.following[row]

    def _record(self, row: int, seen: Float64, answer: Float64, place: Float32 | Float64) -> None:
        self.answer_position[row], self._last_target[row], self.last_position[row] = seen, answer, place

    def _blend_motion(
        self, pair: Pair, one: PartnerSettings, share: float, answer: Float64, hips: Float32, dt: float
    ) -> None:
        """Blend the motion of the answer and of the own steps by the fade, and add the pull to the answer's
        position."""
        row = pair.follower
        own = hips[row] - self.last_position[row]
        move = share * (answer - self._last_target[row] - own)
        if not pair.own_place or one.by_path:
            gap = answer - (hips[row] + move)
            size = float(np.hypot(*gap))
            pull = share * min(size * (1.0 - math.exp(-dt / PULL_TIME_CONSTANT_S)), MAX_PULL_SPEED * dt)
            move = move + gap * (pull / max(size, 1e-9))
        self.displacement[row] = move

    def update_turn(self, row: int, rotation: Float32, answer_rotation: Float32) -> None:
        """Update the angle between the dancer's own `rotation` (4,) and the answer's hip rotation `answer_rotation`
        (4,)."""
        known = self.level[row] > 0.0
        self.turn[row] = heading_difference(rotation, answer_rotation, float(self.turn[row]) if known else 0.0)
