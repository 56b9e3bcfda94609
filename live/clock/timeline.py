"""Timeline: the bijection between seconds and beats, and where the measures lie in it (after Ableton Link).

A Timeline is never changed, only replaced as a whole. *Phase* means beats into the measure, in [0, beats_per_measure).

Moment: musical time at one instant, as everything that follows the music reads it.

Grid: where the beats lie, as a hypothesis: numbered, evenly spaced, with no measures yet.
"""

import math
from dataclasses import dataclass, replace

TEMPO_MIN_BPM = 20.0
TEMPO_MAX_BPM = 400.0


@dataclass(frozen=True, slots=True)
class Timeline:
    """beat(t) = beat_origin + (t - time_origin) · tempo / 60; a measure begins at measure_origin + k · B."""

    tempo: float = 120.0
    """Beats per minute."""
    beat_origin: float = 0.0
    time_origin: float = 0.0
    """Seconds of the clock at which the beat is `beat_origin`."""
    beats_per_measure: int = 4
    measure_origin: float = 0.0
    """The beat at which measure 0 begins."""

    def __post_init__(self) -> None:
        if not TEMPO_MIN_BPM <= self.tempo <= TEMPO_MAX_BPM:
            raise ValueError(f"tempo {self.tempo} is not within {TEMPO_MIN_BPM:g} to {TEMPO_MAX_BPM:g} bpm")
        if self.beats_per_measure < 1:
            raise ValueError(f"a measure of {self.beats_per_measure} beats: at least 1 expected")

    def beat_at(self, time: float) -> float:
        """Beat at `time` [s]."""
        return self.beat_origin + (time - self.time_origin) * self.tempo / 60.0

    def time_at(self, beat: float) -> float:
        """Time [s] at which `beat` falls."""
        return self.time_origin + (beat - self.beat_origin) * 60.0 / self.tempo

    def measure_at(self, time: float) -> int:
        """Number of the measure (from 0) that holds `time` [s]."""
        since = self.beat_at(time) - self.measure_origin
        # Not floor(since / B): a hair before a line, phase rounds up to the line, and the number must go with it.
        return round((since - phase(since, self.beats_per_measure)) / self.beats_per_measure)

    def phase_at(self, time: float) -> float:
        """Beats into the measure at `time` [s]."""
        return phase(self.beat_at(time) - self.measure_origin, self.beats_per_measure)

    def with_tempo(self, tempo: float, time: float) -> "Timeline":
        """The same beat at `time` [s], another tempo [bpm] from there."""
        return Timeline(tempo, self.beat_at(time), time, self.beats_per_measure, self.measure_origin)

    def with_one_at(self, time: float) -> "Timeline":
        """The beat nearest to `time` [s] becomes a downbeat; the beat position stays, the measure lines move.

        The measure that begins there takes the number of the nearest measure line of the old grid, so that numbers
        neither jump nor repeat by more than the shift asks for.
        """
        downbeat = math.floor(self.beat_at(time) + 0.5)
        number = math.floor((downbeat - self.measure_origin) / self.beats_per_measure + 0.5)
        return replace(self, measure_origin=float(downbeat - number * self.beats_per_measure))

    def with_line(self, beat: float, time: float, *, beats_per_measure: int | None = None) -> "Timeline":
        """A measure begins at `beat` (and measures have so many beats); the beat position stays.

        At `time` [s] the number of the measure is that which is nearest to how far the dance was, and never lower than
        it was.
        """
        size = self.beats_per_measure if beats_per_measure is None else beats_per_measure
        at, number = self.beat_at(time), self.measure_at(time)
        into = phase(at - beat, size)
        on = number + (into / size < self.phase_at(time) / self.beats_per_measure - 0.5)
        lines = round((at - into - beat) / size)
        return replace(self, beats_per_measure=size, measure_origin=beat + (lines - on) * size)


def phase(beat: float, quantum: float) -> float:
    """Beats into the quantum, in [0, quantum), for negative beats too."""
    remainder = math.fmod(beat, quantum)
    if remainder < 0.0:
        remainder += quantum
    return remainder if remainder < quantum else 0.0


def next_phase_match(beat: float, target: float, quantum: float) -> float:
    """The first beat at or after `beat` whose phase equals that of `target`."""
    return beat + phase(target - beat, quantum)


@dataclass(frozen=True, slots=True)
class Moment:
    """One instant: seconds of the show, beat, measure (from 0), beats into the measure, tempo [bpm]."""

    time: float
    beat: float
    measure: int
    phase: float
    tempo: float
    confidence: float = 1.0

    @staticmethod
    def of(timeline: Timeline, time: float, confidence: float = 1.0) -> "Moment":
        """The moment that `timeline` gives for `time` [s]."""
        return Moment(
            time, timeline.beat_at(time), timeline.measure_at(time), timeline.phase_at(time), timeline.tempo, confidence
        )


@dataclass(frozen=True, slots=True)
class Grid:
    """Beat `number` lies at `time` [s], the others `period` [s] apart."""

    time: float
    period: float
    number: int = 0

    @property
    def tempo(self) -> float:
        """Beats per minute."""
        return 60.0 / self.period

    def beat_at(self, time: float) -> float:
        """Beat at `time` [s]."""
        return self.number + (time - self.time) / self.period

    def residual(self, time: float, division: float = 1.0) -> float:
        """How far `time` [s] lies after the nearest line of a grid of `division` beats, in beats (± division / 2)."""
        position = (time - self.time) / (self.period * division)
        return (position - math.floor(position + 0.5)) * division

    def numbered_like(self, beat: float, time: float) -> "Grid":
        """The same grid, its beats numbered so that `time` [s] is as near to `beat` as can be."""
        return Grid(self.time, self.period, self.number + math.floor(beat - self.beat_at(time) + 0.5))
