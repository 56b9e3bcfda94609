"""Show: the deterministic core. Events and ticks in, states and views out; it reads no clock, device or disk.

The same patch, library, seed and (tick, event) list give bit-identical states, live or replayed.

Acting: an event that cannot act, for an error of this program, is refused by everybody in the same way.

The engine that dances, the one that goes on after it, a machine that stands by and a replay all come to the same state:
what the event had done before the error stays done, the same everywhere, and the show goes on.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.base.scalar_kernels import damper
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.clock.timeline import Moment
from live.control.events.event import ControlEvent
from live.show.circuit_breakers import SIMPLER, Stage
from live.show.dancers.current_measure import Dancing
from live.show.dispatch import Dispatch
from live.show.measure_span import MeasureSpan
from live.show.selection.nearest_steps import repeat_measure
from live.show.selection.scheduler import DECIDE_BEATS

FADE_HALFLIFE = 0.06
"""Half-life of a blackout's fade [s]: dark within a fifth of a second, without a flash."""
SHORTEST_RETIME = 0.5
"""A measure is never re-timed to end within fewer beats than this."""
LEAP = 1e-6
"""The clock's beat has jumped if it is so far [beats] from where the last tick's Timeline takes it."""
CALLS_IN_TURN = 4
"""A signal may call what gives a signal ... so many times in one tick; the rest waits for the next."""
LINES_PER_TICK = 4
"""Measure lines crossed in one tick at most, should the tempo ever run away."""


class Show(Dispatch):
    """One show. Call `apply` for events, then `tick` for each due tick, and `fill` for each frame.

    A tick is a row of stages. Each asks its breaker first: what a stage does that is out of service, and what others
    need of it, is worked out from what is at hand, so that the show goes on whichever fails.
    """

    def tick(self, time: float) -> bool:
        """Advance to the tick at `time` [s]; True if a measure line was crossed.

        Where it ends in an error the state is of no use any more; `breakers.running` says in which stage that was.
        """
        self.time = time
        crossed = self._tick(time) if self.breakers.closed(Stage.TICK) else self._stand(time)
        self.breakers.leave()
        return crossed

    def _tick(self, time: float) -> bool:
        closed = self.breakers.closed
        beat = self._advance_clock(time)
        crossed = self._cross_lines(beat, time)
        if closed(Stage.DESK):
            self.desk.tick(self.timeline)
        if closed(Stage.AUDIENCE):
            self.audience.tick()
        self._fire()
        self._take_edit(time)
        self._select(beat, time)
        if closed(Stage.INTERRUPTS):
            self.interrupts.tick(self.span, self.timeline, time)
        self._move(self._fraction(beat), time)
        level = self.breakers.level(Stage.LIGHT)
        goal = 0.0 if self.blackout else 1.0
        self.brightness = goal if level else damper(self.brightness, goal, FADE_HALFLIFE, TICK)
        return crossed

    def _move(self, fraction: float, time: float) -> None:
        """Agents and dancers, at `fraction` of the measure."""
        closed, carrying = self.breakers.closed, self.scheduler.carrying
        if closed(Stage.STEERING):
            speed, dancer = self.scheduler.speed, carrying.reference
            self.motion.tick(time, self.timeline, self.span, speed=speed, dancer=dancer, pace=carrying.pace)
        if closed(Stage.PARTNERS):
            self.motion.go_along(self.dancers.answering, self.dancers.shown)
        if closed(Stage.CORRECTION):
            carrying.tick(fraction, self.timeline.tempo / (60.0 * self.timeline.beats_per_measure))
        if closed(Stage.DANCERS):
            self.dancers.tick(fraction, time, TICK)
        if closed(Stage.CAPTURE):
            self.mocap.tick(time, self.danced, self.timeline, self.span.end)
        if closed(Stage.PARTNERS):
            self._answer(fraction, time)
            partners = self.motion.partners
            if len(partners.leader) or self.dancers.hands.held:
                self.dancers.hands.tick(partners.other, partners.hand, TICK, self.timeline.tempo)

    # -- the clock and its lines -----------------------------------------------------------------------------------

    def _advance_clock(self, time: float) -> float:
        """The beat at `time` [s]; the measure that is danced follows a clock that has moved."""
        level, leapt = self.breakers.level(Stage.CLOCK), False
        if not level:
            expected = self.timeline.beat_at(time)
            self.timeline = self.follower.advance(time)
            beat = self.timeline.beat_at(time)
            leapt = abs(beat - expected) > LEAP
        else:
            beat = self.timeline.beat_at(time) if level == SIMPLER else self._beat + self._beats_per_tick
        if self.breakers.closed(Stage.MEASURE):
            if leapt:
                self.span.leap(self.timeline, expected, beat, shortest=SHORTEST_RETIME)
            self.span.follow(self.timeline, beat, shortest=SHORTEST_RETIME)
        self._beat, self._beats_per_tick = beat, self.timeline.tempo * TICK / 60.0
        return beat

    def _fraction(self, beat: float) -> float:
        """How far the measure is at `beat`."""
        if self.breakers.closed(Stage.MEASURE):
            return self.span.fraction(beat)
        return min(max(1.0 - (self.span.end - beat) / self.patch.clock.beats_per_measure, 0.0), 1.0)

    def _cross_lines(self, beat: float, time: float) -> bool:
        crossed = False
        for _ in range(LINES_PER_TICK):
            if beat < self.span.end:
                break
            self._fire((self.span.number + 1) * self.patch.clock.beats_per_measure)
            self._cross_measure_line(time)
            crossed = True
        return crossed

    def _stand(self, time: float) -> bool:
        """A tick in which nobody moves; measures are counted all the same."""
        self._beat += self._beats_per_tick
        crossed = self._beat >= self.span.end
        if crossed:
            self.span = self._next_plain()
            self._drop_begun()
        return crossed

    def _next_plain(self) -> MeasureSpan:
        """A measure as long as all, after this one."""
        end, beats = self.span.end, self.patch.clock.beats_per_measure
        return MeasureSpan(self.span.number + 1, end, end + beats, beats)

    def _cross_measure_line(self, time: float) -> None:
        closed = self.breakers.closed
        if not self.dancers.decided:
            self._decide(time)
        line = self.span.end
        if closed(Stage.CORRECTION):
            self.scheduler.carrying.cross_measure_line()
        if closed(Stage.DANCERS):
            self.dancers.cross_measure_line()
        elif self.dancers.decided:
            Dancing.cross_measure_line(self.dancers)
        if closed(Stage.EDITS):
            self._take_graph()
            self._take_patch()
        self._drop_begun()
        self.span = self.span.next(self.timeline) if closed(Stage.MEASURE) else self._next_plain()
        self._begin_measure(line)
        if closed(Stage.REACTIONS):
            self._give(self.reactions.cross_measure_line(time))
        if closed(Stage.DESK):
            self._give(self.desk.begin_measure(self.danced))
        if closed(Stage.AUDIENCE):
            self._give(self.audience.begin_measure(self.span.number, time))

    def _begin_measure(self, beat: float) -> None:
        closed, number = self.breakers.closed, self.span.number
        if closed(Stage.SCORE):
            self.prompter.begin_measure(number, self.time)
        if closed(Stage.PARTNERS) and self.dancers.answering is not None:
            self.dancers.answering.begin_measure()
        if closed(Stage.DESK):
            self._controls.cross_measure_line(number)
        if closed(Stage.VARIATION):
            self.variation.begin_measure(number)
            timing = self.motion.partners.timing()
            self.variation.delay(timing, self.state.position, self.motion.present, self.dancers.present)
        if closed(Stage.SELECTION):
            self.scheduler.set_speed(number, self.timeline)
        entered = self._enter(beat) if closed(Stage.STEERING) else np.zeros(0, np.intp)
        if closed(Stage.CORRECTION):
            self.scheduler.carrying.begin_measure(anew=bool(len(entered)))

    def _enter(self, beat: float) -> npt.NDArray[np.intp]:
        """Who comes onto the stage with the measure that begins at `beat`."""
        heading = self.dancers.present.begin_heading()
        try:
            entered = self.motion.begin_measure(self.span, beat, self.timeline, heading)
        except PersonError as error:  # a score that asks for the impossible in measure 200 stops no show
            self.refusals.add(f"score: {error}")
            return np.zeros(0, np.intp)
        if len(entered):
            place = self.state.position[entered].astype(np.float64)
            way = self.motion.entrances.goal[entered] - place
            self.dancers.place(entered, place, np.arctan2(way[:, 0], way[:, 1]))
        return entered

    # -- what the show itself does ---------------------------------------------------------------------------------

    def _fire(self, line: float | None = None) -> None:
        """What waits for a danced beat up to `line` (None: that of now) happens, and what that calls at once."""
        for _ in range(CALLS_IN_TURN):
            due: list[ControlEvent] = []
            if self.breakers.closed(Stage.SCORE):
                due += self.prompter.agenda.fire(self.danced if line is None else line)
            if self.breakers.closed(Stage.DESK):
                due += self.desk.fire(self.danced if line is None else line, self.time)
            if not due:
                return
            self._give(due)

    def _give(self, calls: Iterable[ControlEvent]) -> None:
        """Let events act that the show gives itself."""
        for event in calls:
            if self.breakers.calls(type(event).__name__):
                self._act_on(event)

    def _take_edit(self, time: float) -> None:
        if not self.breakers.closed(Stage.EDITS):
            return
        if self.reloading.due(self.span.number) and self.scheduler.plan_anew(self.span, self.timeline, time):
            self._take_patch()

    def _select(self, beat: float, time: float) -> None:
        """This tick's share of choosing what comes next."""
        level = self.breakers.level(Stage.SELECTION)
        if not level:
            self.scheduler.work(self.span, self.timeline, time)
        elif level == SIMPLER and not self.dancers.decided and self.span.end - beat <= DECIDE_BEATS:
            self.scheduler.decide_nearest(self.motion.floor.half)

    def _decide(self, time: float) -> None:
        """The line is here, and nobody's next measure is chosen."""
        level = self.breakers.level(Stage.SELECTION)
        if not level:
            self.scheduler.decide(self.span, self.timeline, time)
        elif level == SIMPLER:
            self.scheduler.decide_nearest(self.motion.floor.half)
        else:
            repeat_measure(self.dancers)

    def _answer(self, fraction: float, time: float) -> None:
        """Who answers others is taken along; what she dances is told whoever reacts to it."""
        answering, state = self.dancers.answering, self.state
        if answering is None:
            return
        moved = self.dancers.answer(self.motion.staying, (state.position, state.velocity), fraction, time, TICK)
        rows = np.flatnonzero(moved.any(axis=1))
        if len(rows):
            self.scheduler.carrying.take_along(rows, moved[rows])
        for label in answering.leaders.take_fresh():
            self.reactions.unit(label)
            self.prompter.take_reactions(self.danced, time)

    def moment(self, time: float) -> Moment:
        """Musical time at `time` [s]."""
        return Moment.of(self.timeline, time, self.follower.confidence)

    def why(self) -> dict[str, Any] | None:
        """Why the dancer somebody asked about dances what she dances, see `Choices.why`; None for nobody."""
        asked = self.directions.asked
        return None if asked is None else self.scheduler.choices.why(asked, self.scheduler.choosing)

    # -- what is seen ------------------------------------------------------------------------------------------

    def view(self) -> StageView:
        """An empty drawing snapshot of the right size, to be filled each frame."""
        return self._seen.view()

    def fill(self, view: StageView, time: float) -> None:
        """Fill the snapshot for `time` [s]: poses at the exact beat, at most a tick after the last one."""
        tempo, brightness = self.follower.tempo, self.brightness * self.desk.master.level
        self._seen.fill(view, time, self.timeline, self.span, tempo=tempo, brightness=brightness, ticked=self.time)

    def state_hash(self) -> str:
        """A short hash over every bit of the agents' and dancers' states and the poses of this tick."""
        brightness = self.brightness * self.desk.master.level
        return self._seen.state_hash(self.time, self.timeline, self.span, brightness=brightness)


def act(show: Show, event: ControlEvent) -> bool | None:
    """Let an event act, from the next tick on; False if it asked for what is not there, None if it failed."""
    try:
        return show.apply(event)
    except Exception as error:  # whatever it is: one event less, and not a show less
        show.refusals.add(f"{type(event).__name__} failed: {type(error).__name__}: {error}")
        return None
