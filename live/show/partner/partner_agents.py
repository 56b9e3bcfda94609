"""Agents of answering dancers: they go to and stay at the answer's position, so that others avoid them (H024)."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import Wants
from live.agents.crowd.agent_state import AgentState
from live.show.partner.partner_response import Answering

Float32 = npt.NDArray[np.float32]

BESIDE: Final = 0.02
"""Extra distance [m] beyond both radii between the agents of follower and leader."""
CLOSING_S: Final = 0.6
"""Time [s] in which a follower would reach the answer's position if no speed limit applied."""


class AnsweringAgents:
    """Steering of the answering dancers of one show."""

    def __init__(self, radius: Float32, usual: float) -> None:
        """`radius` (A,) [m] of each agent, `usual` [m] of most agents."""
        self._radius, self._usual = radius, usual
        self._answering: Answering | None = None

    def go_along(self, answering: Answering | None, shown: Float32, state: AgentState) -> None:
        """Place the agent of each answering dancer where the dancer is `shown` (A, 2) [m], but far enough from the
        leader's agent that the leader does not avoid it."""
        self._answering = answering
        if answering is None or not answering.along.following.any():
            return
        radius = self._radius
        for pair in answering.pairs:
            lead, follow = pair.leader, pair.follower
            if not answering.along.following[follow]:
                continue
            between = (shown[follow] - state.position[lead]).astype(np.float64)
            apart = max(float(np.hypot(*between)), 1e-6)
            least = float(radius[lead] + radius[follow]) + BESIDE
            state.position[follow] = state.position[lead] + between * (max(apart, least) / apart)
            state.velocity[follow] = state.velocity[lead]

    def ask(self, wants: Wants, state: AgentState) -> None:
        """Steer seeking dancers to their answer, and reduce separation between leaders and followers."""
        answering = self._answering
        if answering is None:
            return
        near = answering.along.led | answering.along.following
        wants.separation[near] = np.minimum(wants.separation[near], 2.0 * self._usual + BESIDE)
        for row in np.flatnonzero(answering.along.seeks).tolist():
            way = answering.along.goal[row] - state.position[row]
            size = max(float(np.hypot(*way)), 1e-6)
            wants.velocity[row] = way * (min(size / CLOSING_S, float(wants.speed[row])) / size)
            wants.alignment[row] = wants.cohesion[row] = wants.firm[row] = 0.0
