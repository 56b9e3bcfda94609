"""Moment: musical time at one instant, as everything that follows the music reads it."""

from dataclasses import dataclass

from live.clock.timeline import Timeline


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
