"""Precedence: who counts where several set the same thing at once.

An operator's hand comes before a musician's, and a musician's before the audience's: for as long as a hand that sets
something more than once a second is on it, a lower one's values for the same thing wait outside, and are counted.
"""

from collections.abc import Hashable
from typing import Final

HELD: Final = 0.3
"""Seconds for which a value keeps lower ranks away: longer than the pauses of a hand on a fader."""
MOST: Final = 4096


class Precedence:
    """Which rank set what, lately. Thread: one."""

    def __init__(self) -> None:
        self._set: dict[Hashable, tuple[int, float]] = {}
        self.outranked = 0
        """Values that had to give way."""

    def admits(self, key: Hashable, rank: int, now: float) -> bool:
        """Whether a value of `rank` for `key` counts at `now` [s]; if so, it keeps lower ranks away from now on."""
        rank_before, at = self._set.get(key, (rank, now))
        if rank < rank_before and now - at < HELD:
            self.outranked += 1
            return False
        if key not in self._set and len(self._set) >= MOST:
            self._set.clear()
        self._set[key] = (rank, now)
        return True
