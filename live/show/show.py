"""Show: the deterministic simulation core. It reads no clock, device or disk.

The same patch, library, seed and (tick, event) list give bit-identical states, live or replayed. An event that raises
is refused the same way by engine, warm standby, second machine and replay: its effects before the error remain, so all
reach the same state and the show continues.
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
from live.show.circuit_breakers import FALLBACK, Stage
from live.show.dancers.current_measure import CurrentMeasures
from live.show.dispatch import EventDispatcher
from live.show.measure_span import MeasureSpan
from live.show.selection.nearest_steps import repeat_measure
from live.show.selection.scheduler import DECIDE_BEATS

FADE_HALFLIFE = 0.06
"""Half-life of a blackout's fade [s]: dark within 0.2 s, without a flash."""
SHORTEST_RETIME = 0.5
"""Minimum remaining length of a re-timed measure [beats]."""
JUMP_TOLERANCE = 1e-6
"""The clock has jumped if its beat differs by more than this from the last tick's Timeline [beats]."""
MAX_CALL_DEPTH = 4
"""Maximum depth of signals that trigger signals in one tick; the rest waits for the next tick."""
MAX_LINES_PER_TICK = 4
"""Maximum number of measure lines crossed in one tick, in case the tempo runs away."""


class Show(EventDispatcher):
    """One show. Call `apply` for events, then `tick` for each due tick, and `fill` for each frame.

    A tick is a sequence of stages. Each stage first checks its circuit breaker. If it is tripped, a fallback computes
    what later stages need, so the show continues whichever stage fails.
    """

    def tick(self, time: float) -> bool:
        """Advance to the tick at `time` [s]; True if a measure line was crossed.

        After an exception the state is unusable; `breakers.running` is the stage that failed.
        """
        self.time = time
        crossed = self._tick(time) if self.breakers.closed(Stage.TICK) else self._tick_still(time)
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
        self._apply_edit(time)
        self._select(beat, time)
        if closed(Stage.INTERRUPTS):
            self.interrupts.tick(self.span, self.timeline, time)
        self._move(self._fraction(beat), time)
        level = self.breakers.enter(Stage.LIGHT)
        goal = 0.0 if self.blackout else 1.0
        self.brightness = goal if level else damper(self.brightness, goal, FADE_HALFLIFE, TICK)
        return crossed

    def _move(self, fraction: float, time: float) -> None:
        """Advance agents and dancers to `fraction` of the measure."""
        closed, carrying = self.breakers.closed, self.scheduler.root_correction
        if closed(Stage.STEERING):
            speed, dancer = self.scheduler.speed, carrying.reference
            self.motion.tick(
                time,
                self.timeline,
                self.span,
                speed=speed,
                reference=dancer,
                reference_velocity=carrying.reference_velocity,
            )
        if closed(Stage.PARTNERS):
            self.motion.follow_partner_response(self.dancers.partner_response, self.dancers.drawn_hips)
        if closed(Stage.CORRECTION):
            carrying.tick(fraction, self.timeline.tempo / (60.0 * self.timeline.beats_per_measure))
        if closed(Stage.DANCERS):
            self.dancers.tick(fraction, time, TICK)
        if closed(Stage.CAPTURE):
            self.mocap.tick(time, self.danced_beats, self.timeline, self.span.end)
        if closed(Stage.PARTNERS):
            self._advance_responses(fraction, time)
            partners = self.motion.partners
            if len(partners.leader) or self.dancers.hands.active:
                self.dancers.hands.tick(partners.other, partners.hand, TICK, self.timeline.tempo)

    # -- clock and measure lines -----------------------------------------------------------------------------------

    def _advance_clock(self, time: float) -> float:
        """Advance the clock to `time` [s], re-time the current measure if needed, and return the beat."""
        level, leapt = self.breakers.enter(Stage.CLOCK), False
        if not level:
            expected = self.timeline.beat_at(time)
            self.timeline = self.follower.advance(time)
            beat = self.timeline.beat_at(time)
            leapt = abs(beat - expected) > JUMP_TOLERANCE
        else:
            beat = self.timeline.beat_at(time) if level == FALLBACK else self._beat + self._beats_per_tick
        if self.breakers.closed(Stage.MEASURE):
            if leapt:
                self.span.jump(self.timeline, expected, beat, shortest=SHORTEST_RETIME)
            self.span.follow(self.timeline, beat, shortest=SHORTEST_RETIME)
        self._beat, self._beats_per_tick = beat, self.timeline.tempo * TICK / 60.0
        return beat

    def _fraction(self, beat: float) -> float:
        """Return the fraction of the measure at `beat`."""
        if self.breakers.closed(Stage.MEASURE):
            return self.span.fraction(beat)
        return min(max(1.0 - (self.span.end - beat) / self.patch.clock.beats_per_measure, 0.0), 1.0)

    def _cross_lines(self, beat: float, time: float) -> bool:
        crossed = False
        for _ in range(MAX_LINES_PER_TICK):
            if beat < self.span.end:
                break
            self._fire((self.span.number + 1) * self.patch.clock.beats_per_measure)
            self._cross_measure_line(time)
            crossed = True
        return crossed

    def _tick_still(self, time: float) -> bool:
        """Run a tick without motion; measures are still counted."""
        self._beat += self._beats_per_tick
        crossed = self._beat >= self.span.end
        if crossed:
            self.span = self._next_regular()
            self._drop_unfinished()
        return crossed

    def _next_regular(self) -> MeasureSpan:
        """Return the next measure, of the patch's length."""
        end, beats = self.span.end, self.patch.clock.beats_per_measure
        return MeasureSpan(self.span.number + 1, end, end + beats, beats)

    def _cross_measure_line(self, time: float) -> None:
        closed = self.breakers.closed
        if not self.dancers.decided:
            self._decide(time)
        line = self.span.end
        if closed(Stage.CORRECTION):
            self.scheduler.root_correction.cross_measure_line()
        if closed(Stage.DANCERS):
            self.dancers.cross_measure_line()
        elif self.dancers.decided:
            CurrentMeasures.cross_measure_line(self.dancers)
        if closed(Stage.EDITS):
            self._apply_graph()
            self._apply_patch()
        self._drop_unfinished()
        self.span = self.span.next(self.timeline) if closed(Stage.MEASURE) else self._next_regular()
        self._begin_measure(line)
        if closed(Stage.REACTIONS):
            self._issue(self.reactions.cross_measure_line(time))
        if closed(Stage.DESK):
            self._issue(self.desk.begin_measure(self.danced_beats))
        if closed(Stage.AUDIENCE):
            self._issue(self.audience.begin_measure(self.span.number, time))

    def _begin_measure(self, beat: float) -> None:
        closed, number = self.breakers.closed, self.span.number
        if closed(Stage.SCORE):
            self.score_runner.begin_measure(number, self.time)
        if closed(Stage.PARTNERS) and self.dancers.partner_response is not None:
            self.dancers.partner_response.begin_measure()
        if closed(Stage.DESK):
            self._controls.cross_measure_line(number)
        if closed(Stage.VARIATION):
            self.variation.begin_measure(number)
            timing = self.motion.partners.timing_source()
            self.variation.update_delays(timing, self.state.position, self.motion.present, self.dancers.present)
        if closed(Stage.SELECTION):
            self.scheduler.set_speed(number, self.timeline)
        entered = self._enter(beat) if closed(Stage.STEERING) else np.zeros(0, np.intp)
        if closed(Stage.CORRECTION):
            self.scheduler.root_correction.begin_measure(displaced=bool(len(entered)))

    def _enter(self, beat: float) -> npt.NDArray[np.intp]:
        """Begin the motion of the measure at `beat`; return the dancers that enter the stage."""
        heading = self.dancers.present.begin_heading()
        try:
            entered = self.motion.begin_measure(self.span, beat, self.timeline, heading)
        except PersonError as error:  # an impossible entry late in a score must not stop the show
            self.refusals.add(f"score: {error}")
            return np.zeros(0, np.intp)
        if len(entered):
            place = self.state.position[entered].astype(np.float64)
            way = self.motion.entrances.goal[entered] - place
            self.dancers.place(entered, place, np.arctan2(way[:, 0], way[:, 1]))
        return entered

    # -- events issued by the show itself --------------------------------------------------------------------------

    def _fire(self, line: float | None = None) -> None:
        """Apply everything scheduled up to the danced beat `line` (None: now), and what that triggers at once."""
        for _ in range(MAX_CALL_DEPTH):
            due: list[ControlEvent] = []
            if self.breakers.closed(Stage.SCORE):
                due += self.score_runner.beat_scheduler.fire(self.danced_beats if line is None else line)
            if self.breakers.closed(Stage.DESK):
                due += self.desk.fire(self.danced_beats if line is None else line, self.time)
            if not due:
                return
            self._issue(due)

    def _issue(self, calls: Iterable[ControlEvent]) -> None:
        """Apply events that the show issues itself."""
        for event in calls:
            if self.breakers.may_issue(type(event).__name__):
                self._handle(event)

    def _apply_edit(self, time: float) -> None:
        if not self.breakers.closed(Stage.EDITS):
            return
        if self.patch_updates.is_due(self.span.number) and self.scheduler.replan(self.span, self.timeline, time):
            self._apply_patch()

    def _select(self, beat: float, time: float) -> None:
        """Do this tick's share of the step selection."""
        level = self.breakers.enter(Stage.SELECTION)
        if not level:
            self.scheduler.work(self.span, self.timeline, time)
        elif level == FALLBACK and not self.dancers.decided and self.span.end - beat <= DECIDE_BEATS:
            self.scheduler.decide_nearest(self.motion.stage_area.half)

    def _decide(self, time: float) -> None:
        """Choose all next measures at once, because the measure line is reached."""
        level = self.breakers.enter(Stage.SELECTION)
        if not level:
            self.scheduler.decide(self.span, self.timeline, time)
        elif level == FALLBACK:
            self.scheduler.decide_nearest(self.motion.stage_area.half)
        else:
            repeat_measure(self.dancers)

    def _advance_responses(self, fraction: float, time: float) -> None:
        """Advance the partner response, move the agents of followers, and pass new units to the reactions."""
        answering, state = self.dancers.partner_response, self.state
        if answering is None:
            return
        moved = self.dancers.tick_partner_response(
            self.motion.on_stage, (state.position, state.velocity), fraction, time, TICK
        )
        rows = np.flatnonzero(moved.any(axis=1))
        if len(rows):
            self.scheduler.root_correction.displace(rows, moved[rows])
        for label in answering.leaders.pop_new_labels():
            self.reactions.handle_unit(label)
            self.score_runner.schedule_reactions(self.danced_beats, time)

    def moment(self, time: float) -> Moment:
        """Return the musical time at `time` [s]."""
        return Moment.of(self.timeline, time, self.follower.confidence)

    def explain_choice(self) -> dict[str, Any] | None:
        """Explain the selected dancer's current step, see `StepChoices.why`; None if no dancer is selected."""
        asked = self.directions.explained_dancer
        return None if asked is None else self.scheduler.choices.explain(asked, self.scheduler.choosing)

    # -- drawing snapshot --------------------------------------------------------------------------------------

    def view(self) -> StageView:
        """Return an empty drawing snapshot of the right size, to be filled each frame."""
        return self._view_builder.view()

    def fill(self, view: StageView, time: float) -> None:
        """Fill the snapshot for `time` [s], at most a tick after the last one; poses are at the exact beat."""
        tempo, brightness = self.follower.tempo, self.brightness * self.desk.master.level
        self._view_builder.fill(
            view, time, self.timeline, self.span, tempo=tempo, brightness=brightness, last_tick=self.time
        )

    def state_hash(self) -> str:
        """Return a short hash over every bit of the agents' and dancers' states and the poses of this tick."""
        brightness = self.brightness * self.desk.master.level
        return self._view_builder.state_hash(self.time, self.timeline, self.span, brightness=brightness)


def apply_safely(show: Show, event: ControlEvent) -> bool | None:
    """Apply an event, effective from the next tick; False if it was refused, None if it raised."""
    try:
        return show.apply(event)
    except Exception as error:  # one failed event must not end the show
        show.refusals.add(f"{type(event).__name__} failed: {type(error).__name__}: {error}")
        return None
