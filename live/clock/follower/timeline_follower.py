"""Timeline follower: combines all sources and manual control into one timeline that never stops or goes back."""

import math
from collections.abc import Sequence
from typing import Final

from live.clock.follower.audio_source import AudioSource
from live.clock.follower.bar_alignment import BarAlignment
from live.clock.follower.clock_source import PRIORITY, BeatObservation, ObservedSource, Source
from live.clock.follower.count_in import CountIn
from live.clock.follower.external_source import ExternalSource, ManualSource
from live.clock.follower.manual_control import ManualControl
from live.clock.follower.phase_correction import SLEW_LOCKED, SLEW_UNLOCKED, SlewedTimeline
from live.clock.follower.source_arbiter import SourceArbiter
from live.clock.tap_tempo import TapTempo
from live.clock.timeline import Grid, Timeline

ONE_WITHIN: Final = 30.0
"""Maximum distance of the first lock from the known first downbeat [s] for measures to be counted from it."""

FADE: Final = 8.0
"""Time constant of the confidence while there is no input [s]."""

NEAR: Final = 0.1
FAR: Final = 0.25
"""A lock begins when the timeline is this near to the source's beat, and ends when it is this far from it [beats]."""


class TimelineFollower(ManualControl):
    """Follows audio, clocks and taps with a Timeline; pure: all times [s] are given.

    One source of `PRIORITY` is active; the timeline approaches its beats by running up to
    12 % (20 % while not locked) faster or slower. Only an announced jump (`jumps`, `last_jump`) moves the beat
    otherwise: forward, by less than a beat. Input that is not finite, or implausible, is counted in `rejected` and
    changes nothing.
    """

    def __init__(
        self,
        *,
        tempo: float = 120.0,
        beats_per_measure: int = 4,
        one_at: float | None = None,
        known_tempo: float | None = None,
        priority: Sequence[str] = PRIORITY,
        tempo_range: tuple[float, float] = (20.0, 400.0),
        follow_metre: bool = False,
    ) -> None:
        """Start on the internal clock at `tempo` [bpm], with a downbeat at `one_at` [s] (0 if not given).

        `known_tempo` [bpm], from the music's score, is used from the start and settles the octave.
        `priority`: sources by rank, those left out are never followed; `tempo_range` [bpm]: slower or faster sources
        are
        doubled or halved into it; `follow_metre`: a source may change the number of beats in a measure.
        """
        begin = 0.0 if one_at is None else one_at
        timeline = Timeline(
            tempo=tempo if known_tempo is None else known_tempo, time_origin=begin, beats_per_measure=beats_per_measure
        )
        grid = Grid(begin, 60.0 / timeline.tempo)
        self._audio = AudioSource(grid, known_tempo)
        self._internal, self._tap = ManualSource("internal", grid), ManualSource("tap")
        own: dict[str, Source] = {"audio": self._audio, "tap": self._tap, "internal": self._internal}
        self._sources: dict[str, Source] = {name: own.get(name) or ExternalSource(name) for name in PRIORITY}
        self._slewed = SlewedTimeline(timeline, grid)
        self._alignment = BarAlignment(follow_metre=follow_metre)
        self._arbiter = SourceArbiter(
            self._sources, self._slewed, self._alignment, priority=priority, tempo_range=tempo_range
        )
        self._taps, self._counting = TapTempo(), CountIn()
        self._downbeat_at = one_at
        self._now = -math.inf
        self._scale = 1.0
        self._locked = False
        self._confidence = 0.0

    # -- sources -------------------------------------------------------------------------------------------------

    def observe(
        self,
        beat_time: float,
        period: float,
        confidence: float,
        now: float,
        *,
        source: str = "audio",
        beat: int = -1,
        beats_per_measure: int = 0,
        measure: int = -1,
        jump: bool = False,
        anchored: bool = True,
        runner_up: int = 0,
        runner_up_share: float = 0.0,
    ) -> None:
        """Process a source's observation, received at `now`: a beat at `beat_time`, `period` [s] to the next; see
        BeatHeard."""
        said = BeatObservation(
            beat_time, period, confidence, beat, beats_per_measure, measure, jump, anchored, runner_up, runner_up_share
        )
        heard = self._sources.get(source)
        if not isinstance(heard, ObservedSource) or not said.plausible(now) or not self._plausible(now):
            self.rejected += 1
            return
        heard.observe(said, max(now, self._now))

    def silent(self, time: float, source: str = "audio") -> None:
        """Handle silence: the tempo is kept, the beats continue. What was set by hand holds until other music comes."""
        self._changed(time, source, "silent")
        if source == self._arbiter.name and self._plausible(time):
            self._alignment.end_song()

    def paused(self, time: float, source: str = "audio") -> None:
        """Handle a pause longer than usual: the beats continue, earlier observations stay valid."""
        self._changed(time, source, "paused")

    def lost(self, time: float, source: str = "audio") -> None:
        """Handle the loss of a source: as silence."""
        self._changed(time, source, "lost")

    def found(self, time: float, source: str = "audio") -> None:
        """Handle the return of sound: the beats continue until the new ones are sure."""
        self._changed(time, source, "found")

    def _changed(self, time: float, source: str, what: str) -> None:
        heard = self._sources.get(source)
        if not isinstance(heard, ObservedSource):
            self.rejected += 1
        elif self._plausible(time):
            getattr(heard, what)(time)
            self._arbiter.update(self._now if math.isfinite(self._now) else time, crossed=False)

    # -- time --------------------------------------------------------------------------------------------------

    def advance(self, now: float) -> Timeline:
        """Return the timeline from `now` [s] on; called each tick. A time before the last one changes nothing."""
        if not math.isfinite(now) or now < self._now:
            return self.timeline
        last, self._now = self._now, now
        run, before = self._slewed, self.timeline
        for source in self._sources.values():
            source.check_timeout(now)
        crossed = math.isfinite(last) and before.measure_at(now) != before.measure_at(last)
        if crossed:
            self._alignment.apply_pending_metre(run, now)
        self._scale_at_beat(last, now)
        self._arbiter.update(now, crossed=crossed)
        self._update_lock(now, now - last if math.isfinite(last) else 0.0)
        if self._counting.update(run.beat(now), now):
            run.announce_one(now)
        run.follow_goal(now, slew=SLEW_LOCKED if self.state == "locked" else SLEW_UNLOCKED, exact=self._arbiter.exact)
        return run.timeline

    def _update_lock(self, now: float, elapsed: float) -> None:
        """Update lock and confidence: whether the timeline is where the source is."""
        source = self._arbiter.source
        if self._arbiter.free_running:
            self._confidence *= math.exp(-elapsed / FADE)
            self._locked = False
            return
        self._confidence = source.confidence if isinstance(source, ObservedSource) else 0.0 + (self.source == "tap")
        error = abs(self._slewed.error(now))
        was = self._locked
        self._locked = (
            source.state == "locked" and error < (FAR if was else NEAR) and isinstance(source, ObservedSource)
        )
        if self._locked and not was:
            self._count_from_one(now)

    def _count_from_one(self, now: float) -> None:
        """At the first lock, count the measures from the music's known first downbeat."""
        if self._downbeat_at is None:
            return
        if abs(now - self._downbeat_at) <= ONE_WITHIN:
            self._slewed.count_from(self._downbeat_at, now)
            self._alignment.pin()
        self._downbeat_at = None

    def _scale_at_beat(self, last: float, now: float) -> None:
        """Apply half or double tempo at a beat common to both; if beats are dropped, at an even one."""
        if self._scale == 1.0 or not math.isfinite(last):
            return
        run, beat = self._slewed, math.floor(self._slewed.beat(now))
        into = round(beat - run.timeline.measure_origin) % run.timeline.beats_per_measure
        if beat == math.floor(run.beat(last)) or (self._scale < 1.0 and into % 2):
            return
        factor, self._scale = self._scale, 1.0
        source, goal = self._arbiter.source, run.goal
        if isinstance(source, ObservedSource) and not source.level.scale(
            factor, float(beat - self._arbiter.beat_offset)
        ):
            self.rejected += 1
            return
        scaled = Grid(goal.time + (beat - goal.number) * goal.period, goal.period / factor, beat)
        if isinstance(source, ManualSource):
            source.replace_grid(scaled)
            self._arbiter.beat_offset = 0
        run.goal = scaled
        run.set_measure_line(float(beat - round(into * factor)), now, "hand")
        self._alignment.pin()
        self._send_hint("scale", now, factor)
