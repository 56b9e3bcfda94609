"""Manual control of tempo, beat and measures: taps, tempo, half and double, hold, count-in, downbeat, nudge, shift,
metre and choice of source.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

from live.clock.follower.audio_source import AudioSource
from live.clock.follower.bar_alignment import BarAlignment
from live.clock.follower.clock_source import ObservedSource
from live.clock.follower.external_source import ExternalSource, ManualSource
from live.clock.follower.follower_status import FollowerStatus
from live.clock.follower.phase_correction import LEAP_BEATS
from live.clock.tap_tempo import TapTempo
from live.clock.timeline import METRE_MAX, METRE_MIN, TEMPO_MAX_BPM, TEMPO_MIN_BPM, Grid

Kind = Literal["tempo", "one", "scale", "metre", "forget"]


@dataclass(frozen=True, slots=True)
class TrackerHint:
    """A manual setting that is passed on to the audio tracker.

    tempo: `value` bpm, with a beat at `time` (NaN: unknown); one: a downbeat at `time`; scale: from now on
    `value` times as many beats; metre: measures have `value` beats; forget: all manual hints are void (the operator
    restarted the audio).
    """

    kind: Kind
    time: float
    """Seconds of the show."""
    value: float = 0.0


PLAUSIBLE: Final = 60.0
"""Maximum distance of an event's time from now [s]; ..."""

START_PLAUSIBLE: Final = 1e7
"""... before the first tick, maximum absolute time [s]."""


class ManualControlBase(FollowerStatus):
    """Common parts of manual control. Nothing here moves the beat: the next tick does."""

    _alignment: BarAlignment
    _audio: AudioSource
    _taps: TapTempo
    _internal: ManualSource
    _tap: ManualSource
    _downbeat_at: float | None
    _scale: float

    rejected = 0
    """Number of implausible inputs since the start."""
    refusal = ""
    """Message for the last input that the active source does not allow; `refused` counts them."""
    refused = 0
    manual_tempo: tuple[int, float] = (0, 0.0)
    """Number of manual tempo settings, and the last one [bpm]."""
    on_hint: Callable[[TrackerHint], None] | None = None
    """Callback, in the show's thread, with settings for the audio tracker."""

    def _phase_is_free(self) -> bool:
        """Whether no other source determines the phase of the beat, so that it may be set by hand."""
        ruling = self._arbiter
        if ruling.free_running or ruling.held or ruling.name == "internal":
            return True
        source = ruling.source
        if isinstance(source, ExternalSource):
            return not source.anchored
        return isinstance(source, ManualSource) and self._now >= source.priority_until

    def _place(self, grid: Grid, time: float) -> None:
        """Set the beats of sources whose phase may be set by hand."""
        source = self._arbiter.source
        self._slewed.goal = grid
        if isinstance(source, ManualSource):
            source.replace_grid(grid)
            self._arbiter.beat_offset = 0
        elif isinstance(source, ExternalSource) and not self._arbiter.free_running:
            source.set_phase(grid.beat_at(time) - self._arbiter.beat_offset, time)

    def _move_goal(self, seconds: float) -> None:
        goal, source = self._slewed.goal, self._arbiter.source
        self._slewed.goal = Grid(goal.time + seconds, goal.period, goal.number)
        grid = source.grid()
        if isinstance(source, ManualSource) and grid is not None:
            source.replace_grid(Grid(grid.time + seconds, grid.period, grid.number))

    def _apply_manual_tempo(self, source: ManualSource, grid: Grid, time: float) -> None:
        """Give a manual tempo priority over audio for some seconds."""
        source.set_grid(grid, max(time, self._now))
        self._audio.set_by_hand(grid, source.priority_until)
        if self._arbiter.held:
            self._slewed.goal = grid
        else:
            self._arbiter.activate(source.name, max(time, self._now))
            self._slewed.goal = grid

    def _manual_allowed(self, what: str) -> bool:
        """Whether taps and manual tempo are allowed now; an active clock source determines the tempo itself."""
        ruling = self._arbiter
        if ruling.held or ruling.choice in ("tap", "internal") or not ruling.exact:
            return True
        if ruling.name != "link":
            self._refuse(f"{what}: the tempo comes from {ruling.name}; choose another source first")
        return False

    def _record_tempo(self, bpm: float, time: float) -> None:
        self.manual_tempo = (self.manual_tempo[0] + 1, bpm)
        self._send_hint("tempo", time, bpm)

    def _set_line(self, beat: float, cause: str = "one") -> None:
        now = self._now if math.isfinite(self._now) else self._slewed.timeline.time_origin
        self._slewed.set_measure_line(float(beat), now, "hand" if cause == "hand" else "one")
        self._alignment.pin()

    def _begin_count(self, first: int) -> None:
        """Begin the count and the measures at the beat `first`."""
        self._set_line(first)
        self._counting.begin(first, self._slewed.timeline.beats_per_measure)
        self._send_hint("one", self._slewed.timeline.time_at(first))

    def _next_line_time(self) -> float:
        timeline = self._slewed.timeline
        left = timeline.beats_per_measure - timeline.phase_at(self._now if math.isfinite(self._now) else 0.0)
        return timeline.time_at(self._slewed.beat(self._now if math.isfinite(self._now) else 0.0) + left)

    def _send_hint(self, kind: Kind, time: float, value: float = 0.0) -> None:
        if self.on_hint is not None:
            self.on_hint(TrackerHint(kind, time, value))

    def _plausible(self, time: float) -> bool:
        """Whether a time is plausible for a present event; count it as rejected if not."""
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


class ManualTempo(ManualControlBase):
    """Manual control of the tempo."""

    def tap(self, time: float) -> None:
        """Process a tap; from the third on, taps determine tempo, phase, and which half beat is the beat."""
        if not self._plausible(time):
            return
        grid = self._taps.tap(time)
        if grid is None or not TEMPO_MIN_BPM <= grid.tempo <= TEMPO_MAX_BPM:
            return
        self._record_tempo(grid.tempo, grid.time)
        if not self._manual_allowed("taps"):
            return
        grid = grid.numbered_like(self._slewed.timeline.beat_at(time), time)
        self._apply_manual_tempo(self._tap, grid, time)
        self._audio.consensus.keep_half_beats()
        if self._counting.armed and self._taps.count >= self._slewed.timeline.beats_per_measure:
            self._begin_count(grid.number + round((time - grid.time) / grid.period) + 1)

    def set_tempo(self, bpm: float, time: float) -> None:
        """Set the tempo to `bpm` from `time` on, without a step in the beat."""
        if not self._plausible(time):
            return
        if not TEMPO_MIN_BPM <= bpm <= TEMPO_MAX_BPM:
            self.rejected += 1
            return
        now = self._now if math.isfinite(self._now) else time
        self._record_tempo(bpm, math.nan)
        if not self._manual_allowed("a tempo"):
            return
        beat = self._slewed.beat(now)
        number = math.floor(beat)
        grid = Grid(now - (beat - number) * 60.0 / bpm, 60.0 / bpm, number)
        internal = self._arbiter.name == "internal"
        self._apply_manual_tempo(self._internal if internal else self._tap, grid, now)
        self._slewed.timeline = self._slewed.timeline.with_tempo(bpm, now)

    def scale_tempo(self, factor: float, time: float) -> None:
        """Halve or double the tempo, from the next beat common to both."""
        if not self._plausible(time):
            return
        if factor not in (0.5, 2.0) or not TEMPO_MIN_BPM <= self._slewed.goal.tempo * factor <= TEMPO_MAX_BPM:
            self.rejected += 1
            return
        self._scale = 1.0 if self._scale * factor == 1.0 else factor

    def hold(self, on: bool, time: float) -> None:
        """Hold the tempo, or follow again, without a step in the beat."""
        if not self._plausible(time) or on == self._arbiter.held:
            return
        self._arbiter.held = on
        if on:
            self._slewed.freeze(self._now if math.isfinite(self._now) else time)

    def count_in(self, measures: float, time: float) -> None:
        """Count in the given number of measures: from the next beat, or after a measure of taps.

        From the next beat if its phase is known, from a source or because the tempo is held.
        """
        if not self._plausible(time) or not self._bounded(measures, 16.0):
            return
        self._counting.arm(max(round(measures), 0), time)
        if self._arbiter.held or not self._phase_is_free():
            self._begin_count(math.floor(self._slewed.beat(max(time, self._now))) + 1)


class ManualControl(ManualTempo):
    """Manual control of beat and measures."""

    def set_downbeat(self, time: float) -> None:
        """Make the beat nearest to `time` the first of a measure; if the beat is uncertain, put a beat at `time`.

        If the beats are not sure yet, measures are counted back to `time` once they are.
        """
        if not self._plausible(time):
            return
        beat = self._slewed.timeline.beat_at(time)
        number = math.floor(beat + 0.5)
        if self._phase_is_free():
            number = math.floor(beat + 1.0 - LEAP_BEATS)  # a leap goes forward
            self._place(Grid(time, self._slewed.goal.period, number), time)
            self._slewed.request_leap("one")
        self._set_line(number)
        sure = self.state not in ("internal", "following")
        self._downbeat_at = None if sure else time
        self._send_hint("one", time)

    def nudge(self, seconds: float, time: float) -> None:
        """Move the beats later by this time [s], relative to the active source."""
        if not self._plausible(time) or not self._bounded(seconds, 1.0):
            return
        self._move_goal(seconds)
        source = self._arbiter.source
        if isinstance(source, ObservedSource):
            source.nudge(seconds)

    def shift_beats(self, beats: float, time: float) -> None:
        """Move the measure lines later by this many beats; half a beat moves the beats themselves to the off-beat."""
        if not self._plausible(time) or not self._bounded(beats, 16.0):
            return
        halves = math.floor(2.0 * beats + 0.5)
        whole, half = divmod(halves, 2)
        if half:
            source = self._arbiter.source
            if isinstance(source, ObservedSource):
                source.level.shift(0.5)
            self._move_goal(0.5 * self._slewed.goal.period)
            self._slewed.request_leap("hand")
        if whole:
            self._set_line(math.floor(self._slewed.timeline.measure_origin) + whole, "hand")
            self._send_hint("one", self._next_line_time())

    def take_runner_up(self, time: float) -> None:
        """Move the measure lines to the most likely other place, which `runner_up` tells."""
        if not self._plausible(time):
            return
        later, _ = self._alignment.runner_up
        if not later:
            self._refuse("there is no other measure line to take: the music suggests none")
            return
        self.shift_beats(later, time)

    def set_metre(self, beats: float, time: float) -> None:
        """Set the beats in a measure from the next line on."""
        if not self._plausible(time) or not self._bounded(beats, METRE_MAX):
            return
        if round(beats) < METRE_MIN:
            self.rejected += 1
            return
        self._alignment.set_metre(round(beats))
        self._send_hint("metre", time, float(round(beats)))

    def select_source(self, name: str) -> None:
        """Follow this source, once it is available, from a measure line on; "auto": by priority."""
        if name != "auto" and name not in self._sources:
            self._refuse(f"no clock source is called {name!r}; there are auto, {', '.join(self._sources)}")
            return
        self._arbiter.choice = name
        self._alignment.unpin()
        if name in ("tap", "internal") and self._arbiter.name != name:
            source = self._internal if name == "internal" else self._tap
            source.replace_grid(self._slewed.goal)
