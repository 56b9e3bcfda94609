"""HandControls: a musician's hand on the beat and the measure: the one, nudge, shift, metre, and who is followed.

Seed: what the hand says that a tracker of sound should know, too.

HandReach: what all that a musician's hand does needs: who may say what, and where it is put.

HandTempo: a musician's hand on the tempo: taps, a number, half and double, hold, count-in.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

from live.clock.follower.audio_source import AudioSource
from live.clock.follower.bar_alignment import METRE_MAX, METRE_MIN, Measures
from live.clock.follower.clock_source import HeardSource
from live.clock.follower.external_source import DirectSource, HandSource
from live.clock.follower.follower_status import Seen
from live.clock.follower.phase_correction import LEAP_BEATS
from live.clock.tap_tempo import TapTempo
from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM, Grid

Kind = Literal["tempo", "one", "scale", "metre", "forget"]


@dataclass(frozen=True, slots=True)
class Seed:
    """One hint, for whoever tracks the sound.

    tempo: `value` bpm, with a beat at `time` (NaN: nobody says where); one: a downbeat at `time`; scale: from now on
    `value` times as many beats; metre: measures have `value` beats; forget: the hand's hints are void (the operator
    restarted the sound).
    """

    kind: Kind
    time: float
    """Seconds of the show."""
    value: float = 0.0


PLAUSIBLE: Final = 60.0
"""An event's time lies at most this far from now [s]; ..."""

START_PLAUSIBLE: Final = 1e7
"""... before the first tick it is at most this [s]."""


class HandReach(Seen):
    """What hands reach of the follower. Nothing here moves the beat: that is for the next tick."""

    _measures: Measures
    _audio: AudioSource
    _taps: TapTempo
    _internal: HandSource
    _tap: HandSource
    _one_at: float | None
    _scale: float

    rejected = 0
    """Inputs refused because they cannot be true, since the start."""
    refusal = ""
    """The last thing asked for that the source in force does not allow, in words; the number of them: `refused`."""
    refused = 0
    hand_tempo: tuple[int, float] = (0, 0.0)
    """How often the hand has said a tempo, and the last one [bpm]."""
    on_seed: Callable[[Seed], None] | None = None
    """Told, in the show's thread, what a tracker of sound should know."""

    def _unsure(self) -> bool:
        """Whether nobody else knows where the beat is, so that a hand may say."""
        ruling = self._ruling
        if ruling.free or ruling.held or ruling.name == "internal":
            return True
        source = ruling.source
        if isinstance(source, DirectSource):
            return not source.anchored
        return isinstance(source, HandSource) and self._now >= source.rules_until

    def _place(self, grid: Grid, time: float) -> None:
        """These are the beats, where the hand may say."""
        source = self._ruling.source
        self._run.goal = grid
        if isinstance(source, HandSource):
            source.keep(grid)
            self._ruling.shift = 0
        elif isinstance(source, DirectSource) and not self._ruling.free:
            source.lean(grid.beat_at(time) - self._ruling.shift, time)

    def _move_goal(self, seconds: float) -> None:
        goal, source = self._run.goal, self._ruling.source
        self._run.goal = Grid(goal.time + seconds, goal.period, goal.number)
        grid = source.grid()
        if isinstance(source, HandSource) and grid is not None:
            source.keep(Grid(grid.time + seconds, grid.period, grid.number))

    def _by_hand(self, source: HandSource, grid: Grid, time: float) -> None:
        """A tempo by hand rules for some seconds, whoever was heard."""
        source.take(grid, max(time, self._now))
        self._audio.take(grid, source.rules_until)
        if self._ruling.held:
            self._run.goal = grid
        else:
            self._ruling.take(source.name, max(time, self._now))
            self._run.goal = grid

    def _hand_may(self, what: str) -> bool:
        """Whether taps and tempo by hand may rule now; a clock that rules says the tempo itself."""
        ruling = self._ruling
        if ruling.held or ruling.choice in ("tap", "internal") or not ruling.exact:
            return True
        if ruling.name != "link":
            self._refuse(f"{what}: the tempo comes from {ruling.name}; choose another source first")
        return False

    def _say_tempo(self, bpm: float, time: float) -> None:
        self.hand_tempo = (self.hand_tempo[0] + 1, bpm)
        self._seed("tempo", time, bpm)

    def _set_line(self, beat: float, cause: str = "one") -> None:
        now = self._now if math.isfinite(self._now) else self._run.timeline.time_origin
        self._run.line(float(beat), now, "hand" if cause == "hand" else "one")
        self._measures.pin()

    def _count(self, first: int) -> None:
        """The count begins with the beat `first`, and so do the measures."""
        self._set_line(first)
        self._counting.begin(first, self._run.timeline.beats_per_measure)
        self._seed("one", self._run.timeline.time_at(first))

    def _next_line_time(self) -> float:
        timeline = self._run.timeline
        left = timeline.beats_per_measure - timeline.phase_at(self._now if math.isfinite(self._now) else 0.0)
        return timeline.time_at(self._run.beat(self._now if math.isfinite(self._now) else 0.0) + left)

    def _seed(self, kind: Kind, time: float, value: float = 0.0) -> None:
        if self.on_seed is not None:
            self.on_seed(Seed(kind, time, value))

    def _plausible(self, time: float) -> bool:
        """Whether a time may be that of an event of now; counts it as rejected if not."""
        good = abs(time - self._now) <= PLAUSIBLE if math.isfinite(self._now) else abs(time) <= START_PLAUSIBLE
        self.rejected += not good
        return good

    def _bounded(self, value: float, most: float) -> bool:
        good = abs(value) <= most  # false for NaN, too
        self.rejected += not good
        return good

    def _refuse(self, words: str) -> None:
        self.refused += 1
        self.refusal = words


class HandTempo(HandReach):
    """How fast."""

    def tap(self, time: float) -> None:
        """A tap; from the third on tempo and phase are the taps', and which half beat is the beat stays theirs."""
        if not self._plausible(time):
            return
        grid = self._taps.tap(time)
        if grid is None or not TEMPO_MIN_BPM <= grid.tempo <= TEMPO_MAX_BPM:
            return
        self._say_tempo(grid.tempo, grid.time)
        if not self._hand_may("taps"):
            return
        grid = grid.numbered_like(self._run.timeline.beat_at(time), time)
        self._by_hand(self._tap, grid, time)
        self._audio.consensus.keep_half_beats()
        if self._counting.armed and self._taps.count >= self._run.timeline.beats_per_measure:
            self._count(grid.number + round((time - grid.time) / grid.period) + 1)

    def set_tempo(self, bpm: float, time: float) -> None:
        """Run at `bpm` from `time` on, with no step in the beat."""
        if not self._plausible(time):
            return
        if not TEMPO_MIN_BPM <= bpm <= TEMPO_MAX_BPM:
            self.rejected += 1
            return
        now = self._now if math.isfinite(self._now) else time
        self._say_tempo(bpm, math.nan)
        if not self._hand_may("a tempo"):
            return
        beat = self._run.beat(now)
        number = math.floor(beat)
        grid = Grid(now - (beat - number) * 60.0 / bpm, 60.0 / bpm, number)
        internal = self._ruling.name == "internal"
        self._by_hand(self._internal if internal else self._tap, grid, now)
        self._run.timeline = self._run.timeline.with_tempo(bpm, now)

    def scale_tempo(self, factor: float, time: float) -> None:
        """Half or double tempo, from the next beat that both have."""
        if not self._plausible(time):
            return
        if factor not in (0.5, 2.0) or not TEMPO_MIN_BPM <= self._run.goal.tempo * factor <= TEMPO_MAX_BPM:
            self.rejected += 1
            return
        self._scale = 1.0 if self._scale * factor == 1.0 else factor

    def hold(self, on: bool, time: float) -> None:
        """Freeze the tempo, or follow again; the beat does not notice."""
        if not self._plausible(time) or on == self._ruling.held:
            return
        self._ruling.held = on
        if on:
            self._run.freeze(self._now if math.isfinite(self._now) else time)

    def count_in(self, measures: float, time: float) -> None:
        """So many measures are counted, then comes the one: from the next beat, or after a measure of taps.

        From the next beat where somebody knows it: a source, or the hand that holds it.
        """
        if not self._plausible(time) or not self._bounded(measures, 16.0):
            return
        self._counting.arm(max(round(measures), 0), time)
        if self._ruling.held or not self._unsure():
            self._count(math.floor(self._run.beat(max(time, self._now))) + 1)


class HandControls(HandTempo):
    """Where the beat is."""

    def one(self, time: float) -> None:
        """The beat nearest to `time` is the first of a measure; where nobody is sure of the beat, `time` is the beat.

        Said before the beats are sure, it is counted back to when they are.
        """
        if not self._plausible(time):
            return
        beat = self._run.timeline.beat_at(time)
        number = math.floor(beat + 0.5)
        if self._unsure():
            number = math.floor(beat + 1.0 - LEAP_BEATS)  # a leap goes forward
            self._place(Grid(time, self._run.goal.period, number), time)
            self._run.leap_soon("one")
        self._set_line(number)
        sure = self.state not in ("internal", "following")
        self._one_at = None if sure else time
        self._seed("one", time)

    def nudge(self, seconds: float, time: float) -> None:
        """The beats are so much later [s], against what the source in force says."""
        if not self._plausible(time) or not self._bounded(seconds, 1.0):
            return
        self._move_goal(seconds)
        source = self._ruling.source
        if isinstance(source, HeardSource):
            source.nudge(seconds)

    def shift_beats(self, beats: float, time: float) -> None:
        """The measure lines are so many beats later; half a beat moves the beats themselves to the off-beat."""
        if not self._plausible(time) or not self._bounded(beats, 16.0):
            return
        halves = math.floor(2.0 * beats + 0.5)
        whole, half = divmod(halves, 2)
        if half:
            source = self._ruling.source
            if isinstance(source, HeardSource):
                source.level.shift(0.5)
            self._move_goal(0.5 * self._run.goal.period)
            self._run.leap_soon("hand")
        if whole:
            self._set_line(math.floor(self._run.timeline.measure_origin) + whole, "hand")
            self._seed("one", self._next_line_time())

    def set_metre(self, beats: float, time: float) -> None:
        """Measures of so many beats from the next line on."""
        if not self._plausible(time) or not self._bounded(beats, METRE_MAX):
            return
        if round(beats) < METRE_MIN:
            self.rejected += 1
            return
        self._measures.set_metre(round(beats))
        self._seed("metre", time, float(round(beats)))

    def choose(self, name: str) -> None:
        """Follow this source, once it is there, from a measure line on; "auto": by priority."""
        if name != "auto" and name not in self._sources:
            self._refuse(f"no clock source is called {name!r}; there are auto, {', '.join(self._sources)}")
            return
        self._ruling.choice = name
        self._measures.unpin()
        if name in ("tap", "internal") and self._ruling.name != name:
            source = self._internal if name == "internal" else self._tap
            source.keep(self._run.goal)
