"""Beat estimates of audio trackers, and their consensus, which is robust against octave errors and outliers."""

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.timeline import Grid

Samples = npt.NDArray[np.float32]
"""Audio of one channel, shape (n,), full scale = 1."""


@dataclass(frozen=True, slots=True)
class BeatEstimate:
    """One beat as estimated by a tracker; `position` and `fed` are seconds from the first sample fed."""

    position: float
    """Time of the beat [s]; if it is later than `fed`, it is a prediction."""
    period: float
    """Seconds to the next beat."""
    confidence: float
    """Confidence of the tracker, 0 to 1."""
    fed: float
    """Seconds of audio fed when the estimate was made."""
    beat: int = -1
    """Beat of its measure, from 0; -1 if unknown."""
    beats_per_measure: int = 0
    """0 if unknown."""
    runner_up: int = 0
    """By how many beats later measures would begin on the most likely other line; 0 if unknown."""
    runner_up_share: float = 0.0
    """Probability of that line by what was heard in the last measures, 0 to 1."""
    replaces: float = math.nan
    """The earlier position of the same beat, if this estimate corrects it [s]; else NaN."""


MEMORY: Final = 6.0
"""Seconds for which an estimate is kept."""

FADE: Final = 2.5
"""Time constant of an estimate's weight [s]: it falls to 1/e."""

PERIOD_MIN: Final = 60.0 / 240.0
PERIOD_MAX: Final = 60.0 / 40.0
"""Bounds of beat periods for dancing [s]: 240 to 40 bpm."""

PERIOD_TOLERANCE: Final = 0.06
"""Periods that differ less than this (natural logarithm) are the same tempo."""

PHASE_TOLERANCE: Final = 0.12
"""Beats at this distance from a grid (in beats) support it with a weight of 1/e."""

PRIOR_FLOOR: Final = 0.1
"""Weight of the least expected tempo: enough to be used if there is no other."""

METRICAL_LEVELS: Final = (
    (1.0, 1.0, 1.0),
    (2.0, 1.0, 0.4),
    (0.5, 0.5, 0.4),
    (3.0, 1.0, 0.2),
    (1.0 / 3.0, 1.0 / 3.0, 0.2),
)
"""(estimate's period / grid's period, lines it may lie on [beats], weight): a tracker may report every second beat, or
every half beat, and still be right about the positions of beats.
"""


@dataclass(frozen=True, slots=True)
class WeightedBeat:
    """One estimate: a beat at `time` [s], `period` [s], `weight` 0 to 1."""

    time: float
    period: float
    weight: float


@dataclass(frozen=True, slots=True)
class TempoPrior:
    """Prior over tempi: a bell in octaves around `tempo` [bpm] over a floor, so that no tempo is excluded."""

    tempo: float = 118.0
    octaves: float = 0.8

    def weight(self, period: float) -> float:
        """Return the weight of a period [s], `PRIOR_FLOOR` to 1."""
        return max(math.exp(-0.5 * (math.log2(60.0 / period / self.tempo) / self.octaves) ** 2), PRIOR_FLOOR)


class Consensus:
    """The estimates of the last seconds, and their agreement with grids."""

    def __init__(self) -> None:
        self._estimates: deque[WeightedBeat] = deque(maxlen=32)
        self.half_beats = False
        """Whether beats half a beat off support a grid (after a tap has decided which of the two is the beat)."""

    def clear(self) -> None:
        """Remove all estimates."""
        self._estimates.clear()

    def add(self, estimate: WeightedBeat, now: float) -> None:
        """Add an estimate; drop those older than `MEMORY`."""
        self._estimates.append(estimate)
        while now - self._estimates[0].time > MEMORY:
            self._estimates.popleft()

    def __len__(self) -> int:
        return len(self._estimates)

    def _match(self, grid: Grid, heard: WeightedBeat) -> tuple[float, float]:
        """Return (how well one estimate's beat lies on a grid, weight of its metrical level), both 0 to 1."""
        for ratio, division, worth in METRICAL_LEVELS:
            if abs(math.log(heard.period / (grid.period * ratio))) < PERIOD_TOLERANCE:
                if self.half_beats:
                    division = min(division, 0.5)
                return math.exp(-((grid.residual(heard.time, division) / PHASE_TOLERANCE) ** 2)), worth
        return 0.0, 0.0

    def support(self, grid: Grid, now: float) -> tuple[float, float]:
        """Return (summed support of all estimates for a grid, share of them that agrees with it at any metrical
        level)."""
        total = agreed = support = 0.0
        for heard in self._estimates:
            weight = heard.weight * math.exp((heard.time - now) / FADE)
            match, worth = self._match(grid, heard)
            total += weight
            agreed += weight * match
            support += weight * match * worth
        return support, agreed / total if total > 0.0 else 0.0

    def supporting_estimates(self, grid: Grid) -> list[WeightedBeat]:
        """Return the estimates that clearly support a grid, oldest first."""
        return [heard for heard in self._estimates if self._match(grid, heard)[0] >= 0.4]

    def candidates(self) -> list[Grid]:
        """Return the grids that the newest estimates propose, with their octaves."""
        grids: list[Grid] = []
        for heard in list(self._estimates)[-6:]:
            for factor in (1.0, 0.5, 2.0):
                if PERIOD_MIN <= heard.period * factor <= PERIOD_MAX:
                    grids.append(self.fit(Grid(heard.time, heard.period * factor), heard.time))
        return grids

    def fit(self, grid: Grid, now: float) -> Grid:
        """Return the grid fitted to the estimates that support it (weighted least squares).

        The periods of these estimates constrain the slope, weighted as four more beats.
        """
        rows: list[tuple[float, float, float]] = []
        weight_sum = period_sum = 0.0
        for heard in self._estimates:
            match, worth = self._match(grid, heard)
            weight = match * worth * heard.weight * math.exp((heard.time - now) / FADE)
            if weight < 1e-6:
                continue
            division = 0.5 if self.half_beats else 1.0
            ratio = min(METRICAL_LEVELS, key=lambda row: abs(math.log(heard.period / (grid.period * row[0]))))
            division = min(division, ratio[1])
            late = grid.residual(heard.time, division)
            rows.append((weight, (heard.time - grid.time) / grid.period - late, late))
            weight_sum += weight
            period_sum += weight * heard.period / ratio[0]
        if not rows:
            return grid
        mean_k = sum(w * k for w, k, _ in rows) / weight_sum
        mean_late = sum(w * late for w, _, late in rows) / weight_sum
        spread = sum(w * (k - mean_k) ** 2 for w, k, _ in rows)
        slope = sum(w * (k - mean_k) * (late - mean_late) for w, k, late in rows)
        hold = 4.0 * weight_sum
        stretch = (slope + hold * (period_sum / weight_sum / grid.period - 1.0)) / (spread + hold)
        shift = mean_late - stretch * mean_k
        period = min(max(grid.period * (1.0 + stretch), PERIOD_MIN), PERIOD_MAX)
        return Grid(grid.time + shift * grid.period, period, grid.number)
