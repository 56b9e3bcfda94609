"""HandControls: a musician's hand on the beat and the measure: the one, nudge, shift, metre, and who is followed."""

import math

from live.clock.follower.bar_alignment import METRE_MAX, METRE_MIN
from live.clock.follower.hand_tempo import HandTempo
from live.clock.follower.run import LEAP_BEATS
from live.clock.follower.source import HeardSource
from live.clock.grid import Grid


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
