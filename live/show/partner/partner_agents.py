"""Agents of answering dancers: they go to and stay at the answer's position, so that others avoid them (H024)."""

from typing import TYPE_CHECKING, Final

import numpy as np

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentState
from live.base.arrays import Float32

if TYPE_CHECKING:
    from live.show.partner.partner_response import PartnerResponse


FOLLOWER_GAP: Final = 0.02
"""Extra distance [m] beyond both radii between the agents of follower and leader."""
CLOSING_S: Final = 0.6
"""Time [s] in which a follower would reach the answer's position if no speed limit applied."""


class PartnerAgents:
    """Steering of the answering dancers of one show."""

    def __init__(self, radius: Float32, default_radius: float) -> None:
        """`radius` (A,) [m] of each agent, `default_radius` [m] of most agents."""
        self._radius, self._default_radius = radius, default_radius
        self._partner_response: PartnerResponse | None = None

    def follow_partner_response(
        self, partner_response: "PartnerResponse | None", shown: Float32, state: AgentState
    ) -> None:
        """Place the agent of each answering dancer where the dancer is `shown` (A, 2) [m], but far enough from the
        leader's agent that the leader does not avoid it."""
        self._partner_response = partner_response
        if partner_response is None or not partner_response.path.following.any():
            return
        radius = self._radius
        for pair in partner_response.pairs:
            lead, follow = pair.leader, pair.follower
            if not partner_response.path.following[follow]:
                continue
            between = (shown[follow] - state.position[lead]).astype(np.float64)
            apart = max(float(np.hypot(*between)), 1e-6)
            least = float(radius[lead] + radius[follow]) + FOLLOWER_GAP
            state.position[follow] = state.position[lead] + between * (max(apart, least) / apart)
            state.velocity[follow] = state.velocity[lead]

    def set_commands(self, commands: AgentCommand, state: AgentState) -> None:
        """Steer seeking dancers to their answer, and reduce separation of leaders and of those who follow or seek."""
        answering = self._partner_response
        if answering is None:
            return
        path = answering.path
        near = path.leading | path.following | path.seeking  # who seeks is soon as near as who follows
        commands.separation[near] = np.minimum(commands.separation[near], 2.0 * self._default_radius + FOLLOWER_GAP)
        for row in np.flatnonzero(answering.path.seeking).tolist():
            way = answering.path.goal[row] - state.position[row]
            size = max(float(np.hypot(*way)), 1e-6)
            commands.velocity[row] = way * (min(size / CLOSING_S, float(commands.speed[row])) / size)
            commands.alignment[row] = commands.cohesion[row] = commands.firmness[row] = 0.0
