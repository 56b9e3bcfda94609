"""Lights: which few of many voices are seen on the projector, in turn, so that everybody sees her own at some time."""

from collections import deque
from collections.abc import Callable
from typing import Final

STAYS: Final = 8.0
"""A voice is seen for so long [s] while others wait."""


class Lights:
    """Rows of voices that are seen. Thread: one."""

    def __init__(self, most: int) -> None:
        self.most = most
        self._since: dict[int, float] = {}
        self._waiting: deque[int] = deque()

    @property
    def seen(self) -> list[int]:
        """Rows that are seen, longest first."""
        return list(self._since)

    def keep(self, speaks: Callable[[int], bool]) -> None:
        """Who does not speak any more is not seen."""
        for row in [row for row in self._since if not speaks(row)]:
            del self._since[row]

    def choose(self, speaking: list[int], now: float) -> None:
        """Who speaks at `now` [s]: those seen go on being seen for a while, the others wait for a place."""
        there = set(speaking)
        self._since = {row: since for row, since in self._since.items() if row in there}
        self._waiting = deque(row for row in self._waiting if row in there)
        known = {*self._since, *self._waiting}
        self._waiting.extend(row for row in speaking if row not in known)
        for row, since in list(self._since.items()):
            waiting = len(self._waiting) - max(self.most - len(self._since), 0)
            if len(self._since) > self.most or (waiting > 0 and now - since > STAYS):
                del self._since[row]
                self._waiting.append(row)
        while self._waiting and len(self._since) < self.most:
            self._since[self._waiting.popleft()] = now
