"""Pieces: work that is spread over ticks, so much in each that it is done in time."""

from collections import deque
from collections.abc import Callable, Iterable
from typing import Final

Piece = tuple[float, Callable[[], object]]
"""A piece of the work, after what it weighs."""

MORE: Final = 1.5
"""A tick takes a further piece only if it does not come to more than so many times its share."""


class Pieces:
    """A row of pieces, done in their order."""

    def __init__(self) -> None:
        self._waiting: deque[Piece] = deque()
        self.left = 0.0
        """What those that wait weigh together."""

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def weights(self) -> list[float]:
        """What each that waits weighs."""
        return [weight for weight, _ in self._waiting]

    def begin(self, pieces: Iterable[Piece]) -> None:
        """These are to be done, after those that wait."""
        self._waiting.extend(pieces)
        self.left = sum(weight for weight, _ in self._waiting)

    def work(self, ticks: int) -> None:
        """Do this tick's share, if so many `ticks` are left for all, this one included."""
        share, done = self.left / max(ticks, 1), 0.0
        while self._waiting and done < share:
            weight = self._waiting[0][0]
            if done and ticks > 1 and done + weight > MORE * share:
                return  # rather in the next tick than together with others in this one
            self._do_one()
            done += weight

    def clear(self) -> None:
        """Forget all that is left."""
        self._waiting.clear()
        self.left = 0.0

    def finish(self) -> None:
        """Do all that is left."""
        while self._waiting:
            self._do_one()

    def _do_one(self) -> None:
        weight, piece = self._waiting.popleft()
        self.left -= weight
        piece()
