"""The tempo of a performance: from beats to seconds, with drift, rubato, jumps, ramps, stops and restarts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random

import numpy as np
import numpy.typing as npt

CELLS = 4
"""Cells per beat of a clock; within a cell the tempo is constant."""

Floats = npt.NDArray[np.float64]


@dataclass(slots=True)
class Clock:
    """Seconds per cell of a quarter of a beat, from beat 0 on; and gaps (beat, seconds) in which time goes by."""

    cells: Floats
    gaps: list[tuple[float, float]] = field(default_factory=list)
    lead: float = 0.0  # seconds before beat 0

    def seconds(self, beats: Sequence[float]) -> Floats:
        """The times of these beats; before the first and past the last cell the tempo goes on. After a gap at it."""
        where = np.asarray(beats, float)
        times = np.concatenate([[0.0], np.cumsum(self.cells)]) + self.lead
        at = where * CELLS
        index = np.clip(np.floor(at).astype(int), 0, len(self.cells) - 1)
        found = times[index] + (at - index) * self.cells[index]
        for beat, length in self.gaps:
            found = found + np.where(where >= beat - 0.02, length, 0.0)
        return np.asarray(found)

    def periods(self, beats: Sequence[float]) -> Floats:
        """Seconds per beat at these beats."""
        index = np.clip((np.asarray(beats, float) * CELLS).astype(int), 0, len(self.cells) - 1)
        return np.asarray(self.cells[index] * CELLS)

    def stops(self) -> list[float]:
        """Times at which a gap begins."""
        return [span[0] for span in self.silences()]

    def silences(self) -> list[tuple[float, float]]:
        """Start and end of each gap in seconds."""
        return [(float(self.seconds([beat])[0]) - length, float(self.seconds([beat])[0])) for beat, length in self.gaps]


def steady(beats: int, bpm: float) -> Clock:
    """A machine's tempo."""
    return Clock(np.full(beats * CELLS, 60.0 / bpm / CELLS))


def human(rng: Random, beats: int, bpm: float, drift: float = 0.015) -> Clock:
    """A band without a click: the tempo wanders about the wanted one by `drift` (standard deviation, a share)."""
    cells, level, wave = [], rng.gauss(0, drift), rng.uniform(0, 6.28)
    slow = rng.uniform(24, 96)
    hold = 0.97
    for beat in range(beats):
        level = hold * level + math.sqrt(1 - hold * hold) * rng.gauss(0, drift)
        share = 1 + level + 0.5 * drift * math.sin(wave + 6.28 * beat / slow) + rng.gauss(0, 0.15 * drift)
        cells += [60.0 / bpm / CELLS * min(1.25, max(0.8, share))] * CELLS
    return Clock(np.asarray(cells))


def expressive(rng: Random, bars: int, beats_per_bar: int, bpm: float, depth: float = 0.1) -> Clock:
    """A soloist's rubato: arcs over phrases, a ritard at their ends, lingering on some downbeats (Todd's arcs)."""
    shares = np.ones(bars * beats_per_bar * CELLS)
    per_bar = beats_per_bar * CELLS
    bar = 0
    while bar < bars:
        length = min(bars - bar, rng.choice([2, 4, 4, 8]))
        count = length * per_bar
        x = (np.arange(count) + 0.5) / count
        peak = rng.uniform(0.3, 0.7)
        arc = (x - peak) ** 2 / max(peak, 1 - peak) ** 2
        end = np.clip((x - 1 + rng.uniform(0.6, 1.5) / length) * length, 0, None) ** 2
        shares[bar * per_bar : bar * per_bar + count] *= (
            1 - 0.4 * depth + depth * arc * rng.uniform(0.4, 1.1) + depth * end * rng.uniform(0.2, 1.8)
        )
        bar += length
    for bar in range(bars):
        at = bar * per_bar
        if rng.random() < 0.4:
            shares[at : at + CELLS] *= 1 + depth * rng.uniform(0.0, 0.9)
        shares[at : at + per_bar] *= 1 + rng.gauss(0, 0.25 * depth)
    steps = np.asarray([rng.gauss(0, 0.15 * depth) for _ in range(len(shares))])
    return Clock(60.0 / bpm / CELLS * np.clip(shares + steps, 0.55, 2.2))


def change(rng: Random, clock: Clock, beat: int, ratio: float, over: float = 0.0) -> None:
    """From this beat on `ratio` times the tempo, reached at once or over so many beats."""
    start, span = beat * CELLS, max(1, int(over * CELLS))
    rest = len(clock.cells) - start
    if rest <= 0:
        return
    shape = np.clip(np.arange(1, rest + 1) / span, 0, 1) if over else np.ones(rest)
    clock.cells[start:] /= ratio**shape
