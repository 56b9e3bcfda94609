"""RelaySink: the journal goes to the supervisor, line by line, before what it tells of acts."""

import base64
import json
import queue
import threading
from collections import deque

from live.alive.wire import Wire
from live.show.journal_file import with_gap
from live.show.snapshot import Taken


class RelaySink:
    """A `JournalSink`: each line is in another process' hands when `put` comes back.

    Snapshots are sealed by a thread and sent with the next `flush`. Thread: the show's.
    """

    def __init__(self, wire: Wire) -> None:
        self._wire = wire
        self._lines = self._snapshots = self._lost = self._missing = 0
        self._taken: queue.Queue[Taken | None] = queue.Queue(2)
        self._sealed: deque[str] = deque(maxlen=4)
        self._thread = threading.Thread(target=self._seal, name="snapshots", daemon=True)
        self._thread.start()

    def put(self, line: str) -> None:
        """Send one line, without its end."""
        before = self._wire.dropped
        self._wire.put(with_gap(line, self._missing) if self._missing else line)
        self._missing = 0 if self._wire.dropped == before else self._missing + 1
        self._lines += 1

    def snapshot(self, taken: Taken) -> None:
        """Have a snapshot sealed; one that comes too soon after others is left out."""
        try:
            self._taken.put_nowait(taken)
        except queue.Full:
            self._lost += 1

    def flush(self) -> None:
        """Send the snapshots that are sealed by now."""
        while self._sealed:
            self._wire.put(self._sealed.popleft())
            self._snapshots += 1

    def facts(self) -> dict[str, int]:
        """For the status; what becomes of the lines on disk the supervisor knows."""
        return {
            "lines": self._lines,
            "dropped": self._wire.dropped,
            "behind": self._wire.behind,
            "missing": self._missing,
            "snapshots": self._snapshots,
            "snapshots_dropped": self._lost,
        }

    def close(self) -> None:
        """Send what waits."""
        self._taken.put(None)
        self._thread.join(1.0)
        self.flush()
        self._wire.flush()

    def _seal(self) -> None:
        while (taken := self._taken.get()) is not None:
            try:
                data = base64.b64encode(taken.seal()).decode()
            except Exception:  # one snapshot less
                self._lost += 1
                continue
            self._sealed.append(json.dumps({"tick": taken.tick, "snapshot": data}, separators=(",", ":")))
