"""Motion of the dancers in a tick: correction, steps, captured performers, partners, faces and hands."""

from typing import TYPE_CHECKING

import numpy as np

from live.clock.ticks import TICK
from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.capture.capture_manager import CaptureManager
    from live.show.dancers.dancers import Dancers
    from live.show.dancers.expression import Expression
    from live.show.group.group_motion import GroupMotion
    from live.show.partner.partner_response import PartnerResponse
    from live.show.score.music_reactions import Reactions
    from live.show.score.score_runner import ScoreRunner
    from live.show.selection.scheduler import Scheduler


class DancersStage:
    """Stages CORRECTION, DANCERS, CAPTURE, PARTNERS and EXPRESSION of one show."""

    def __init__(
        self,
        breakers: CircuitBreakers,
        *,
        dancers: "Dancers",
        scheduler: "Scheduler",
        mocap: "CaptureManager",
        motion: "GroupMotion",
        reactions: "Reactions",
        score_runner: "ScoreRunner",
        expression: "Expression",
    ) -> None:
        self._expression = expression
        self._breakers, self._dancers, self._mocap, self._motion = breakers, dancers, mocap, motion
        self._correction = scheduler.root_correction
        self._reactions, self._score_runner = reactions, score_runner

    def tick(self, now: Now, fraction: float) -> None:
        """Advance the dancers to `fraction` of the measure."""
        closed, dancers, timeline = self._breakers.closed, self._dancers, now.timeline
        if closed(Stage.CORRECTION):
            self._correction.tick(fraction, timeline.tempo / (60.0 * timeline.beats_per_measure))
        if closed(Stage.DANCERS):
            dancers.tick(fraction, now.time, TICK)
        if closed(Stage.CAPTURE):
            self._mocap.tick(now)
        if closed(Stage.PARTNERS):
            if dancers.partner_response is not None:
                self._answer(dancers.partner_response, now, fraction)
            partners = self._motion.partners
            if len(partners.leader) or dancers.hands.active:
                dancers.hands.tick(partners.other, partners.hand, TICK, timeline.tempo)
        if closed(Stage.EXPRESSION):
            self._expression.tick(now, fraction, music=self._score_runner.mood.value("energy"))

    def _answer(self, partner_response: "PartnerResponse", now: Now, fraction: float) -> None:
        """Advance the partner response, move the agents of followers, and pass new units to the reactions."""
        state = self._motion.state
        moved = self._dancers.tick_partner_response(
            self._motion.on_stage, (state.position, state.velocity), fraction, now.time, TICK
        )
        rows = np.flatnonzero(moved.any(axis=1))
        if len(rows):
            self._correction.displace(rows, moved[rows])
        for label in partner_response.leaders.pop_new_labels():
            self._reactions.handle_unit(label)
            self._score_runner.schedule_reactions(now.danced_beats, now.time)
