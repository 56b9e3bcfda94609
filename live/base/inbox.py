"""Inbox: discrete events from many threads to the one that runs the show, without a lock of ours."""

from collections import deque
from itertools import count
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Inbox(Generic[Item]):
    """Bounded queue with many writers and one reader; when full the oldest item gives way and is counted.

    Thread: `put` from any thread, `drain` and `dropped` from the reader only. `deque.append` with a maximum length
    and `next(count)` are single, atomic operations of the interpreter, which is why no lock is needed.
    """

    def __init__(self, capacity: int = 4096) -> None:
        self._items: deque[Item] = deque(maxlen=capacity)
        self._put = count(1)
        self._put_total = 0
        self._drained = 0

    def put(self, item: Item) -> None:
        """Append one item; never blocks, never raises."""
        self._items.append(item)
        self._put_total = next(self._put)

    def drain(self, limit: int | None = None) -> list[Item]:
        """Take what is there now, oldest first, at most `limit` items (the rest waits for the next frame)."""
        taken: list[Item] = []
        for _ in range(len(self._items) if limit is None else min(limit, len(self._items))):
            try:
                taken.append(self._items.popleft())
            except IndexError:  # a full deque shrank under us: nothing is left to take
                break
        self._drained += len(taken)
        return taken

    def __len__(self) -> int:
        return len(self._items)

    @property
    def dropped(self) -> int:
        """How many items were pushed out unread since the start."""
        return max(0, self._put_total - self._drained - len(self._items))
