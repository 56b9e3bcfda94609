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

MAX_OPEN_KEYS: Final = 4096
FLOOD_RATE: Final = 512.0
"""Items a second of one sender above which it floods: as many as are processed of all senders."""

Item = TypeVar("Item")


class QueueSlot(Generic[Item]):
    """A slot for one waiting item. The writer reads `taken` after writing, the reader sets it before reading."""

    __slots__ = ("is_read", "item", "key")

    def __init__(self, item: Item, key: Hashable) -> None:
        self.item, self.key = item, key
        self.is_read = False


class PriorityQueue(Generic[Item]):
    """Bounded queue with one writer and one reader; when full, the oldest item is dropped and counted.

    Thread: `put` from one thread, `pop` from another. Single operations of a deque are atomic in the interpreter, so
    no lock is needed that a frame might wait for. Items without a key keep their order, also relative to the items put
    after them; the order of items with different keys does not matter.
    """

    def __init__(self, capacity: int = 4096, rank: int = 0) -> None:
        """`rank`: if lanes set the same thing at once, the highest rank wins (`Precedence`)."""
        self.rank = rank
        self.next_round = 0
        """The reader's round in which it is served next; used by the reader only (`EventQueue`)."""
        self._slots: deque[QueueSlot[Item]] = deque(maxlen=capacity)
        self._open: dict[Hashable, QueueSlot[Item]] = {}  # used by the writer only
        self._appended = 0
        self._popped = 0
        self.is_flooding = False
        """Whether more items came lately than can be processed; used by the reader only."""
        self._measured, self._measured_at = 0, 0.0
        self.coalesced = 0
        """Items that the writer replaced by later ones before putting them here."""
        self.replaced = 0
        """Items that were replaced by a later one of their key."""

    def put(self, item: Item, key: Hashable = None, *, ordered: bool = False) -> None:
        """Append one item; never blocks, never raises. `ordered`: its order relative to earlier items matters."""
        if key is None or ordered:
            self._open.clear()
        if key is not None:
            place = self._open.get(key)
            if place is not None and not place.is_read:
                place.item = item
                if not place.is_read:  # the reader may have read the old item: append this one too
                    self.replaced += 1
                    return
            if len(self._open) >= MAX_OPEN_KEYS:
                self._open.clear()
        fresh = QueueSlot(item, key)
        if key is not None:
            self._open[key] = fresh
        self._slots.append(fresh)
        self._appended += 1

    @property
    def head_has_key(self) -> bool:
        """Whether the oldest item has a key, so that a later one may replace it while it waits."""
        try:
            return self._slots[0].key is not None
        except IndexError:
            return False

    @property
    def received_count(self) -> int:
        """Number of items sent to this lane since the start."""
        return self._appended + self.replaced + self.coalesced

    def update_flooding(self, now: float) -> None:
        """Update `is_flooding` from the number of items since the last call."""
        came = self._appended + self.replaced
        self.is_flooding = came - self._measured > FLOOD_RATE * (now - self._measured_at)
        self._measured, self._measured_at = came, now

    def pop(self) -> Item | None:
        """Remove and return the oldest item; None if there is none."""
        place = self.pop_slot()
        return None if place is None else place.item

    def pop_slot(self) -> QueueSlot[Item] | None:
        """Remove and return the oldest item with its key; None if there is none."""
        try:
            place = self._slots.popleft()
        except IndexError:
            return None
        place.is_read = True
        self._popped += 1
        return place

    def __len__(self) -> int:
        return len(self._slots)

    @property
    def dropped(self) -> int:
        """Number of items dropped unread since the start."""
        return max(0, self._appended - self._popped - len(self._slots))


PRECEDENCE_HOLD: Final = 0.3
"""Seconds for which a value blocks lower ranks: longer than the pauses of a hand on a fader."""
MAX_PRECEDENCE_KEYS: Final = 4096


class Precedence:
    """Records which rank last set each value, and rejects lower ranks for a while. Thread: one."""

    def __init__(self) -> None:
        self._set: dict[Hashable, tuple[int, float]] = {}
        self.outranked = 0
        """Number of rejected values."""

    def accepts(self, key: Hashable, rank: int, now: float) -> bool:
        """Whether a value of `rank` for `key` is accepted at `now` [s]; if so, it blocks lower ranks from now on."""
        rank_before, at = self._set.get(key, (rank, now))
        if rank < rank_before and now - at < PRECEDENCE_HOLD:
            self.outranked += 1
            return False
        if key not in self._set and len(self._set) >= MAX_PRECEDENCE_KEYS:
            self._set.clear()
        self._set[key] = (rank, now)
        return True


FLOOD_WINDOW: Final = 0.25
"""Seconds over which floods are measured."""
FLOOD_WEIGHT: Final = 8


class EventQueue(Generic[Item]):
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
        self._queues: list[PriorityQueue[Item]] = []
        self._round = 0
        self._measured_at = 0.0
        self._precedence = Precedence()

    def add_queue(self, capacity: int = 4096, rank: int = 0) -> PriorityQueue[Item]:
        """Add a lane for one sender that might send very much, so that other senders are still served.

        `rank`: if several lanes set the same thing at the same time, the highest rank wins.
        """
        self._queues.append(PriorityQueue(capacity, rank))
        return self._queues[-1]

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
        if self._queues:
            self._drain_queues(taken, limit, now, values)
        return taken

    def _drain_queues(
        self, taken: list[tuple[Hashable, Item]], limit: int | None, now: float, values: int | None
    ) -> None:
        """Add items from the lanes, one of each in turn (start-time fair queuing).

        A lane with few items lately comes before all lanes with long queues; a flooding lane is served `WEIGHT` times
        less
        often.
        """
        if now - self._measured_at >= FLOOD_WINDOW:
            self._measured_at = now
            for lane in self._queues:
                lane.update_flooding(now)
        waiting = [
            (max(lane.next_round, self._round - 1), at, lane) for at, lane in enumerate(self._queues) if len(lane)
        ]
        heapify(waiting)
        while waiting and (limit is None or len(taken) < limit):
            turn, at, lane = waiting[0]
            if values is not None and lane.head_has_key:
                if values <= 0:  # it waits, and so do the items put after it
                    heappop(waiting)
                    continue
                values -= 1
            place = lane.pop_slot()
            if place is None:
                heappop(waiting)
                continue
            self._round, lane.next_round = max(turn, self._round), turn + (FLOOD_WEIGHT if lane.is_flooding else 1)
            heapreplace(waiting, (lane.next_round, at, lane))
            if place.key is None or self._precedence.accepts(place.key, lane.rank, now):
                taken.append((place.key, place.item))

    def __len__(self) -> int:
        return len(self._items) + sum(map(len, self._queues))

    @property
    def received_count(self) -> int:
        """Number of items sent to lanes since the start."""
        return sum(lane.received_count for lane in self._queues)

    @property
    def dropped(self) -> int:
        """Number of items dropped unread since the start."""
        own = max(0, self._put_total - self._drained - len(self._items))
        return own + sum(lane.dropped for lane in self._queues)

    @property
    def outranked(self) -> int:
        """Number of values rejected in favour of a higher rank."""
        return self._precedence.outranked
