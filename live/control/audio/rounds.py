"""Rounds: a thread that looks after a device, and another one in its place when it hangs in the sound system."""

import threading
from collections.abc import Callable
from typing import Final

from live.base.fault_isolation import keep_running
from live.clock.time_source import Clock

POLL: Final = 0.010
"""Seconds from round to round."""

HUNG_AFTER: Final = 10.0
"""A thread that has not come round for so many seconds hangs; a restart leaves it behind."""

ENDS_WITHIN: Final = 2.0
"""Seconds that a thread may take to end before it is left to itself."""


class Rounds:
    """Calls `turn` again and again, and `end` at last, in a thread of its own.

    Whoever hung and comes back finds that `mine` is another's now, and ends without a word.
    """

    def __init__(self, name: str, clock: Clock, turn: Callable[[], None], end: Callable[[], None]) -> None:
        """Nothing is begun yet."""
        self._name, self._clock, self._turn, self._end = name, clock, turn, end
        self.mine = threading.Event()
        """Stands for the thread that is in force; set when it is to end. To be kept while the sound system is asked."""
        self.thread: threading.Thread | None = None
        self.round_at = 0.0
        """When it last came round [s]."""

    @property
    def hangs(self) -> bool:
        """Whether the thread has not come round for long."""
        return self.thread is not None and self._clock.now() - self.round_at > HUNG_AFTER

    def begin(self) -> None:
        """A thread begins; one that there is is left behind."""
        self.mine.set()
        self.mine = threading.Event()
        self.round_at = self._clock.now()
        self.thread = threading.Thread(target=self._run, args=(self.mine,), name=self._name, daemon=True)
        self.thread.start()

    def stop(self) -> None:
        """End; a thread that hangs is left to itself."""
        self.mine.set()
        if self.thread is not None:
            self.thread.join(timeout=ENDS_WITHIN)
            self.thread = None

    def _run(self, mine: threading.Event) -> None:
        def rounds() -> None:
            while not mine.wait(POLL):
                self.round_at = self._clock.now()
                self._turn()

        try:
            keep_running(self._name, rounds, mine.wait)
        finally:
            if mine is self.mine:
                self._end()
