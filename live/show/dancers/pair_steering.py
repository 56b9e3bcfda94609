"""Pair steering: the agents of partners advance as the two ends of a rod, on the stage and in the look-ahead."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import Wants
from live.agents.crowd.agent_state import AgentState, Steering
from live.agents.crowd.crowd_step import Advance
from live.agents.crowd.obstacles import Surroundings
from live.show.dancers.partners import MEET, Partners

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
