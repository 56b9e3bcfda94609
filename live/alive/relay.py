"""RelayedJournal: the journal goes to the supervisor, line by line, before what it tells of acts."""

from typing import Any

from live import __version__
from live.alive.wire import Wire
from live.show.journal import FORMAT, JournalWriter


class RelayedJournal(JournalWriter):
    """Like any journal, but each line is in another process' hands when `event` or `measure` comes back."""

    def __init__(self, wire: Wire, header: dict[str, Any] | None) -> None:
        """`header`: of a show that begins; None: the journal is there, and goes on."""
        self.kept = None
        self._wire = wire
        if header is not None:
            self._put({"journal": FORMAT, "version": __version__, **header})

    @property
    def dropped(self) -> int:
        """Lines that could not be sent; only a supervisor who reads no more loses any, and says so itself."""
        return 0

    def close(self, tick: int) -> None:
        """Note the last tick."""
        self._put({"tick": tick, "end": True})
        self._wire.flush()

    def _put(self, line: dict[str, Any]) -> None:
        import json

        self._wire.put(json.dumps(line, separators=(",", ":")))
