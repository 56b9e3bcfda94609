"""Later: messages of bundles whose time tag lies ahead wait here for their moment, so many and so long at most."""

import heapq
from collections.abc import Iterator
from typing import Final, Generic, TypeVar

HORIZON: Final = 2.0
"""Seconds ahead that are waited for."""
MOST: Final = 1024
"""Messages that wait at most."""

Item = TypeVar("Item")


class Later(Generic[Item]):
    """A queue by time. Thread: one."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, Item]] = []
        self._count = 0

    def put(self, due: float, now: float, item: Item) -> bool:
        """Keep an item until `due` [s]; False if that is too far, or too many wait."""
        if due - now > HORIZON or len(self._heap) >= MOST:
            return False
        self._count += 1
        heapq.heappush(self._heap, (due, self._count, item))
        return True

    def __len__(self) -> int:
        return len(self._heap)

    def wait(self, now: float) -> float | None:
        """Seconds until the next is due; None if nothing waits."""
        return None if not self._heap else max(self._heap[0][0] - now, 0.0)

    def due(self, now: float) -> Iterator[tuple[float, Item]]:
        """What is due now, with its time; of one time in the order in which it came."""
        while self._heap and self._heap[0][0] <= now:
            due, _, item = heapq.heappop(self._heap)
            yield due, item
