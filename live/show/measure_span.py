"""MeasureSpan: the measure that is being danced, and how far it is, whatever the measure lines do meanwhile."""

import math
from typing import Final

from live.clock.timeline import Timeline, next_phase_match

BEHIND: Final = 0.25
"""Beats after its end, more than a tick has, from which on a measure is taken as one of several a stall left out."""


class MeasureSpan:
    """One danced measure from the beat it began to the beat it will end.

    Its fraction (0 to 1) is the time base of every clip. When "this is the one" moves the measure lines, the dancers
    do not jump: what is left of the measure is danced a little faster or slower into the nearest new line (T140's
    idea: re-time to the measure).
    """

    def __init__(self, number: int, begin: float, end: float, beats: int | None = None) -> None:
        """`beats`: how many the measures after it have; left out, as many as this one."""
        self.number = number
        """Number of the measure, from 0."""
        self.end = end
        """The beat at which it ends."""
        self._beats: float = end - begin if beats is None else beats
        self._anchor_beat = begin
        self._anchor_fraction = 0.0

    @staticmethod
    def at(timeline: Timeline, beat: float) -> "MeasureSpan":
        """The measure of `timeline` that holds `beat`."""
        size = timeline.beats_per_measure
        number = math.floor((beat - timeline.measure_origin) / size)
        begin = timeline.measure_origin + number * size
        return MeasureSpan(number, begin, begin + size, size)

    def fraction(self, beat: float) -> float:
        """How far the measure is at `beat`, clamped to [0, 1]."""
        left = self.end - self._anchor_beat
        share = (beat - self._anchor_beat) / left if left > 0.0 else 1.0
        return min(max(self._anchor_fraction + (1.0 - self._anchor_fraction) * share, 0.0), 1.0)

    def danced(self, beat: float, size: int) -> float:
        """Beats danced at `beat` since measure 0 began, each measure counting as `size`, those after this one as well:
        after a stall several lines are crossed one after the other, and nothing that is danced may go back with them.

        Where "this is the one" stretches or shortens a measure, danced beats go slower or faster: whoever plans in them
        arrives on the danced line.
        """
        if beat <= self.end:
            return (self.number + self.fraction(beat)) * size
        return (self.number + 1) * size + (beat - self.end) * (size / self._beats)

    def follow(self, timeline: Timeline, beat: float, *, shortest: float) -> bool:
        """Re-time to the measure lines of `timeline` if they have moved; True if they had.

        Of the next lines the one is taken that changes the speed least, but none nearer than `shortest` beats.
        """
        size = timeline.beats_per_measure
        offset = math.fmod(abs(self.end - timeline.measure_origin), size)
        aligned = min(offset, size - offset) < 1e-6
        if beat > self.end + BEHIND:
            if not aligned or size != self._beats:
                self._catch_up(timeline, beat, beat)
            return not aligned
        self._beats = size
        if aligned:
            return False
        self._retime(timeline, beat, self.fraction(beat), shortest)
        return True

    def leap(self, timeline: Timeline, before: float, after: float, *, shortest: float) -> None:
        """The beat has jumped from `before` to `after`: what was danced stays danced, the rest is re-timed."""
        if before > self.end + BEHIND:
            self._catch_up(timeline, before, after)
        elif before >= self.end:  # the line is crossed in this very tick
            self.end = after
        else:
            self._retime(timeline, after, self.fraction(before), shortest)

    def _catch_up(self, timeline: Timeline, before: float, after: float) -> None:
        """Lines are still to be crossed after a stall and lie elsewhere now: as much stays danced at `after` as was at
        `before`, and what is missing to a whole measure."""
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
        """The measure after this one."""
        end = next_phase_match(self.end + 1e-6, timeline.measure_origin, timeline.beats_per_measure)
        if end - self.end < 0.5:  # lines moved by a hair: that is the line just reached
            end += timeline.beats_per_measure
        return MeasureSpan(self.number + 1, self.end, end, timeline.beats_per_measure)
