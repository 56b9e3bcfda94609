"""RelayedJournal: the journal goes to the supervisor, line by line, before what it tells of acts."""

from pathlib import Path
from typing import Any

from live.alive.wire import Wire
from live.show.journal import JournalWriter
from live.show.snapshot import Taken


class WireSink:
    """A `JournalSink` at whose other end another process writes."""

    def __init__(self, wire: Wire) -> None:
        self._wire = wire
        self._lines = 0

    def put(self, line: str) -> None:
        """Send one line."""
        self._lines += 1
        self._wire.put(line)

    def snapshot(self, taken: Taken) -> None:
        """Snapshots are not relayed."""

    def facts(self) -> dict[str, int]:
        """Nothing is dropped here: only a supervisor who reads no more loses any lines, and says so itself."""
        return {"lines": self._lines, "dropped": 0, "behind": self._wire.behind}

    def close(self) -> None:
        """Send what waits."""
        self._wire.flush()


class RelayedJournal(JournalWriter):
    """Like any journal, but each line is in another process' hands when `event` or `measure` comes back."""

    def __init__(self, wire: Wire, header: dict[str, Any] | None) -> None:
        """`header`: of a show that begins; None: the journal is there, and goes on."""
        super().__init__(Path(), header, sink=WireSink(wire), snapshots=False)
