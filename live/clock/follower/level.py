"""Level: which beats of a source are danced: all, every second one, or also those between, and how far off."""

import math

from live.clock.grid import Grid

FACTORS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Danced beats for one of the source."""


class Level:
    """The affine map from a source's beats to danced ones: exact, and without drift however long it runs.

    danced = (beat - pivot_in) * factor + pivot_out.
    """

    def __init__(self) -> None:
        self.factor = 1.0
        self._pivot_in = 0.0
        self._pivot_out = 0.0

    def danced(self, beat: float) -> float:
        """The danced beat for a beat of the source."""
        return (beat - self._pivot_in) * self.factor + self._pivot_out

    def grid(self, grid: Grid) -> Grid:
        """The grid of danced beats for one of the source's."""
        danced = self.danced(float(grid.number))
        number = math.floor(danced)
        period = grid.period / self.factor
        return Grid(grid.time - (danced - number) * period, period, number)

    def scale(self, factor: float, danced: float) -> bool:
        """`factor` times as many danced beats; the beat `danced` is one in both. False if that is beyond bounds."""
        if self.factor * factor not in FACTORS:
            return False
        self._pivot_in += (danced - self._pivot_out) / self.factor
        self._pivot_out = danced
        self.factor *= factor
        return True

    def shift(self, beats: float) -> None:
        """Danced beats lie so many beats later."""
        self._pivot_out -= beats

    def straighten(self) -> None:
        """Danced beats lie on the source's again."""
        self._pivot_in = math.floor(self._pivot_in + 0.5)
        self._pivot_out = math.floor(self._pivot_out + 0.5)

    def reset(self, beat: float, danced: float) -> None:
        """Every beat is danced; the numbers go on from `danced`, which is where the source's `beat` is now."""
        self.factor = 1.0
        self._pivot_in = math.floor(beat)
        self._pivot_out = math.floor(danced - (beat - self._pivot_in) + 0.5)

    def pin(self, beat: float, danced: float, factor: float) -> None:
        """`factor` danced beats for one of the source, whose `beat` is the danced beat `danced`."""
        self.factor, self._pivot_in, self._pivot_out = factor, beat, danced

    def fold(self, tempo: float, lowest: float, highest: float) -> None:
        """Halve or double what is danced of a source of `tempo` [bpm] into the range, where that can be."""
        while tempo * self.factor > highest and self.factor > FACTORS[0] and tempo * self.factor / 2.0 >= lowest:
            self.scale(0.5, self._pivot_out)
        while tempo * self.factor < lowest and self.factor < FACTORS[-1] and tempo * self.factor * 2.0 <= highest:
            self.scale(2.0, self._pivot_out)
