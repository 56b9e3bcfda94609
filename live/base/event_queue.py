"""Inbox: discrete events from many threads to the one that runs the show, without a lock of ours.

Lane: what one sender (a port, a gateway) has for the thread that runs the show, beside the lanes of others.

Who floods a lane pushes out only what is in it. Of items with a key, which say what something is from now on, those
that nobody has taken yet give way to a later one of the same key: the last counts, however many there are.

Precedence: who counts where several set the same thing at once.

An operator's hand comes before a musician's, and a musician's before the audience's: for as long as a hand that sets
something more than once a second is on it, a lower one's values for the same thing wait outside, and are counted.
"""

from collections import deque
from collections.abc import Hashable
from heapq import heapify, heappop, heapreplace
from itertools import count
from typing import Final, Generic, TypeVar

MOST_KEYS: Final = 4096
FLOOD: Final = 512.0
"""Items a second of one sender: as many as act of all."""

Item = TypeVar("Item")


class Place(Generic[Item]):
    """Where an item waits. The writer reads `taken` after it has written, the reader writes it before it reads."""

    __slots__ = ("item", "key", "taken")

    def __init__(self, item: Item, key: Hashable) -> None:
        self.item, self.key = item, key
        self.taken = False


class Lane(Generic[Item]):
    """Bounded queue with one writer and one reader; when full the oldest item gives way and is counted.

    Thread: `put` from one thread, `take` from another; single operations of a deque are atomic in the interpreter,
    which is why there is no lock that a frame might wait for. Items without a key keep their order, and what was put
    after one is taken after it; of items with different keys the order does not matter.
    """

    def __init__(self, capacity: int = 4096, rank: int = 0) -> None:
        """`rank`: where lanes set the same thing at once, that of the higher one counts (`Precedence`)."""
        self.rank = rank
        self.turn = 0
        """Which round of the reader's it is served in next; the reader's alone (`Inbox`)."""
        self._places: deque[Place[Item]] = deque(maxlen=capacity)
        self._open: dict[Hashable, Place[Item]] = {}  # the writer's alone
        self._appended = 0
        self._taken = 0
        self.floods = False
        """Whether more came lately than anybody can take; the reader's alone."""
        self._judged, self._judged_at = 0, 0.0
        self.thinned = 0
        """Items that whoever writes has left out for later ones before they came here."""
        self.replaced = 0
        """Items that gave way to a later one of their key."""

    def put(self, item: Item, key: Hashable = None, *, after: bool = False) -> None:
        """Append one item; never blocks, never raises. `after`: its order to those before does matter."""
        if key is None or after:
            self._open.clear()
        if key is not None:
            place = self._open.get(key)
            if place is not None and not place.taken:
                place.item = item
                if not place.taken:  # else nobody knows whether the reader has seen it: it comes once more
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
        """Whether the oldest item is one that a later one of its key may replace while it waits."""
        try:
            return self._places[0].key is not None
        except IndexError:
            return False

    @property
    def offered(self) -> int:
        """How many items there were for this lane since the start."""
        return self._appended + self.replaced + self.thinned

    def judge(self, now: float) -> None:
        """See whether so many items a second come that this is a flood."""
        came = self._appended + self.replaced
        self.floods = came - self._judged > FLOOD * (now - self._judged_at)
        self._judged, self._judged_at = came, now

    def take(self) -> Item | None:
        """The oldest item; None if there is none."""
        place = self.take_place()
        return None if place is None else place.item

    def take_place(self) -> Place[Item] | None:
        """The oldest item with its key; None if there is none."""
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
        """How many items were pushed out unread since the start."""
        return max(0, self._appended - self._taken - len(self._places))


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


JUDGE_EVERY: Final = 0.25
"""Seconds over which is judged who floods."""
WEIGHT: Final = 8


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
