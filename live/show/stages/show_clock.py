"""Musical time of a show: the timeline follows the music, and the measures follow the timeline."""

from collections.abc import Callable
from typing import Final

from live.base.arrays import Float32
from live.base.errors import PersonError
from live.clock.follower.manual_control import TrackerHint
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from live.control.events import events
from live.control.events.event import ControlEvent
from live.show.circuit_breakers import FALLBACK, CircuitBreakers, Stage
from live.show.sound.clock_commands import CLOCK_EVENTS, apply_clock_event, initial_seeds
from live.show.stages.measure_span import MeasureSpan
from live.show.stages.now import Now

SHORTEST_RETIME: Final = 0.5
"""Minimum remaining length of a re-timed measure [beats]."""
JUMP_TOLERANCE: Final = 1e-6
"""The clock has jumped if its beat differs by more than this from the last tick's Timeline [beats]."""


class ShowClock:
    """Timeline and current measure of a show; stages CLOCK and MEASURE."""

    EVENTS = (*CLOCK_EVENTS, events.TicksSkipped)

    def __init__(
        self,
        follower: TimelineFollower,
        breakers: CircuitBreakers,
        *,
        measure_beats: int,
        follow_metre: bool,
        known_tempo: float | None,
    ) -> None:
        """`measure_beats`: beats of a danced measure, as in the patch. A beat tracker need not find the metre unless
        `follow_metre`, nor the tempo if `known_tempo` [bpm] is that of the patch's own music."""
        self.follower = follower
        self.timeline = follower.timeline
        self.span = MeasureSpan.at(self.timeline, self.timeline.beat_at(0.0))
        """The current measure."""
        self.time = 0.0
        """Time of the last tick [s]."""
        self.measure_beats = measure_beats
        self.beat, self._beats_per_tick = self.timeline.beat_at(0.0), self.timeline.tempo * TICK / 60.0
        """Beat of the last tick. It runs on at its tempo while the clock is out of service."""
        self._breakers = breakers
        self._follow_metre, self._known_tempo = follow_metre, known_tempo

    def seed_tracker(self, listener: Callable[[TrackerHint], None]) -> None:
        """Send beat tracker seeds to `listener`, now and in future."""
        for seed in initial_seeds(self.follower, follow_metre=self._follow_metre, known_tempo=self._known_tempo):
            listener(seed)
        self.follower.on_hint = listener

    @property
    def danced_beats(self) -> float:
        """Beats danced so far: (measure number + fraction) times beats per measure; unit of `beat_scheduler` too."""
        return self.span.danced_beats(self.timeline.beat_at(self.time), self.measure_beats)

    def now(self, position: Float32) -> Now:
        """Return the present, with agents at `position` (A, 2) [m]."""
        return Now(self.time, self.timeline, self.span, self.measure_beats, position)

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Handle an event for the clock; raises PersonError if the follower refuses it."""
        if isinstance(event, events.TicksSkipped):
            self.time += event.count * TICK
            return
        words = apply_clock_event(self.follower, event)
        if words:
            raise PersonError(words)

    def advance(self, time: float) -> None:
        """Advance to the tick at `time` [s], and re-time the current measure if needed."""
        level, leapt, beat = self._breakers.enter(Stage.CLOCK), False, self.beat + self._beats_per_tick
        if not level:
            expected = self.timeline.beat_at(time)
            self.timeline = self.follower.advance(time)
            beat = self.timeline.beat_at(time)
            leapt = abs(beat - expected) > JUMP_TOLERANCE
        elif level == FALLBACK:
            beat = self.timeline.beat_at(time)
        if self._breakers.closed(Stage.MEASURE):
            if leapt:
                self.span.jump(self.timeline, expected, beat, shortest=SHORTEST_RETIME)
            self.span.follow(self.timeline, beat, shortest=SHORTEST_RETIME)
        self.beat, self._beats_per_tick = beat, self.timeline.tempo * TICK / 60.0

    def begin_measure(self) -> None:
        """Begin the next measure."""
        if self._breakers.closed(Stage.MEASURE):
            self.span = self.span.next(self.timeline)
        else:
            self._begin_regular_measure()

    def stand(self) -> bool:
        """Run a tick in which nothing moves; True if a measure line was crossed, as measures are still counted."""
        self.beat += self._beats_per_tick
        crossed = self.beat >= self.span.end
        if crossed:
            self._begin_regular_measure()
        return crossed

    def _begin_regular_measure(self) -> None:
        """Begin a measure of the patch's length."""
        end, beats = self.span.end, self.measure_beats
        self.span = MeasureSpan(self.span.number + 1, end, end + beats, beats)

    def fraction(self) -> float:
        """Return the fraction of the measure at the tick."""
        if self._breakers.closed(Stage.MEASURE):
            return self.span.fraction(self.beat)
        return min(max(1.0 - (self.span.end - self.beat) / self.measure_beats, 0.0), 1.0)
