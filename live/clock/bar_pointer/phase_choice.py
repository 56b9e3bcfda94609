"""Phase choice: how far the beats lie from those of the pointer's grid, as phase cues say, with a hysteresis.

What a network says beat by beat soon outweighs everything else, also where it prefers the off-beats for a whole song.
So the pointer goes on with the grid that the network hears, and the beats are reported some quarters of a beat later,
until the pointer goes over to another grid.
"""

import math
from typing import Final

from live.base.arrays import Float64

SHIFT_ODDS: Final = 0.3
SHIFT_BEATS: Final = 4
"""Beats some quarters later replace the present ones if their score is larger by this at so many beats on end."""
MAX_PHASE_ODDS: Final = 4.0
"""Limit of the odds that the confidence rests on."""
PLACES: Final = 4
"""Places of a beat that are compared: its quarters."""


class PhaseChoice:
    """Where the beats of the present grid lie."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Report the grid's own beats; nothing is known about them."""
        self.offset = 0.0
        """How much later than the grid's the beats are [beats], 0 to 3/4."""
        self.odds = 0.0
        """Log-odds of these beats against others, by phase cues; 0 without any."""
        self._doubted = 0

    def judge(self, scores: Float64) -> int:
        """Return by how many quarters of a beat the beats are later from now on.

        scores (PLACES,): natural logarithms of the probabilities of the present beats and of those one, two and three
        quarters later.
        """
        best = int(scores.argmax())
        self.odds = min(max(float(scores[0] - scores[1:].max()), -MAX_PHASE_ODDS), MAX_PHASE_ODDS)
        self._doubted = self._doubted + 1 if scores[best] > scores[0] + SHIFT_ODDS else 0
        if self._doubted < SHIFT_BEATS:
            return 0
        self.offset = (self.offset + best / PLACES) % 1.0
        self.odds, self._doubted = -self.odds, 0
        return best

    def scale(self, factor: float) -> None:
        """Keep the beats when the grid's tempo is multiplied by `factor`."""
        self.offset = math.fmod(self.offset * factor, 1.0)
        self.odds, self._doubted = 0.0, 0
