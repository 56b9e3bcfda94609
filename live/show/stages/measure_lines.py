"""Crossing of measure lines: the measure ends, graph and patch may be exchanged, the next measure begins."""

from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.dancers.current_measure import CurrentMeasures
from live.show.desk.refusals import Refusals
from live.show.stages.calls import Calls
from live.show.stages.show_clock import ShowClock
from live.show.stages.tripped_stages import TrippedStages

if TYPE_CHECKING:
    from live.show.audience.audience import Audience
    from live.show.dancers.dancers import Dancers
    from live.show.dancers.variation import Variation
    from live.show.desk.light_desk import LightDesk
    from live.show.group.group_commands import GroupCommands
    from live.show.group.group_motion import GroupMotion
    from live.show.score.music_reactions import Reactions
    from live.show.score.score_runner import ScoreRunner
    from live.show.selection.scheduler import Scheduler
    from live.show.stages.hot_swap import HotSwap
    from live.show.stages.step_selection import StepSelection

MAX_LINES_PER_TICK: Final = 4
"""Maximum number of measure lines crossed in one tick, in case the tempo runs away."""


class MeasureBegin:
    """The beginning of a measure in all parts of one show. Thread: the show's."""

    def __init__(
        self,
        breakers: CircuitBreakers,
        clock: ShowClock,
        refusals: Refusals,
        *,
        score_runner: "ScoreRunner",
        dancers: "Dancers",
        commands: "GroupCommands",
        variation: "Variation",
        scheduler: "Scheduler",
        motion: "GroupMotion",
    ) -> None:
        self._breakers, self._clock, self._refusals = breakers, clock, refusals
        self._score_runner, self._dancers, self._commands = score_runner, dancers, commands
        self._variation, self._scheduler, self._motion = variation, scheduler, motion

    def begin(self, beat: float) -> None:
        """Begin the present measure at `beat`."""
        closed, number, timeline = self._breakers.closed, self._clock.span.number, self._clock.timeline
        if closed(Stage.SCORE):
            self._score_runner.begin_measure(number, self._clock.time)
        if closed(Stage.PARTNERS) and self._dancers.partner_response is not None:
            self._dancers.partner_response.begin_measure()
        if closed(Stage.DESK):
            self._commands.cross_measure_line(number)
        if closed(Stage.VARIATION):
            self._variation.begin_measure(number)
            timing = self._motion.partners.timing_source()
            self._variation.update_delays(
                timing, self._motion.state.position, self._motion.present, self._dancers.present
            )
        if closed(Stage.SELECTION):
            self._scheduler.set_speed(number, timeline)
        entered = self._enter(beat) if closed(Stage.STEERING) else np.zeros(0, np.intp)
        if closed(Stage.CORRECTION):
            self._scheduler.root_correction.begin_measure(displaced=bool(len(entered)))

    def _enter(self, beat: float) -> npt.NDArray[np.intp]:
        """Begin the group's motion at `beat`; return the dancers that enter the stage."""
        motion, heading = self._motion, self._dancers.present.begin_heading()
        try:
            entered = motion.begin_measure(self._clock.span, beat, self._clock.timeline, heading)
        except PersonError as error:  # an impossible entry late in a score must not stop the show
            self._refusals.add(f"score: {error}")
            return np.zeros(0, np.intp)
        if len(entered):
            place = motion.state.position[entered].astype(np.float64)
            way = motion.entrances.goal[entered] - place
            self._dancers.place(entered, place, np.arctan2(way[:, 0], way[:, 1]))
        return entered


class MeasureLines:
    """The measure lines of one show. Thread: the show's."""

    def __init__(
        self,
        breakers: CircuitBreakers,
        clock: ShowClock,
        calls: Calls,
        measure_begin: MeasureBegin,
        tripped: TrippedStages,
        *,
        selection: "StepSelection",
        scheduler: "Scheduler",
        dancers: "Dancers",
        motion: "GroupMotion",
        hot_swap: "HotSwap",
        reactions: "Reactions",
        desk: "LightDesk",
        audience: "Audience",
    ) -> None:
        self._breakers, self._clock, self._calls, self._tripped = breakers, clock, calls, tripped
        self._measure_begin, self._selection, self._scheduler = measure_begin, selection, scheduler
        self._dancers, self._motion, self._hot_swap = dancers, motion, hot_swap
        self._reactions, self._desk, self._audience = reactions, desk, audience

    def cross(self) -> bool:
        """Cross the lines that the tick has reached; True if there is one."""
        clock, crossed = self._clock, False
        for _ in range(MAX_LINES_PER_TICK):
            if clock.beat < clock.span.end:
                break
            line = (clock.span.number + 1) * clock.measure_beats
            self._calls.fire(clock.now(self._motion.state.position), line)
            self._cross()
            crossed = True
        return crossed

    def _cross(self) -> None:
        """End the present measure and begin the next one."""
        clock, closed = self._clock, self._breakers.closed
        now = clock.now(self._motion.state.position)
        if not self._dancers.decided:
            self._selection.decide(now)
        if closed(Stage.CORRECTION):
            self._scheduler.root_correction.cross_measure_line()
        if closed(Stage.DANCERS):
            self._dancers.cross_measure_line()
        elif self._dancers.decided:
            CurrentMeasures.cross_measure_line(self._dancers)
        if closed(Stage.EDITS):
            self._hot_swap.cross_measure_line(now)
        self._tripped.drop_unfinished()
        clock.begin_measure()
        self._measure_begin.begin(now.span.end)
        if closed(Stage.REACTIONS):
            self._calls.issue(self._reactions.cross_measure_line(clock.time))
        if closed(Stage.DESK):
            self._calls.issue(self._desk.begin_measure(clock.now(self._motion.state.position)))
        if closed(Stage.AUDIENCE):
            self._calls.issue(self._audience.begin_measure(clock.span.number, clock.time))
