"""The agents of those who answer others: where they go, and where they are, so that others avoid them (H024)."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import Wants
from live.agents.crowd.agent_state import AgentState
from live.show.partner.partner_response import Answering

Float32 = npt.NDArray[np.float32]

BESIDE: Final = 0.02
"""So much farther [m] than bodies are wide the agent of who answers stays from her leader's."""
CLOSING_S: Final = 0.6
"""Who goes to her leader would be there in this time [s], if she were fast enough."""


class AnsweringAgents:
    """Of one show; they are its own agents."""

    def __init__(self, radius: Float32, usual: float) -> None:
        """`radius` (A,) [m] of each agent, `usual` that of most [m]."""
        self._radius, self._usual = radius, usual
        self._answering: Answering | None = None

    def go_along(self, answering: Answering | None, shown: Float32, state: AgentState) -> None:
        """Who answers is where she is `shown` (A, 2) [m]; not so near to her leader that this one would avoid her."""
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
        """Who answers goes to where her answer is; nobody is pushed off by who answers her."""
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
