"""Show: the deterministic core. Events and ticks in, states and views out; it reads no clock, device or disk.

The same patch, library, seed and (tick, event) list give bit-identical states, live or replayed.
"""

from typing import Any

import numpy as np

from live.base.errors import PersonError
from live.base.kernels import damper
from live.base.stage_view import StageView
from live.clock.moment import Moment
from live.clock.ticks import TICK
from live.show.dispatch import Dispatch

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
    """One show. Call `apply` for events, then `tick` for each due tick, and `fill` for each frame."""

    def tick(self, time: float) -> bool:
        """Advance to the tick at `time` [s]; True if a measure line was crossed."""
        self.time = time
        expected = self.timeline.beat_at(time)
        self.timeline = self.follower.advance(time)
        beat = self.timeline.beat_at(time)
        if abs(beat - expected) > LEAP:
            self.span.leap(self.timeline, expected, beat, shortest=SHORTEST_RETIME)
        self.span.follow(self.timeline, beat, shortest=SHORTEST_RETIME)
        crossed = False
        for _ in range(LINES_PER_TICK):
            if beat < self.span.end:
                break
            self._fire((self.span.number + 1) * self.patch.clock.beats_per_measure)
            self._cross_measure_line(time)
            crossed = True
        self.desk.tick(self.timeline)
        self.audience.tick()
        self._fire(self.danced)
        if self.reloading.due(self.span.number) and self.scheduler.plan_anew(self.span, self.timeline, time):
            self._take_patch()
        self.scheduler.work(self.span, self.timeline, time)
        self.interrupts.tick(self.span, self.timeline, time)
        carrying, fraction = self.scheduler.carrying, self.span.fraction(beat)
        speed, dancer = self.scheduler.speed, carrying.reference
        self.motion.tick(time, self.timeline, self.span, speed=speed, dancer=dancer, pace=carrying.pace)
        self.motion.go_along(self.dancers.answering, self.dancers.shown)
        carrying.tick(fraction, self.timeline.tempo / (60.0 * self.timeline.beats_per_measure))
        self.dancers.tick(fraction, time, TICK)
        self.mocap.tick(time, self.danced, self.timeline, self.span.end)
        self._answer(fraction, time)
        partners = self.motion.partners
        if len(partners.leader) or self.dancers.hands.held:
            self.dancers.hands.tick(partners.other, partners.hand, TICK, self.timeline.tempo)
        self.brightness = damper(self.brightness, 0.0 if self.blackout else 1.0, FADE_HALFLIFE, TICK)
        return crossed

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

    def _fire(self, danced: float) -> None:
        """What waits for a beat up to `danced` happens, and what that calls at once."""
        for _ in range(CALLS_IN_TURN):
            due = [*self.prompter.agenda.fire(danced), *self.desk.fire(danced, self.time)]
            for event in due:
                self._act_on(event)
            if not due:
                return

    def _cross_measure_line(self, time: float) -> None:
        if not self.dancers.decided:
            self.scheduler.decide(self.span, self.timeline, time)
        line = self.span.end
        self.scheduler.carrying.cross_measure_line()
        self.dancers.cross_measure_line()
        self._take_graph()
        self._take_patch()
        self.span = self.span.next(self.timeline)
        self._begin_measure(line)
        for change in (*self.reactions.cross_measure_line(time), *self.desk.begin_measure(self.danced)):
            self._act_on(change)
        for change in self.audience.begin_measure(self.span.number, time):
            self._act_on(change)

    def _begin_measure(self, beat: float) -> None:
        self.prompter.begin_measure(self.span.number, self.time)
        if self.dancers.answering is not None:
            self.dancers.answering.begin_measure()
        self._controls.cross_measure_line(self.span.number)
        self.variation.begin_measure(self.span.number)
        timing = self.motion.partners.timing()
        self.variation.delay(timing, self.state.position, self.motion.present, self.dancers.present)
        self.scheduler.set_speed(self.span.number, self.timeline)
        heading = self.dancers.present.begin_heading()
        try:
            entered = self.motion.begin_measure(self.span, beat, self.timeline, heading)
        except PersonError as error:  # a score that asks for the impossible in measure 200 stops no show
            self.refusals.add(f"score: {error}")
            entered = np.zeros(0, np.intp)
        if len(entered):
            place = self.state.position[entered].astype(np.float64)
            way = self.motion.entrances.goal[entered] - place
            self.dancers.place(entered, place, np.arctan2(way[:, 0], way[:, 1]))
        self.scheduler.carrying.begin_measure(anew=bool(len(entered)))

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
