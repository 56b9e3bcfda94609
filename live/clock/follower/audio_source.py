"""Clock source for audio, with either kind of tracker."""

import math
from typing import Final

from live.clock.follower.clock_source import BeatObservation, Lines, ObservedSource, State
from live.clock.follower.tracker_inputs import BarPointerInput, ConsensusInput
from live.clock.timeline import Grid

NOTHING_HEARD: Final = 3.0
"""Seconds (at least three beats) without an observation after which the tempo is held."""

SAME_TEMPO: Final = 0.12
"""Tempi within this (natural logarithm) have the same metrical level."""

PATIENCE: Final = 8.0
PATIENCE_EARLY: Final = 2.0
EARLY: Final = 10.0
"""If a tracker changes only the metrical level (half or double), the follower changes it after this many seconds;
sooner
in the first seconds of a song.
"""

TRUST_MEMORY: Final = 0.2
"""Weight of the newest beat in the mean of a tracker's confidence."""
TRUST_BEATS: Final = 3
TRUST_BEGIN: Final = 0.62
TRUST_KEEP: Final = 0.4
"""A tracker is followed once the mean confidence of at least so many beats reaches the second value, until it falls
below the third. In 31 made-up crowds (talk, applause, some claps) the mean was 0.25 in the median and never above 0.61;
drums reach 0.62 at the fifth beat, chords without drums at the sixth to eleventh, and stay above 0.47.
"""

AHEAD: Final = 0.25
"""Maximum look-ahead of trackers [s]."""

ON_BEAT: Final = 0.2
"""Beats of two levels coincide within this [beats]."""

OFF_BEAT: Final = 0.17
"""Beats within this of the middle between two tracker beats are the off-beat [beats]."""


class Trust:
    """The mean confidence of a tracker's last beats."""

    def __init__(self) -> None:
        self._mean = 0.0
        self._beats = 0

    def add(self, confidence: float) -> None:
        """Add a beat."""
        self._beats += 1
        self._mean += max(TRUST_MEMORY, 1.0 / self._beats) * (confidence - self._mean)

    def holds(self, *, following: bool) -> bool:
        """Whether the tracker should be followed; less is needed while it is."""
        return self._beats >= TRUST_BEATS and self._mean >= (TRUST_KEEP if following else TRUST_BEGIN)


class AudioSource(ObservedSource):
    """Uses beats of trackers that report positions in the measure directly, and a consensus for plain beat trackers."""

    def __init__(self, grid: Grid, known_tempo: float | None = None) -> None:
        """`grid` is used until there are beats; `known_tempo` [bpm]: from the music's score."""
        super().__init__("audio")
        self.consensus = ConsensusInput(grid, known_tempo)
        self.pointer = BarPointerInput()
        self._has_pointer = False
        self._restarts = 0
        self._song_since = -math.inf
        self._kept_since = math.inf
        self._trust = Trust()
        self._before_pause: State | None = None
        self._paused_at = -math.inf
        self.manual_until = -math.inf
        """Until this time manual settings have priority, and no beats are decided [s]."""

    def raw(self) -> Grid | None:
        """The tracker's beats."""
        return self.pointer.grid if self._has_pointer else self.consensus.grid

    def own_lines(self) -> Lines | None:
        """The tracker's measures."""
        return self.pointer.lines() if self._has_pointer else None

    def observe(self, said: BeatObservation, now: float) -> None:
        """Process one estimate of the tracker."""
        if self._before_pause is not None:
            if said.time <= self._paused_at + AHEAD:  # sent before the pause was noticed
                return
            self.found(now)
        if self.silent_since is not None:
            if self.precedes_silence(said):
                return
            self.found(now)
        self.observed_at = max(self.observed_at, now)
        if said.beat >= 0 or said.beats_per_measure > 0:
            self._has_pointer = True
        if self._has_pointer:
            self._observe_pointer(said, now)
        else:
            self.consensus.observe(said, now, decide=now >= self.manual_until)
            self._update_state(self.consensus.is_confirmed, self.consensus.sure, self.consensus.share)

    def _observe_pointer(self, said: BeatObservation, now: float) -> None:
        raw_before = self.raw()
        before = None if raw_before is None else self.level.map_grid(raw_before)
        if raw_before is None:
            self._song_since = now
        self.pointer.observe(said)
        self._trust.add(said.confidence)
        raw = self.raw()
        if self.pointer.restarts != self._restarts and before is not None and raw_before is not None:
            self._restarts = self.pointer.restarts
            assert raw is not None
            self._change_tempo(raw_before, before, raw, said.time, now)
        patience = PATIENCE if now - self._song_since > EARLY else PATIENCE_EARLY
        if raw is not None and now - self._kept_since > patience:
            self._kept_since = math.inf
            self.level.scale(1.0 / self.level.factor, math.floor(self.level.map_beat(raw.beat_at(said.time)) + 0.5))
        believed = self.pointer.is_confirmed and self._trust.holds(following=self.ready)
        self._update_state(believed, self.pointer.sure, self.pointer.share)

    def _change_tempo(self, raw_before: Grid, before: Grid, raw: Grid, time: float, now: float) -> None:
        """Adopt the tracker's new tempo, unless it is only another metrical level of the same music."""
        if abs(math.log(raw.tempo / before.tempo)) < SAME_TEMPO:  # the level in use is now the tracker's own
            self.level.reset(raw.beat_at(time), before.beat_at(time))
            self._kept_since = math.inf
            return
        kept = math.isfinite(self._kept_since)
        if self.level.factor != 1.0 and not kept:  # the level was set by hand
            return
        ratio = math.log2(raw.tempo / before.tempo)
        octave = round(ratio)
        at = raw if octave < 0 else before  # beats of the slower level are beats of the faster one
        beat = at.number + math.floor((time - at.time) / at.period + 0.5)
        place = at.time + (beat - at.number) * at.period
        other = before if octave < 0 else raw
        near = abs(other.residual(place)) < ON_BEAT
        if abs(octave) == 1 and abs(ratio - octave) * math.log(2.0) < SAME_TEMPO and near:
            count = math.floor(other.beat_at(place) + 0.5)
            mine, theirs = (count, beat) if octave < 0 else (beat, count)
            self.level.pin(theirs, mine, 0.5**octave)
            self._kept_since = self._kept_since if kept else now
            return
        self.level.reset(raw.beat_at(time), before.beat_at(time))
        self._kept_since = math.inf

    def _update_state(self, believed: bool, sure: bool, share: float) -> None:
        """Set the state from the tracker input; a lock holds until most observations contradict it."""
        self.confidence = min(max(share, 0.0), 1.0)
        if not believed:
            self.state = "listening"
        elif sure or (self.state == "locked" and share >= 0.3):
            self.state = "locked"
        else:
            self.state = "following"

    def paused(self, now: float) -> None:
        """Handle a pause longer than usual: ignore beats until sound returns, and keep all state."""
        if self.silent_since is None and self._before_pause is None and self.state != "absent":
            self._before_pause, self._paused_at, self.state = self.state, now, "listening"

    def silent(self, now: float) -> None:
        """Handle the end of the music."""
        self._before_pause = None
        super().silent(now)
        self._reset()

    def found(self, now: float) -> None:
        """Handle the return of sound."""
        if self._before_pause is not None:
            self.state, self._before_pause = self._before_pause, None
            self.observed_at = max(self.observed_at, now)
            return
        super().found(now)
        self._reset()

    def _reset(self) -> None:
        self.consensus.clear()
        self.pointer.clear()
        self._trust = Trust()
        self.state = "absent" if self.state == "absent" else "listening"

    def check_timeout(self, now: float) -> None:
        """Detect missing beats."""
        raw = self.raw()
        if self.ready and raw is not None and now - self.observed_at > max(NOTHING_HEARD, 3.0 * raw.period):
            self.state = "listening"
            self.pointer.clear()

    def set_by_hand(self, grid: Grid, until: float) -> None:
        """Set the beats by hand, with priority until then [s]."""
        self.consensus.set_grid(grid)
        self.manual_until = until

    def align_with(self, manual_grid: Grid, now: float) -> None:
        """Set the metrical level and the side of the beat (on or off) to those of the manual grid."""
        raw = self.raw()
        if not self._has_pointer or raw is None:
            return
        self.level.reset(raw.beat_at(now), manual_grid.beat_at(now))
        ratio = math.log2(manual_grid.tempo / raw.tempo)
        if round(ratio) in (-1, 1) and abs(ratio - round(ratio)) * math.log(2.0) < SAME_TEMPO:
            danced = self.level.map_beat(math.floor(raw.beat_at(now)))
            self.level.scale(2.0 ** round(ratio), danced)
        grid = self.grid()
        if grid is None:
            return
        off = grid.beat_at(now) - manual_grid.beat_at(now)
        unit = 0.5 * min(self.level.factor, 1.0)  # half a beat of the tracker's
        side = math.floor(off / unit + 0.5) * unit
        if side % 1.0 and abs(off - side) < OFF_BEAT:
            self.level.shift(side % 1.0)
