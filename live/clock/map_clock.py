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
    """Tells the beats of a map in order, while the piece plays, again and again if it repeats.

    The map may be replaced meanwhile, as a person corrects it.
    """

    def __init__(self, measures: MeasureMap | None, duration: float) -> None:
        """`measures`: None while they are not known. `duration` [s]: after so long the piece begins again."""
        self._map, self._next_map, self._duration = measures, measures, max(duration, 1.0)
        self._beat: int | None = None  # the last one that was told
        self._round = 0

    @property
    def is_known(self) -> bool:
        """Whether it has a map."""
        return self._next_map is not None

    def replace(self, measures: MeasureMap | None) -> None:
        """Tell the beats of another map, or none, from now on. Thread: any."""
        former = self._next_map
        if measures is None or former is None or measures.lines != former.lines:
            self._next_map = measures

    def until(self, position: float) -> Iterator[MapBeat]:
        """Yield the beats up to a position of the sound [s] that were not told yet, first the one that is running."""
        if self._map is not self._next_map:
            self._map, self._beat = self._next_map, None
        measures = self._map
        if measures is None:
            return
        rounds = int(position // self._duration)
        inside = position - rounds * self._duration
        jump = self._beat is not None and rounds != self._round
        now = math.floor(measures.beat_at(inside) + 1e-9)
        if self._beat is None or jump:
            self._beat, self._round = now - 1, rounds
        while self._beat < now:
            self._beat += 1
            time = measures.time_at(float(self._beat))
            place, beats = _place(measures, self._beat)
            period = measures.time_at(self._beat + 1.0) - time
            yield MapBeat(rounds * self._duration + time, period, place, beats, jump)
            jump = False


def _place(measures: MeasureMap, beat: int) -> tuple[int, int]:
    """Return the place of a beat in its measure, and the beats of that measure."""
    index = measures.line_index(float(beat))
    beats = measures.lines[index].beats
    return (beat - round(measures.line_beat(index))) % beats, beats
