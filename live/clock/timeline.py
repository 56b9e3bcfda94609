"""Musical time: the mapping between seconds and beats with its measure lines (after Ableton Link).

A `Timeline` is immutable and only replaced as a whole. *Phase* means beats into the measure, in
[0, beats_per_measure).
"""

import math
from dataclasses import dataclass, replace

TEMPO_MIN_BPM = 20.0
TEMPO_MAX_BPM = 400.0
METRE_MIN = 2
METRE_MAX = 12
"""Range of beats per measure."""


@dataclass(frozen=True, slots=True)
class Timeline:
    """beat(t) = beat_origin + (t - time_origin) · tempo / 60; a measure begins at measure_origin + k · B."""

    tempo: float = 120.0
    """Beats per minute."""
    beat_origin: float = 0.0
    time_origin: float = 0.0
    """Time at which the beat is `beat_origin` [s]."""
    beats_per_measure: int = 4
    measure_origin: float = 0.0
    """The beat at which measure 0 begins."""

    def __post_init__(self) -> None:
        if not TEMPO_MIN_BPM <= self.tempo <= TEMPO_MAX_BPM:
            raise ValueError(f"tempo {self.tempo} is not within {TEMPO_MIN_BPM:g} to {TEMPO_MAX_BPM:g} bpm")
        if self.beats_per_measure < 1:
            raise ValueError(f"a measure of {self.beats_per_measure} beats: at least 1 expected")

    def beat_at(self, time: float) -> float:
        """Return the beat at `time` [s]."""
        return self.beat_origin + (time - self.time_origin) * self.tempo / 60.0

    def time_at(self, beat: float) -> float:
        """Return the time [s] of `beat`."""
        return self.time_origin + (beat - self.beat_origin) * 60.0 / self.tempo

    def measure_at(self, time: float) -> int:
        """Return the number of the measure (from 0) that contains `time` [s]."""
        since = self.beat_at(time) - self.measure_origin
        # Not floor(since / B): just before a line, phase rounds up to the line, and the number must agree with it.
        return round((since - phase(since, self.beats_per_measure)) / self.beats_per_measure)

    def phase_at(self, time: float) -> float:
        """Return the beats into the measure at `time` [s]."""
        return phase(self.beat_at(time) - self.measure_origin, self.beats_per_measure)

    def with_tempo(self, tempo: float, time: float) -> "Timeline":
        """Return a timeline with the same beat at `time` [s], and the tempo [bpm] from there on."""
        return Timeline(tempo, self.beat_at(time), time, self.beats_per_measure, self.measure_origin)

    def with_downbeat_at(self, time: float) -> "Timeline":
        """Return a timeline in which the beat nearest to `time` [s] is a downbeat; beats stay, the measure lines move.

        The new measure takes the number of the nearest measure line of the old grid, so that numbers neither jump nor
        repeat by more than the shift requires.
        """
        downbeat = math.floor(self.beat_at(time) + 0.5)
        number = math.floor((downbeat - self.measure_origin) / self.beats_per_measure + 0.5)
        return replace(self, measure_origin=float(downbeat - number * self.beats_per_measure))

    def with_measure_line(self, beat: float, time: float, *, beats_per_measure: int | None = None) -> "Timeline":
        """Return a timeline in which a measure begins at `beat` (optionally with another length); the beat position
        stays.

        At `time` [s] the measure's number is the one nearest to the old position, and never lower than the old number.
        """
        size = self.beats_per_measure if beats_per_measure is None else beats_per_measure
        at, number = self.beat_at(time), self.measure_at(time)
        into = phase(at - beat, size)
        on = number + (into / size < self.phase_at(time) / self.beats_per_measure - 0.5)
        lines = round((at - into - beat) / size)
        return replace(self, beats_per_measure=size, measure_origin=beat + (lines - on) * size)


def phase(beat: float, quantum: float) -> float:
    """Return the beats into the quantum, in [0, quantum), for negative beats too."""
    remainder = math.fmod(beat, quantum)
    if remainder < 0.0:
        remainder += quantum
    return remainder if remainder < quantum else 0.0


def next_phase_match(beat: float, target: float, quantum: float) -> float:
    """Return the first beat at or after `beat` whose phase equals that of `target`."""
    return beat + phase(target - beat, quantum)


@dataclass(frozen=True, slots=True)
class Moment:
    """Musical time at one instant: seconds of the show, beat, measure (from 0), beats into the measure, tempo [bpm]."""

    time: float
    beat: float
    measure: int
    phase: float
    tempo: float
    confidence: float = 1.0

    @staticmethod
    def of(timeline: Timeline, time: float, confidence: float = 1.0) -> "Moment":
        """Return the moment of `timeline` at `time` [s]."""
        return Moment(
            time, timeline.beat_at(time), timeline.measure_at(time), timeline.phase_at(time), timeline.tempo, confidence
        )


@dataclass(frozen=True, slots=True)
class Grid:
    """A hypothesis of evenly spaced beats without measures: beat `number` at `time` [s], the others `period` [s]
    apart."""

    time: float
    period: float
    number: int = 0

    @property
    def tempo(self) -> float:
        """Beats per minute."""
        return 60.0 / self.period

    def beat_at(self, time: float) -> float:
        """Return the beat at `time` [s]."""
        return self.number + (time - self.time) / self.period

    def residual(self, time: float, division: float = 1.0) -> float:
        """Return how far `time` [s] lies after the nearest line of a grid of `division` beats, in beats (± division /
        2)."""
        position = (time - self.time) / (self.period * division)
        return (position - math.floor(position + 0.5)) * division

    def numbered_like(self, beat: float, time: float) -> "Grid":
        """Return the same grid with beats numbered so that `time` [s] is as near to `beat` as possible."""
        return Grid(self.time, self.period, self.number + math.floor(beat - self.beat_at(time) + 0.5))
