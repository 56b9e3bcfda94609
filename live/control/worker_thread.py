"""Worker thread that is restarted after an exception, until its owner stops it."""

import threading
from collections.abc import Callable
from typing import Final

from live.base.fault_isolation import keep_running

STOP_TIMEOUT: Final = 2.0
"""Longest wait for a thread to end [s]; then it is abandoned."""


class WorkerThread:
    """A daemon thread for `work`, see `keep_running`. Thread: the owner's; any may read `stopping`."""

    def __init__(
        self, name: str, work: Callable[[], None], *, part: str = "", every: float | None = None,
        end: Callable[[], None] = lambda: None,
    ) -> None:  # fmt: skip
        """Configure the thread; it is not started yet.

        `work` runs until `stopping` is set. With `every` it is called again and again, with so many seconds in
        between. `end` runs last, in the same thread. `part`: its name in messages, `name` if empty.
        """
        self._name, self._part, self._work, self._every, self._end = name, part or name, work, every, end
        self.stopping = threading.Event()
        """Set when the work has to end."""
        self._thread: threading.Thread | None = None

    @property
    def started(self) -> bool:
        """Whether it was started and not stopped since."""
        return self._thread is not None

    def start(self) -> None:
        """Start the thread."""
        self.stopping.clear()
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._thread.start()

    def stop(self, timeout: float | None = STOP_TIMEOUT) -> bool:
        """Stop the thread and wait for its end; return whether it has ended. Harmless if it was not started."""
        self.stopping.set()
        thread, self._thread = self._thread, None
        if thread is None:
            return True
        thread.join(timeout)
        return not thread.is_alive()

    def _run(self) -> None:
        try:
            keep_running(self._part, self._work if self._every is None else self._repeat, self.stopping.wait)
        finally:
            self._end()

    def _repeat(self) -> None:
        while not self.stopping.wait(self._every):
            self._work()
