"""The current measure and the fraction of it that is danced, continuous even when the measure lines move."""

import math
from typing import Final

from live.clock.timeline import Timeline, next_phase_match

STALL_BEATS: Final = 0.25
"""If a measure is overdue by more than this [beats] (longer than a tick), a stall has skipped several measures."""


class MeasureSpan:
    """One danced measure, from its first beat to the beat of its end.

    Its fraction (0 to 1) is the time base of every clip. When "this is the one" moves the measure lines, the dancers
    do not jump: the rest of the measure is danced faster or slower, to end at the nearest new line (re-timing, T140).
    """

    def __init__(self, number: int, begin: float, end: float, beats: int | None = None) -> None:
        """`beats`: length of the measures after it; default: the same as this one."""
        self.number = number
        """Number of the measure, from 0."""
        self.end = end
        """The beat at which it ends."""
        self._beats: float = end - begin if beats is None else beats
        self._anchor_beat = begin
        self._anchor_fraction = 0.0

    @staticmethod
    def at(timeline: Timeline, beat: float) -> "MeasureSpan":
        """Return the measure of `timeline` that contains `beat`."""
        size = timeline.beats_per_measure
        number = math.floor((beat - timeline.measure_origin) / size)
        begin = timeline.measure_origin + number * size
        return MeasureSpan(number, begin, begin + size, size)

    def fraction(self, beat: float) -> float:
        """Return the fraction of the measure at `beat`, clamped to [0, 1]."""
        left = self.end - self._anchor_beat
        share = (beat - self._anchor_beat) / left if left > 0.0 else 1.0
        return min(max(self._anchor_fraction + (1.0 - self._anchor_fraction) * share, 0.0), 1.0)

    def danced_beats(self, beat: float, size: int) -> float:
        """Return the beats danced at `beat` since measure 0, with `size` beats per measure. It extends beyond the end
        of this measure, so that danced beats never decrease when several lines are crossed after a stall.

        When "this is the one" stretches or shortens a measure, danced beats run slower or faster, so a plan in danced
        beats still meets the danced measure line.
        """
        if beat <= self.end:
            return (self.number + self.fraction(beat)) * size
        return (self.number + 1) * size + (beat - self.end) * (size / self._beats)

    def follow(self, timeline: Timeline, beat: float, *, shortest: float) -> bool:
        """Re-time to the measure lines of `timeline`; True if they have moved.

        The new end is the line that changes the speed least and is at least `shortest` beats away.
        """
        size = timeline.beats_per_measure
        offset = math.fmod(abs(self.end - timeline.measure_origin), size)
        aligned = min(offset, size - offset) < 1e-6
        if beat > self.end + STALL_BEATS:
            if not aligned or size != self._beats:
                self._catch_up(timeline, beat, beat)
            return not aligned
        self._beats = size
        if aligned:
            return False
        self._retime(timeline, beat, self.fraction(beat), shortest)
        return True

    def jump(self, timeline: Timeline, before: float, after: float, *, shortest: float) -> None:
        """Handle a jump of the beat from `before` to `after`: the fraction stays, the rest is re-timed."""
        if before > self.end + STALL_BEATS:
            self._catch_up(timeline, before, after)
        elif before >= self.end:  # this tick crosses the line
            self.end = after
        else:
            self._retime(timeline, after, self.fraction(before), shortest)

    def _catch_up(self, timeline: Timeline, before: float, after: float) -> None:
        """Handle moved lines while several are still to be crossed after a stall: the danced beats at `after` equal
        those at `before`, rounded up to a whole measure."""
        size = timeline.beats_per_measure
        late = after - (before - self.end) * (size / self._beats)
        line = next_phase_match(late, timeline.measure_origin, size)
        self.end, self._beats = (line - size if line > late + 1e-6 else line), size

    def _retime(self, timeline: Timeline, beat: float, fraction: float, shortest: float) -> None:
        size = timeline.beats_per_measure
        left = max(1.0 - fraction, 1e-3) * size
        first = next_phase_match(beat + shortest, timeline.measure_origin, size)
        self.end = min((first, first + size), key=lambda end: abs(math.log((end - beat) / left)))
        self._anchor_beat, self._anchor_fraction = beat, fraction

    def next(self, timeline: Timeline) -> "MeasureSpan":
        """Return the measure after this one."""
        end = next_phase_match(self.end + 1e-6, timeline.measure_origin, timeline.beats_per_measure)
        if end - self.end < 0.5:  # lines moved slightly: this is the line just reached
            end += timeline.beats_per_measure
        return MeasureSpan(self.number + 1, self.end, end, timeline.beats_per_measure)
