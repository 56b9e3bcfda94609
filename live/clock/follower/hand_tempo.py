"""HandTempo: a musician's hand on the tempo: taps, a number, half and double, hold, count-in."""

import math

from live.clock.follower.hand_reach import HandReach
from live.clock.grid import Grid
from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM


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
