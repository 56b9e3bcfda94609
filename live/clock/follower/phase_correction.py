"""Run: the Timeline in force, and how it is run after a grid: faster or slower within bounds, or by a leap forward.

Jump: what is announced when the beat or the measure lines do not simply go on.
"""

import math
from dataclasses import dataclass, replace
from typing import Final, Literal

from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM, Grid, Timeline

Cause = Literal["start", "new song", "one", "lines", "hand", "first downbeat"]
"""start: the source started or moved its song position; new song: after silence the tempo is another one; one: "this
is the one"; lines: the source's measure lines are taken over; hand: nudged by beats, halved or doubled; first downbeat:
the measures are counted back to the known first one."""


@dataclass(frozen=True, slots=True)
class Jump:
    """At `time` [s] the beat went from `before` to `after` (equal where only the measure lines moved)."""

    time: float
    before: float
    after: float
    cause: Cause


CORRECTION_TIME: Final = 0.8
CORRECTION_TIME_EXACT: Final = 0.4
"""Time constant with which a phase error is run in [s]; after a clock that names exact times."""

SLEW_LOCKED: Final = 0.12
SLEW_UNLOCKED: Final = 0.20
"""How much faster or slower than the music the beats may run to catch up with it."""

LEAP_BEATS: Final = 0.12
"""A jump of the beat by less than this is run in like any other error."""


class Run:
    """A Timeline whose beat strictly increases: each tick it is given a tempo that brings it to the goal."""

    def __init__(self, timeline: Timeline, goal: Grid) -> None:
        self.timeline = timeline
        self.goal = goal
        """What it is run after; its numbers are the Timeline's."""
        self.jumps = 0
        """How often beat or measure lines did not simply go on."""
        self.last_jump: Jump | None = None
        self._leap: Cause | None = None

    def beat(self, now: float) -> float:
        """The beat at `now` [s]."""
        return self.timeline.beat_at(now)

    def error(self, now: float) -> float:
        """How far the goal is ahead [beats]."""
        return self.goal.beat_at(now) - self.timeline.beat_at(now)

    def freeze(self, now: float) -> None:
        """Go on as at `now` [s], the last tick, with nothing left to correct."""
        beat, period = self.beat(now), self.goal.period
        number = math.floor(beat)
        self.goal = Grid(now - (beat - number) * period, period, number)
        self.timeline = self.timeline.with_tempo(min(max(self.goal.tempo, TEMPO_MIN_BPM), TEMPO_MAX_BPM), now)

    @property
    def leaping(self) -> bool:
        """Whether the next tick brings a leap."""
        return self._leap is not None

    def leap_soon(self, cause: Cause) -> None:
        """At the next tick the goal is taken at once."""
        self._leap = cause

    def to(self, now: float, *, slew: float, exact: bool = False) -> None:
        """The Timeline from `now` [s] on: toward the goal, by at most the share `slew` faster or slower."""
        if self._leap is not None:
            self._leap_now(now, self._leap)
            self._leap = None
        error = self.error(now)
        seconds = CORRECTION_TIME_EXACT if exact else CORRECTION_TIME
        correction = min(max(error / (seconds * self.goal.tempo / 60.0), -slew), slew)
        tempo = min(max(self.goal.tempo * (1.0 + correction), TEMPO_MIN_BPM), TEMPO_MAX_BPM)
        self.timeline = self.timeline.with_tempo(tempo, now)

    def line(self, beat: float, now: float, cause: Cause, *, beats_per_measure: int | None = None) -> None:
        """A measure begins at `beat` from now on; announced if that moves the lines."""
        before = self.timeline
        self.timeline = before.with_line(beat, now, beats_per_measure=beats_per_measure)
        same = before.beats_per_measure == self.timeline.beats_per_measure
        if not same or (self.timeline.measure_origin - before.measure_origin) % before.beats_per_measure != 0.0:
            self._announce(Jump(now, self.beat(now), self.beat(now), cause))
        elif self.timeline.measure_origin != before.measure_origin:
            self.timeline = before

    def count_from(self, one_at: float, now: float) -> None:
        """The measures begin where the music's known first downbeat was, counted back along the goal."""
        before = self.timeline
        straight = replace(before, beat_origin=self.goal.beat_at(one_at), time_origin=one_at)
        self.timeline = replace(before, measure_origin=straight.with_one_at(one_at).measure_origin)
        if self.timeline != before:
            self._announce(Jump(now, self.beat(now), self.beat(now), "first downbeat"))

    def announce_one(self, now: float) -> None:
        """A count-in is over: the measure that begins is the first."""
        self._announce(Jump(now, self.beat(now), self.beat(now), "one"))

    def _leap_now(self, now: float, cause: Cause) -> None:
        """Forward to the goal's place in the beat, by less than one beat; or, if that is very near, run there."""
        error = self.error(now)
        whole = wholes_off(error)
        self.goal = replace(self.goal, number=self.goal.number - whole)
        forward = error - whole
        if forward > LEAP_BEATS:
            before = self.beat(now)
            self.timeline = replace(self.timeline, beat_origin=before + forward, time_origin=now)
            self._announce(Jump(now, before, before + forward, cause))

    def _announce(self, jump: Jump) -> None:
        self.jumps += 1
        self.last_jump = jump


def wholes_off(error: float) -> int:
    """How many whole beats the goal is to be counted down, so that a leap to it goes forward by less than a beat."""
    return math.floor(error + LEAP_BEATS)
