"""Event queue from many threads to the show's thread, without locks, with one bounded lane per sender.

A flood in a lane pushes out only that lane's items. An unread item with a key is replaced by a later one of the same
key, so only the last value counts.

If several senders set the same thing, the higher rank wins: operator before musician before audience. For `HELD`
seconds after a higher rank has set a value, lower ranks' values for it are rejected and counted.
"""

from collections import deque
from collections.abc import Hashable
from heapq import heapify, heappop, heapreplace
from itertools import count
from typing import Final, Generic, TypeVar

MOST_KEYS: Final = 4096
FLOOD: Final = 512.0
"""Items a second of one sender above which it floods: as many as are processed of all senders."""

Item = TypeVar("Item")


class Place(Generic[Item]):
    """A slot for one waiting item. The writer reads `taken` after writing, the reader sets it before reading."""

    __slots__ = ("item", "key", "taken")

    def __init__(self, item: Item, key: Hashable) -> None:
        self.item, self.key = item, key
        self.taken = False


class Lane(Generic[Item]):
    """Bounded queue with one writer and one reader; when full, the oldest item is dropped and counted.

    Thread: `put` from one thread, `take` from another. Single operations of a deque are atomic in the interpreter, so
    no lock is needed that a frame might wait for. Items without a key keep their order, also relative to the items put
    after them; the order of items with different keys does not matter.
    """

    def __init__(self, capacity: int = 4096, rank: int = 0) -> None:
        """`rank`: if lanes set the same thing at once, the highest rank wins (`Precedence`)."""
        self.rank = rank
        self.turn = 0
        """The reader's round in which it is served next; used by the reader only (`Inbox`)."""
        self._places: deque[Place[Item]] = deque(maxlen=capacity)
        self._open: dict[Hashable, Place[Item]] = {}  # used by the writer only
        self._appended = 0
        self._taken = 0
        self.floods = False
        """Whether more items came lately than can be processed; used by the reader only."""
        self._judged, self._judged_at = 0, 0.0
        self.thinned = 0
        """Items that the writer replaced by later ones before putting them here."""
        self.replaced = 0
        """Items that were replaced by a later one of their key."""

    def put(self, item: Item, key: Hashable = None, *, after: bool = False) -> None:
        """Append one item; never blocks, never raises. `after`: its order relative to earlier items matters."""
        if key is None or after:
            self._open.clear()
        if key is not None:
            place = self._open.get(key)
            if place is not None and not place.taken:
                place.item = item
                if not place.taken:  # the reader may have read the old item: append this one too
                    self.replaced += 1
                    return
            if len(self._open) >= MOST_KEYS:
                self._open.clear()
        fresh = Place(item, key)
        if key is not None:
            self._open[key] = fresh
        self._places.append(fresh)
        self._appended += 1

    @property
    def offers_value(self) -> bool:
        """Whether the oldest item has a key, so that a later one may replace it while it waits."""
        try:
            return self._places[0].key is not None
        except IndexError:
            return False

    @property
    def offered(self) -> int:
        """Number of items sent to this lane since the start."""
        return self._appended + self.replaced + self.thinned

    def judge(self, now: float) -> None:
        """Update `floods` from the number of items since the last call."""
        came = self._appended + self.replaced
        self.floods = came - self._judged > FLOOD * (now - self._judged_at)
        self._judged, self._judged_at = came, now

    def take(self) -> Item | None:
        """Remove and return the oldest item; None if there is none."""
        place = self.take_place()
        return None if place is None else place.item

    def take_place(self) -> Place[Item] | None:
        """Remove and return the oldest item with its key; None if there is none."""
        try:
            place = self._places.popleft()
        except IndexError:
            return None
        place.taken = True
        self._taken += 1
        return place

    def __len__(self) -> int:
        return len(self._places)

    @property
    def dropped(self) -> int:
        """Number of items dropped unread since the start."""
        return max(0, self._appended - self._taken - len(self._places))


HELD: Final = 0.3
"""Seconds for which a value blocks lower ranks: longer than the pauses of a hand on a fader."""
MOST: Final = 4096


class Precedence:
    """Records which rank last set each value, and rejects lower ranks for a while. Thread: one."""

    def __init__(self) -> None:
        self._set: dict[Hashable, tuple[int, float]] = {}
        self.outranked = 0
        """Number of rejected values."""

    def admits(self, key: Hashable, rank: int, now: float) -> bool:
        """Whether a value of `rank` for `key` is accepted at `now` [s]; if so, it blocks lower ranks from now on."""
        rank_before, at = self._set.get(key, (rank, now))
        if rank < rank_before and now - at < HELD:
            self.outranked += 1
            return False
        if key not in self._set and len(self._set) >= MOST:
            self._set.clear()
        self._set[key] = (rank, now)
        return True


JUDGE_EVERY: Final = 0.25
"""Seconds over which floods are measured."""
WEIGHT: Final = 8


class Inbox(Generic[Item]):
    """Bounded queue with many writers and one reader; when full, the oldest item is dropped and counted.

    Items put here are drained before the items in lanes.

    Thread: `put` from any thread, `drain` and `dropped` from the reader only. `deque.append` with a maximum length
    and `next(count)` are single, atomic operations of the interpreter, so no lock is needed.
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
        """Add a lane for one sender that might send very much, so that other senders are still served.

        `rank`: if several lanes set the same thing at the same time, the highest rank wins.
        """
        self._lanes.append(Lane(capacity, rank))
        return self._lanes[-1]

    def put(self, item: Item) -> None:
        """Append one item; never blocks, never raises."""
        self._items.append(item)
        self._put_total = next(self._put)

    def drain(self, limit: int | None = None, now: float = 0.0) -> list[Item]:
        """Remove and return the items at `now` [s], oldest first, at most `limit` (the rest waits for the next
        frame)."""
        return [item for _, item in self.drain_keyed(limit, now)]

    def drain_keyed(
        self, limit: int | None = None, now: float = 0.0, values: int | None = None
    ) -> list[tuple[Hashable, Item]]:
        """As `drain`, with each item's key or None; at most `values` items that have a key."""
        taken: list[tuple[Hashable, Item]] = []
        for _ in range(len(self._items) if limit is None else min(limit, len(self._items))):
            try:
                taken.append((None, self._items.popleft()))
            except IndexError:  # another thread emptied the deque
                break
        self._drained += len(taken)
        if self._lanes:
            self._drain_lanes(taken, limit, now, values)
        return taken

    def _drain_lanes(
        self, taken: list[tuple[Hashable, Item]], limit: int | None, now: float, values: int | None
    ) -> None:
        """Add items from the lanes, one of each in turn (start-time fair queuing).

        A lane with few items lately comes before all lanes with long queues; a flooding lane is served `WEIGHT` times
        less
        often.
        """
        if now - self._judged_at >= JUDGE_EVERY:
            self._judged_at = now
            for lane in self._lanes:
                lane.judge(now)
        waiting = [(max(lane.turn, self._round - 1), at, lane) for at, lane in enumerate(self._lanes) if len(lane)]
        heapify(waiting)
        while waiting and (limit is None or len(taken) < limit):
            turn, at, lane = waiting[0]
            if values is not None and lane.offers_value:
                if values <= 0:  # it waits, and so do the items put after it
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
        """Number of items sent to lanes since the start."""
        return sum(lane.offered for lane in self._lanes)

    @property
    def dropped(self) -> int:
        """Number of items dropped unread since the start."""
        own = max(0, self._put_total - self._drained - len(self._items))
        return own + sum(lane.dropped for lane in self._lanes)

    @property
    def outranked(self) -> int:
        """Number of values rejected in favour of a higher rank."""
        return self._precedence.outranked
