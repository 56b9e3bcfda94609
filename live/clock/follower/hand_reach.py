"""HandReach: what all that a musician's hand does needs: who may say what, and where it is put."""

import math
from collections.abc import Callable
from typing import Final

from live.clock.follower.audio_source import AudioSource
from live.clock.follower.bar_alignment import Measures
from live.clock.follower.direct import DirectSource
from live.clock.follower.follower_status import Seen
from live.clock.follower.hand import HandSource
from live.clock.follower.seed import Kind, Seed
from live.clock.grid import Grid
from live.clock.tap_tempo import TapTempo

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
