"""Moment: musical time at one instant, as everything that follows the music reads it."""

from dataclasses import dataclass

from live.clock.timeline import Timeline, phase


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
        beat = timeline.beat_at(time)
        since = beat - timeline.measure_origin
        into = phase(since, timeline.beats_per_measure)
        measure = round((since - into) / timeline.beats_per_measure)
        return Moment(time, beat, measure, into, timeline.tempo, confidence)
