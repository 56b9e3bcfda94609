"""Beats of a piece whose measures are known, as it plays: each with its exact time (T007)."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from live.clock.measure_map import MeasureMap


@dataclass(frozen=True, slots=True)
class MapBeat:
    """A beat of a map."""

    position: float
    """Its time in the sound [s]; in loops it goes on rising."""
    period: float
    """Time to the next beat [s]."""
    beat: int
    """Its place in the measure, from 0."""
    beats_per_measure: int
    jump: bool
    """Whether the piece begins again with it."""


class MapClock:
    """Tells the beats of a map in order, while the piece plays, again and again if it repeats."""

    def __init__(self, measures: MeasureMap, duration: float) -> None:
        """`duration` [s]: after so long the piece begins again."""
        self._map, self._duration = measures, max(duration, 1.0)
        self._beat: int | None = None  # the last one that was told
        self._round = 0

    def until(self, position: float) -> Iterator[MapBeat]:
        """Yield the beats up to a position of the sound [s] that were not told yet, first the one that is running."""
        rounds = int(position // self._duration)
        inside = position - rounds * self._duration
        jump = self._beat is not None and rounds != self._round
        now = math.floor(self._map.beat_at(inside) + 1e-9)
        if self._beat is None or jump:
            self._beat, self._round = now - 1, rounds
        while self._beat < now:
            self._beat += 1
            time = self._map.time_at(float(self._beat))
            place, beats = self._place(self._beat)
            period = self._map.time_at(self._beat + 1.0) - time
            yield MapBeat(rounds * self._duration + time, period, place, beats, jump)
            jump = False

    def _place(self, beat: int) -> tuple[int, int]:
        """Return the place of a beat in its measure, and the beats of that measure."""
        index = self._map.line_index(float(beat))
        beats = self._map.lines[index].beats
        return (beat - round(self._map.line_beat(index))) % beats, beats
