"""TimelineFollower: what all sources and hands say in, one Timeline out that never goes back and never stands still."""

import math
from collections.abc import Sequence
from typing import Final

from live.clock.follower.audio_source import AudioSource
from live.clock.follower.bar_alignment import Measures
from live.clock.follower.clock_source import HeardSource, Said, Source
from live.clock.follower.count_in import CountingIn
from live.clock.follower.external_source import DirectSource, HandSource
from live.clock.follower.manual_control import HandControls
from live.clock.follower.phase_correction import SLEW_LOCKED, SLEW_UNLOCKED, Run
from live.clock.follower.source_arbiter import PRIORITY, Ruling
from live.clock.tap_tempo import TapTempo
from live.clock.timeline import Grid, Timeline

__all__ = ["SLEW_LOCKED", "SLEW_UNLOCKED", "TimelineFollower"]

ONE_WITHIN: Final = 30.0
"""How long before or after the known first downbeat [s] a first lock may count measures to it."""

FADE: Final = 8.0
"""Seconds in which confidence falls to 1/e while nothing is heard."""

NEAR: Final = 0.1
FAR: Final = 0.25
"""A lock is reported from when the Timeline is so near to the source's beat until it is so far from it [beats]."""


class TimelineFollower(HandControls):
    """Runs a Timeline after what is heard and tapped; pure: all times [s] are given, none is read.

    Sources: link, midi, mtc, audio (heard), tap, internal. One rules; the Timeline runs after its beats by going up to
    12 % (20 % while not locked) faster or slower. Only a jump that is announced (`jumps`, `last_jump`) moves the beat
    otherwise: forward, by less than a beat. Whatever is not finite, or absurd, is counted in `rejected` and changes
    nothing.
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

        `known_tempo` [bpm] is what the music's score says: it is run from the start and settles the octave.
        `priority`: sources by rank, those left out are never followed; `tempo_range` [bpm]: into it slower or faster
        sources are doubled or halved; `follow_metre`: a source may change how many beats a measure has.
        """
        begin = 0.0 if one_at is None else one_at
        timeline = Timeline(
            tempo=tempo if known_tempo is None else known_tempo, time_origin=begin, beats_per_measure=beats_per_measure
        )
        grid = Grid(begin, 60.0 / timeline.tempo)
        self._audio = AudioSource(grid, known_tempo)
        self._internal, self._tap = HandSource("internal", grid), HandSource("tap")
        direct = {name: DirectSource(name) for name in ("link", "midi", "mtc")}
        self._sources: dict[str, Source] = {
            **direct, "audio": self._audio, "tap": self._tap, "internal": self._internal,
        }  # fmt: skip
        self._run = Run(timeline, grid)
        self._measures = Measures(follow_metre=follow_metre)
        self._ruling = Ruling(self._sources, self._run, self._measures, priority=priority, tempo_range=tempo_range)
        self._taps, self._counting = TapTempo(), CountingIn()
        self._one_at = one_at
        self._now = -math.inf
        self._scale = 1.0
        self._locked = False
        self._share = 0.0

    # -- what is heard -----------------------------------------------------------------------------------------

    def heard(
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
    ) -> None:
        """A source's statement, received at `now`: a beat at `beat_time`, `period` [s] to the next; see BeatHeard."""
        said = Said(beat_time, period, confidence, beat, beats_per_measure, measure, jump, anchored)
        heard = self._sources.get(source)
        if not isinstance(heard, HeardSource) or not said.plausible(now) or not self._plausible(now):
            self.rejected += 1
            return
        heard.heard(said, max(now, self._now))

    def silent(self, time: float, source: str = "audio") -> None:
        """Nothing is played any more: the tempo is kept, the beats run on."""
        self._changed(time, source, "silent")

    def paused(self, time: float, source: str = "audio") -> None:
        """Nothing is to be heard for longer than usual: the beats run on alone, what was heard stays believed."""
        self._changed(time, source, "paused")

    def lost(self, time: float, source: str = "audio") -> None:
        """The source went away: as in silence."""
        self._changed(time, source, "lost")

    def found(self, time: float, source: str = "audio") -> None:
        """There is something to hear again: what comes now is judged afresh, the beats run on until it is sure."""
        self._changed(time, source, "found")

    def _changed(self, time: float, source: str, what: str) -> None:
        heard = self._sources.get(source)
        if not isinstance(heard, HeardSource):
            self.rejected += 1
        elif self._plausible(time):
            getattr(heard, what)(time)
            self._ruling.update(self._now if math.isfinite(self._now) else time, crossed=False)

    # -- time --------------------------------------------------------------------------------------------------

    def advance(self, now: float) -> Timeline:
        """The timeline from `now` [s] on; called each tick. A time before the last one changes nothing."""
        if not math.isfinite(now) or now < self._now:
            return self.timeline
        last, self._now = self._now, now
        run, before = self._run, self.timeline
        for source in self._sources.values():
            source.watch(now)
        crossed = math.isfinite(last) and before.measure_at(now) != before.measure_at(last)
        if crossed:
            self._measures.cross(run, now)
        self._scale_at_beat(last, now)
        self._ruling.update(now, crossed=crossed)
        self._judge(now, now - last if math.isfinite(last) else 0.0)
        if self._counting.watch(run.beat(now), now):
            run.announce_one(now)
        run.to(now, slew=SLEW_LOCKED if self.state == "locked" else SLEW_UNLOCKED, exact=self._ruling.exact)
        return run.timeline

    def _judge(self, now: float, elapsed: float) -> None:
        """Whether the Timeline is where the source is, and how sure that is."""
        source = self._ruling.source
        if self._ruling.free:
            self._share *= math.exp(-elapsed / FADE)
            self._locked = False
            return
        self._share = source.confidence if isinstance(source, HeardSource) else 0.0 + (self.source == "tap")
        error = abs(self._run.error(now))
        was = self._locked
        self._locked = source.state == "locked" and error < (FAR if was else NEAR) and isinstance(source, HeardSource)
        if self._locked and not was:
            self._count_from_one(now)

    def _count_from_one(self, now: float) -> None:
        """At the first lock: the measures begin where the music's known first downbeat was."""
        if self._one_at is None:
            return
        if abs(now - self._one_at) <= ONE_WITHIN:
            self._run.count_from(self._one_at, now)
            self._measures.pin()
        self._one_at = None

    def _scale_at_beat(self, last: float, now: float) -> None:
        """Half or double tempo comes with a beat that both have; where beats fall away, with an even one."""
        if self._scale == 1.0 or not math.isfinite(last):
            return
        run, beat = self._run, math.floor(self._run.beat(now))
        into = round(beat - run.timeline.measure_origin) % run.timeline.beats_per_measure
        if beat == math.floor(run.beat(last)) or (self._scale < 1.0 and into % 2):
            return
        factor, self._scale = self._scale, 1.0
        source, goal = self._ruling.source, run.goal
        if isinstance(source, HeardSource) and not source.level.scale(factor, float(beat - self._ruling.shift)):
            self.rejected += 1
            return
        scaled = Grid(goal.time + (beat - goal.number) * goal.period, goal.period / factor, beat)
        if isinstance(source, HandSource):
            source.keep(scaled)
            self._ruling.shift = 0
        run.goal = scaled
        run.line(float(beat - round(into * factor)), now, "hand")
        self._measures.pin()
        self._seed("scale", now, factor)
