"""Measure map of a piece: where each measure begins, its beats, and how its tempo runs (T007; Schulz 2011, 2.1.1).

Beats count from 0 at the first line. Before the first line and after the last one the tempo next to it goes on.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

TempoRun = Literal["step", "ramp"]
MIN_MEASURE_S: Final = 0.05
"""Smallest time between two measure lines [s]."""
MAX_RAMP: Final = 0.8
"""Largest relative difference between the tempo at the ends of a ramp and its mean."""


@dataclass(frozen=True, slots=True)
class MeasureLine:
    """The beginning of a measure."""

    time_s: float
    """Its time in the piece [s]."""
    measure: int
    """Its number, from 1."""
    beats: int = 4
    """Beats of the measure that it begins."""
    tempo: TempoRun = "step"
    """The tempo within the measure: constant, or running evenly from that before it."""


@dataclass(frozen=True, slots=True)
class Phrase:
    """A phrase of the music: it lasts until the next one."""

    measure: int
    """The measure with which it begins, from 1."""
    name: str = ""


class MeasureMap:
    """Measures of a piece over time. It never changes."""

    def __init__(self, lines: Sequence[MeasureLine], phrases: Sequence[Phrase] = ()) -> None:
        """ValueError for lines that go back in time or count, or for no line."""
        if not lines:
            raise ValueError("a map needs a measure line")
        self.lines = tuple(lines)
        """The measure lines, in order."""
        self.phrases = tuple(sorted(phrases, key=lambda phrase: phrase.measure))
        """The phrases, in order."""
        for before, line in zip(self.lines, self.lines[1:], strict=False):
            if line.time_s < before.time_s + MIN_MEASURE_S:
                raise ValueError(
                    f"measure {line.measure} begins at {line.time_s:g} s, and measure {before.measure} before it at "
                    f"{before.time_s:g} s: lines go forward, at least {MIN_MEASURE_S:g} s"
                )
            if line.measure != before.measure + 1:
                raise ValueError(f"measure {line.measure} follows measure {before.measure}: they are counted on by one")
        self._times = [line.time_s for line in self.lines]
        self._beats = [0.0]
        for line in self.lines[:-1]:
            self._beats.append(self._beats[-1] + line.beats)
        self._runs = self._begin_tempos()

    def _begin_tempos(self) -> list[float]:
        """Return for each measure but the last the tempo at its line, relative to its mean."""
        runs: list[float] = []
        end = 0.0
        for line, following in zip(self.lines, self.lines[1:], strict=False):
            mean = line.beats / (following.time_s - line.time_s)
            start = mean
            if line.tempo == "ramp" and end > 0.0:
                start = min(max(end, (1.0 - MAX_RAMP) * mean), (1.0 + MAX_RAMP) * mean)
            runs.append(start / mean)
            end = 2.0 * mean - start
        return runs

    @property
    def bpm(self) -> float:
        """The tempo over all measures [bpm]; 120 for a single line."""
        if len(self.lines) < 2:
            return 120.0
        return 60.0 * self._beats[-1] / (self._times[-1] - self._times[0])

    def _outside_interval(self, *, last: bool) -> float:
        """Return the seconds of a beat before the first line, or after the last one."""
        if len(self.lines) < 2:
            return 0.5
        index = len(self.lines) - 2 if last else 0
        return (self._times[index + 1] - self._times[index]) / self.lines[index].beats

    def beat_at(self, time: float) -> float:
        """Return the beat at a time of the piece [s]; negative before the first line."""
        if time < self._times[0]:
            return (time - self._times[0]) / self._outside_interval(last=False)
        if time >= self._times[-1]:
            return self._beats[-1] + (time - self._times[-1]) / self._outside_interval(last=True)
        index = bisect_right(self._times, time) - 1
        share = (time - self._times[index]) / (self._times[index + 1] - self._times[index])
        run = self._runs[index]
        return self._beats[index] + self.lines[index].beats * (run * share + (1.0 - run) * share * share)

    def time_at(self, beat: float) -> float:
        """Return the time of a beat in the piece [s]."""
        if beat < 0.0:
            return self._times[0] + beat * self._outside_interval(last=False)
        if beat >= self._beats[-1]:
            return self._times[-1] + (beat - self._beats[-1]) * self._outside_interval(last=True)
        index = bisect_right(self._beats, beat) - 1
        part = (beat - self._beats[index]) / self.lines[index].beats
        run = self._runs[index]
        share = part if abs(run - 1.0) < 1e-9 else _root(run, part)
        return self._times[index] + share * (self._times[index + 1] - self._times[index])

    def line_beat(self, index: int) -> float:
        """Return the beat at which the line with this index begins."""
        return self._beats[index]

    def measure_at(self, time: float) -> float:
        """Return the measures since the first line at a time of the piece [s]: 2.5 is the middle of the third."""
        beat = self.beat_at(time)
        index = self.line_index(beat)
        return index + (beat - self._beats[index]) / self.lines[index].beats

    def line_index(self, beat: float) -> int:
        """Return the index of the line whose measure holds a beat; before the first line that of the first."""
        return max(bisect_right(self._beats, beat) - 1, 0)

    # Corrections

    def with_line(self, time: float) -> "MeasureMap":
        """Return the map with one more line: its measure becomes two, the beats shared by time."""
        index = bisect_right(self._times, time) - 1
        if index < 0:
            first = self.lines[0]
            beats = max(round((first.time_s - time) / self._outside_interval(last=False)), 1)
            return self._renumbered([MeasureLine(time, 0, beats), *self.lines])
        before = self.lines[index]
        split = self.beat_at(time) - self._beats[index]
        if index == len(self.lines) - 1:
            pair = [replace(before, beats=max(round(split), 1)), MeasureLine(time, 0, before.beats)]
            return self._renumbered([*self.lines[:-1], *pair])
        left = min(max(round(split), 1), max(before.beats - 1, 1))
        pair = [replace(before, beats=left), MeasureLine(time, 0, max(before.beats - left, 1))]
        return self._renumbered([*self.lines[:index], *pair, *self.lines[index + 1 :]])

    def without_line(self, index: int) -> "MeasureMap":
        """Return the map without a line: its measure belongs to the one before. ValueError for the only line."""
        if len(self.lines) < 2:
            raise ValueError("the last line cannot be removed")
        lines = list(self.lines)
        gone = lines.pop(index)
        if index > 0 and index < len(self.lines) - 1:
            lines[index - 1] = replace(lines[index - 1], beats=lines[index - 1].beats + gone.beats)
        return self._renumbered(lines)

    def with_run(self, index: int, tempo: TempoRun) -> "MeasureMap":
        """Return the map with another run of the tempo in a measure."""
        lines = list(self.lines)
        lines[index] = replace(lines[index], tempo=tempo)
        return MeasureMap(lines, self.phrases)

    def _renumbered(self, lines: Sequence[MeasureLine]) -> "MeasureMap":
        first = self.lines[0].measure
        return MeasureMap([replace(line, measure=first + k) for k, line in enumerate(lines)], self.phrases)


def _root(run: float, part: float) -> float:
    """Return u in [0, 1] with run · u + (1 - run) · u² = part."""
    square = 1.0 - run
    inside = max(run * run + 4.0 * square * part, 0.0)
    return 2.0 * part / (run + math.sqrt(inside))


def steady_map(bpm: float, one_at: float, beats: int, measures: int) -> MeasureMap:
    """Return the simplest map: a constant tempo, with the first measure at `one_at` [s]."""
    seconds = 60.0 * beats / bpm
    return MeasureMap([MeasureLine(one_at + k * seconds, k + 1, beats) for k in range(measures)])
