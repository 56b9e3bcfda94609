"""Clerk: writes by a thread of its own what the show hands over, so that the show never waits for the disk."""

import contextlib
import queue
import threading
from typing import Generic, TypeVar

from live.base.fault_isolation import FAULTS

Item = TypeVar("Item")


class Clerk(Generic[Item]):
    """Thread: `put` and `close` from the show's thread; `_write` and `_finish`, which a file defines, run in its own.

    When the disk is slow or full, things are dropped and counted.
    """

    def __init__(self, name: str, capacity: int) -> None:
        """Begin; `name` is the thread's, and `capacity` things may wait for the disk."""
        self._waiting: queue.Queue[Item | None] = queue.Queue(capacity)
        self._ends = False
        self.dropped = 0
        """Things lost because the disk did not keep up or refused them."""
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def put(self, item: Item) -> bool:
        """Hand over one thing; never waits. False if it is lost, for too many wait."""
        try:
            self._waiting.put_nowait(item)
        except queue.Full:
            self.dropped += 1
            return False
        return True

    @property
    def behind(self) -> int:
        """Things that wait for the disk."""
        return self._waiting.qsize()

    def close(self) -> None:
        """Write what waits and close; gives up on a stuck disk after two seconds."""
        try:
            self._waiting.put(None, timeout=1.0)
        except queue.Full:
            return
        self._thread.join(2.0)

    def end(self) -> bool:
        """Have it write what waits and close, and do not wait for that; whether it has. To be called until it has."""
        if not self._ends:
            with contextlib.suppress(queue.Full):
                self._waiting.put_nowait(None)
                self._ends = True
        return not self._thread.is_alive()

    def _run(self) -> None:
        try:
            self._begin()
        except OSError:
            self.dropped += 1
        while (item := self._waiting.get()) is not None:
            try:
                self._write(item)
            except OSError:
                self.dropped += 1
            except Exception as error:  # one thing that cannot be written must not be the last one
                self.dropped += 1
                FAULTS.note(f"the writer of the {self._thread.name}", error)
        try:
            self._finish()
        except OSError:
            self.dropped += 1

    def _begin(self) -> None:
        """What is to be done first, by the same thread."""

    def _write(self, item: Item) -> None:
        raise NotImplementedError

    def _finish(self) -> None:
        raise NotImplementedError
