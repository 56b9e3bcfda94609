"""Lane: what one sender (a port, a gateway) has for the thread that runs the show, beside the lanes of others.

Who floods a lane pushes out only what is in it. Of items with a key, which say what something is from now on, those
that nobody has taken yet give way to a later one of the same key: the last counts, however many there are.
"""

from collections import deque
from collections.abc import Hashable
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
