"""Phase correction: a timeline that follows a goal grid within slew limits, or by an announced leap forward."""

import math
from dataclasses import dataclass, replace
from typing import Final, Literal

from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM, Grid, Timeline

Cause = Literal["start", "new song", "one", "lines", "hand", "first downbeat"]
"""start: the source started or moved its song position; new song: another tempo after silence; one: a tap on the
downbeat; lines: the source's measure lines are adopted; hand: nudged by beats, halved or doubled; first downbeat:
the measures are counted back to the known first one.
"""


@dataclass(frozen=True, slots=True)
class Jump:
    """A jump of the beat at `time` [s] from `before` to `after` (equal if only the measure lines moved)."""

    time: float
    before: float
    after: float
    cause: Cause


CORRECTION_TIME: Final = 0.8
CORRECTION_TIME_EXACT: Final = 0.4
"""Time constant of the phase correction [s]; the second for clocks with exact times."""

SLEW_LOCKED: Final = 0.12
SLEW_UNLOCKED: Final = 0.20
"""Slew limits: relative change of the tempo for catching up."""

LEAP_BEATS: Final = 0.12
"""A jump of the beat by less than this is corrected gradually, like any other error."""


class SlewedTimeline:
    """A timeline with a strictly increasing beat; each tick sets a tempo that leads to the goal."""

    def __init__(self, timeline: Timeline, goal: Grid) -> None:
        self.timeline = timeline
        self.goal = goal
        """The grid that it follows; its numbers are the timeline's."""
        self.jumps = 0
        """Number of jumps of beat or measure lines."""
        self.last_jump: Jump | None = None
        self._leap: Cause | None = None

    def beat(self, now: float) -> float:
        """Return the beat at `now` [s]."""
        return self.timeline.beat_at(now)

    def error(self, now: float) -> float:
        """Return how far the goal is ahead [beats]."""
        return self.goal.beat_at(now) - self.timeline.beat_at(now)

    def freeze(self, now: float) -> None:
        """Continue from `now` [s], the last tick, with the error set to zero."""
        beat, period = self.beat(now), self.goal.period
        number = math.floor(beat)
        self.goal = Grid(now - (beat - number) * period, period, number)
        self.timeline = self.timeline.with_tempo(min(max(self.goal.tempo, TEMPO_MIN_BPM), TEMPO_MAX_BPM), now)

    @property
    def leap_pending(self) -> bool:
        """Whether the next tick makes a leap."""
        return self._leap is not None

    def request_leap(self, cause: Cause) -> None:
        """Jump to the goal at the next tick."""
        self._leap = cause

    def follow_goal(self, now: float, *, slew: float, exact: bool = False) -> None:
        """Set the timeline from `now` [s] on: towards the goal, by at most the share `slew` faster or slower."""
        if self._leap is not None:
            self._leap_forward(now, self._leap)
            self._leap = None
        error = self.error(now)
        seconds = CORRECTION_TIME_EXACT if exact else CORRECTION_TIME
        correction = min(max(error / (seconds * self.goal.tempo / 60.0), -slew), slew)
        tempo = min(max(self.goal.tempo * (1.0 + correction), TEMPO_MIN_BPM), TEMPO_MAX_BPM)
        self.timeline = self.timeline.with_tempo(tempo, now)

    def set_measure_line(self, beat: float, now: float, cause: Cause, *, beats_per_measure: int | None = None) -> None:
        """Start a measure at `beat`, from now on; announce it if that moves the lines."""
        before = self.timeline
        self.timeline = before.with_measure_line(beat, now, beats_per_measure=beats_per_measure)
        same = before.beats_per_measure == self.timeline.beats_per_measure
        if not same or (self.timeline.measure_origin - before.measure_origin) % before.beats_per_measure != 0.0:
            self._announce(Jump(now, self.beat(now), self.beat(now), cause))
        elif self.timeline.measure_origin != before.measure_origin:
            self.timeline = before

    def count_from(self, one_at: float, now: float) -> None:
        """Count the measures from the music's known first downbeat, back along the goal."""
        before = self.timeline
        straight = replace(before, beat_origin=self.goal.beat_at(one_at), time_origin=one_at)
        self.timeline = replace(before, measure_origin=straight.with_downbeat_at(one_at).measure_origin)
        if self.timeline != before:
            self._announce(Jump(now, self.beat(now), self.beat(now), "first downbeat"))

    def announce_one(self, now: float) -> None:
        """Announce the end of a count-in: the measure that begins is the first."""
        self._announce(Jump(now, self.beat(now), self.beat(now), "one"))

    def _leap_forward(self, now: float, cause: Cause) -> None:
        """Leap forward to the goal's phase, by less than one beat; if it is very near, leave it to the correction."""
        error = self.error(now)
        whole = whole_beats_off(error)
        self.goal = replace(self.goal, number=self.goal.number - whole)
        forward = error - whole
        if forward > LEAP_BEATS:
            before = self.beat(now)
            self.timeline = replace(self.timeline, beat_origin=before + forward, time_origin=now)
            self._announce(Jump(now, before, before + forward, cause))

    def _announce(self, jump: Jump) -> None:
        self.jumps += 1
        self.last_jump = jump


def whole_beats_off(error: float) -> int:
    """Return by how many whole beats to lower the goal, so that a leap to it goes forward by less than a beat."""
    return math.floor(error + LEAP_BEATS)
