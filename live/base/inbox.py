"""Inbox: discrete events from many threads to the one that runs the show, without a lock of ours."""

from collections import deque
from collections.abc import Hashable
from heapq import heapify, heappop, heapreplace
from itertools import count
from typing import Final, Generic, TypeVar

from live.base.lane import Lane
from live.base.precedence import Precedence

JUDGE_EVERY: Final = 0.25
"""Seconds over which is judged who floods."""
WEIGHT: Final = 8

Item = TypeVar("Item")


class Inbox(Generic[Item]):
    """Bounded queue with many writers and one reader; when full the oldest item gives way and is counted.

    What is put here comes before what is in the lanes.

    Thread: `put` from any thread, `drain` and `dropped` from the reader only. `deque.append` with a maximum length
    and `next(count)` are single, atomic operations of the interpreter, which is why no lock is needed.
    """

    def __init__(self, capacity: int = 4096) -> None:
        self._items: deque[Item] = deque(maxlen=capacity)
        self._put = count(1)
        self._put_total = 0
        self._drained = 0
        self._lanes: list[Lane[Item]] = []
        self._round = 0
        self._judged_at = 0.0
        self._precedence = Precedence()

    def lane(self, capacity: int = 4096, rank: int = 0) -> Lane[Item]:
        """A lane of its own for somebody who might send very much: others are heard all the same.

        `rank`: what is set in a lane of a higher one counts, whoever else sets it at the same time.
        """
        self._lanes.append(Lane(capacity, rank))
        return self._lanes[-1]

    def put(self, item: Item) -> None:
        """Append one item; never blocks, never raises."""
        self._items.append(item)
        self._put_total = next(self._put)

    def drain(self, limit: int | None = None, now: float = 0.0) -> list[Item]:
        """Take what is there at `now` [s], oldest first, at most `limit` items (the rest waits for the next frame)."""
        return [item for _, item in self.drain_keyed(limit, now)]

    def drain_keyed(
        self, limit: int | None = None, now: float = 0.0, values: int | None = None
    ) -> list[tuple[Hashable, Item]]:
        """As `drain`, with the key of each item that has one, else None; at most `values` of those that have one."""
        taken: list[tuple[Hashable, Item]] = []
        for _ in range(len(self._items) if limit is None else min(limit, len(self._items))):
            try:
                taken.append((None, self._items.popleft()))
            except IndexError:  # a full deque shrank under us: nothing is left to take
                break
        self._drained += len(taken)
        if self._lanes:
            self._drain_lanes(taken, limit, now, values)
        return taken

    def _drain_lanes(
        self, taken: list[tuple[Hashable, Item]], limit: int | None, now: float, values: int | None
    ) -> None:
        """Add what the lanes have, one item of each in turn (start-time fair queuing); who has said little lately comes
        before all who have much waiting, however many those are, and who floods is `WEIGHT` times as seldom in turn."""
        if now - self._judged_at >= JUDGE_EVERY:
            self._judged_at = now
            for lane in self._lanes:
                lane.judge(now)
        waiting = [(max(lane.turn, self._round - 1), at, lane) for at, lane in enumerate(self._lanes) if len(lane)]
        heapify(waiting)
        while waiting and (limit is None or len(taken) < limit):
            turn, at, lane = waiting[0]
            if values is not None and lane.offers_value:
                if values <= 0:  # it waits, and what was put after it as well
                    heappop(waiting)
                    continue
                values -= 1
            place = lane.take_place()
            if place is None:
                heappop(waiting)
                continue
            self._round, lane.turn = max(turn, self._round), turn + (WEIGHT if lane.floods else 1)
            heapreplace(waiting, (lane.turn, at, lane))
            if place.key is None or self._precedence.admits(place.key, lane.rank, now):
                taken.append((place.key, place.item))

    def __len__(self) -> int:
        return len(self._items) + sum(map(len, self._lanes))

    @property
    def offered(self) -> int:
        """How many items there were for lanes since the start."""
        return sum(lane.offered for lane in self._lanes)

    @property
    def dropped(self) -> int:
        """How many items were pushed out unread since the start."""
        own = max(0, self._put_total - self._drained - len(self._items))
        return own + sum(lane.dropped for lane in self._lanes)

    @property
    def outranked(self) -> int:
        """Values that gave way to somebody of a higher rank."""
        return self._precedence.outranked
