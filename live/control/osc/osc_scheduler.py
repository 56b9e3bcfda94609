"""Bounded queue for messages of bundles with a time tag in the future."""

import heapq
from collections.abc import Iterator
from typing import Final, Generic, TypeVar

MAX_DELAY: Final = 2.0
"""Maximum delay [s]."""
MAX_ITEMS: Final = 1024
"""Maximum number of waiting messages."""

Item = TypeVar("Item")


class TimedQueue(Generic[Item]):
    """A queue ordered by time. Use from one thread."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, Item]] = []
        self._count = 0

    def put(self, due: float, now: float, item: Item) -> bool:
        """Keep an item until `due` [s]; False if that is too far ahead or the queue is full."""
        if due - now > MAX_DELAY or len(self._heap) >= MAX_ITEMS:
            return False
        self._count += 1
        heapq.heappush(self._heap, (due, self._count, item))
        return True

    def __len__(self) -> int:
        return len(self._heap)

    def seconds_to_next(self, now: float) -> float | None:
        """Return the seconds until the next item is due; None if the queue is empty."""
        return None if not self._heap else max(self._heap[0][0] - now, 0.0)

    def pop_due(self, now: float) -> Iterator[tuple[float, Item]]:
        """Yield the due items with their times; items of equal time in order of arrival."""
        while self._heap and self._heap[0][0] <= now:
            due, _, item = heapq.heappop(self._heap)
            yield due, item
