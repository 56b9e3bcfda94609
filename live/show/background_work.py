"""Background work that does not delay frames: tasks spread over ticks, and threads that release the GIL often.

A thread that waits for the GIL gets it only after `sys.getswitchinterval()`, 5 ms by default, and a frame has to
reacquire it after every kernel. `short_switch_interval` lowers the interval to 0.1 ms.
"""

import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Final

Task = tuple[float, Callable[[], object]]
"""Weight and function of one piece of work."""

MAX_SHARE: Final = 1.5
"""A tick does a further piece only if its work stays below this multiple of its share."""


class TaskQueue:
    """A queue of pieces of work, done in order, a share of them in each tick."""

    def __init__(self) -> None:
        self._waiting: deque[Task] = deque()
        self.remaining = 0.0
        """Total weight of the waiting pieces."""

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def weights(self) -> list[float]:
        """The weights of the waiting pieces."""
        return [weight for weight, _ in self._waiting]

    def extend(self, pieces: Iterable[Task]) -> None:
        """Append pieces to the queue."""
        self._waiting.extend(pieces)
        self.remaining = sum(weight for weight, _ in self._waiting)

    def insert(self, pieces: Iterable[Task]) -> None:
        """Put pieces before those that wait."""
        self._waiting.extendleft(reversed(list(pieces)))
        self.remaining = sum(weight for weight, _ in self._waiting)

    def run_share(self, ticks: int) -> None:
        """Do this tick's share, with `ticks` left for all pieces, this one included."""
        share, done = self.remaining / max(ticks, 1), 0.0
        while self._waiting and done < share:
            weight = self._waiting[0][0]
            if done and ticks > 1 and done + weight > MAX_SHARE * share:
                return  # a heavy piece gets a tick of its own
            self._do_one()
            done += weight

    def clear(self) -> None:
        """Discard the waiting pieces."""
        self._waiting.clear()
        self.remaining = 0.0

    def run_all(self) -> None:
        """Do all waiting pieces."""
        while self._waiting:
            self._do_one()

    def _do_one(self) -> None:
        weight, piece = self._waiting.popleft()
        self.remaining -= weight
        piece()


SWITCH_INTERVAL_S: Final = 0.0001
"""Switch interval of the interpreter in polite mode [s]. Single calls of compiled code may still take longer."""

_lock = threading.Lock()
_saved_intervals: list[float] = []


@contextmanager
def short_switch_interval() -> Iterator[None]:
    """Lower the interpreter's switch interval within the block; it applies to all threads. Thread: any, several at a
    time."""
    with _lock:
        _saved_intervals.append(sys.getswitchinterval())
        sys.setswitchinterval(min(SWITCH_INTERVAL_S, _saved_intervals[0]))
    try:
        yield
    finally:
        with _lock:
            before = _saved_intervals[0]
            _saved_intervals.pop()
            if not _saved_intervals:
                sys.setswitchinterval(before)


def import_late_modules() -> None:
    """Import what frames may need, but not the first ones, so that no later frame has to: call it beside the show.

    Dancers are assigned to places by scipy.optimize when a formation changes; scipy.spatial finds places at the edges;
    the others are for formations that are like another one, for other numbers of dancers.
    """
    with short_switch_interval():
        import scipy.interpolate
        import scipy.ndimage
        import scipy.optimize
        import scipy.spatial  # noqa: F401
