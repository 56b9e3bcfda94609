"""Journal sink that sends each line to the supervisor before its event is applied, or writes the file itself."""

import base64
import json
import queue
import threading
from collections import deque
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from live.show.journal.journal_writer import SNAPSHOT_SUFFIX, JournalFile
from live.show.journal.line_writer import UnfinishedFile, WriteProgress, with_gap
from live.supervisor.recovery_log import SealedSnapshot
from live.supervisor.supervisor_link import SupervisorLink

if TYPE_CHECKING:
    from live.show.state.snapshot import CapturedSnapshot


MAX_KEPT_LINES: Final = 65536
"""Most lines kept until they are confirmed as written; beyond that the oldest are dropped."""


class RelaySink:
    """A `JournalSink`: `put` returns once the supervisor's channel has the line.

    Lines are kept until the supervisor confirms that they are written. If it dies, a thread of this process continues
    the journal in its file, and nothing is lost. A supervisor that adopts this engine continues it again. Snapshots are
    sealed by a thread and sent with the next `flush`. Thread: the show's.
    """

    def __init__(self, lifeline: SupervisorLink, path: Path | None = None) -> None:
        """`path`: file to which the supervisor writes the journal; None: none."""
        self._link, self._channel, self._path = lifeline, lifeline.channel, path
        self._lines = self._snapshots = self._lost = self._missing = self._lines_lost = 0
        self._unwritten: deque[tuple[int, str]] = deque()
        self._file: JournalFile | None = None
        self._ending_file: JournalFile | None = None
        self._adoption_pending = False  # the new supervisor waits until this process has stopped writing
        self._number = 0
        self._snapshot_queue: queue.Queue[CapturedSnapshot | None] = queue.Queue(2)
        self._sealed: deque[tuple[str, bytes]] = deque(maxlen=4)
        self._thread = threading.Thread(target=self._seal, name="snapshots", daemon=True)
        self._thread.start()
        lifeline.on_adopted = self._on_adopted

    def put(self, line: str) -> None:
        """Send one line, without its line end."""
        self._lines += 1
        self._link.log.add_own_line(line)
        if self._channel.ended:
            self._write(line)
            return
        before = self._channel.dropped
        text = with_gap(line, self._missing) if self._missing else line
        self._channel.send_line(text)
        if self._channel.dropped != before:
            self._missing += 1
            return
        self._missing = 0
        self._keep(self._channel.sent, text)

    def snapshot(self, taken: "CapturedSnapshot") -> None:
        """Queue a snapshot for sealing; it is dropped if the queue is full."""
        try:
            self._snapshot_queue.put_nowait(taken)
        except queue.Full:
            self._lost += 1

    def flush(self) -> None:
        """Send the snapshots that are sealed by now and drop the lines that are written. Called once per frame."""
        if self._channel.ended:
            self._begin_file()
        elif self._adoption_pending and (self._ending_file is None or self._ending_file.request_close()):
            self._adoption_pending, self._ending_file = False, None
            self._channel.send_json(alive="journal")
        self._drop_written()
        while self._sealed:
            line, data = self._sealed.popleft()
            self._link.log.add_own_line(line)
            if self._file is not None:
                self._file.snapshot(SealedSnapshot(data))
            elif not self._channel.ended:
                self._channel.send_line(line)
            self._snapshots += 1

    def facts(self) -> dict[str, int]:
        """Return figures for the status. If there is a supervisor, it counts the lines on disk."""
        facts = {
            "lines": self._lines,
            "dropped": self._channel.dropped,
            "behind": self._channel.pending_bytes,
            "missing": self._missing,
            "snapshots": self._snapshots,
            "snapshots_dropped": self._lost,
        }
        if self._file is None:
            return facts
        there = self._file.facts()
        return facts | {
            "dropped": facts["dropped"] + there["dropped"] + self._lines_lost,
            "behind": there["behind"],
            "missing": there["missing"],
        }

    def close(self) -> None:
        """Send everything pending."""
        self._snapshot_queue.put(None)
        self._thread.join(1.0)
        self.flush()
        for file in (self._file, self._ending_file):
            if file is not None:
                file.close()
        self._channel.flush()

    # -- lines the supervisor has not written yet ------------------------------------------------------------------

    def _keep(self, number: int, line: str) -> None:
        if self._path is None:
            return
        if len(self._unwritten) >= MAX_KEPT_LINES:
            self._unwritten.popleft()
            self._lines_lost += 1
        self._unwritten.append((number, line))

    def _drop_written(self) -> None:
        """Drop the lines that are written."""
        if self._file is not None and (there := self._file.written) is not None:
            self._link.written, self._link.snapshots_kept = there
        done = self._link.written
        while done is not None and self._unwritten and self._unwritten[0][0] <= done.number:
            self._unwritten.popleft()

    # -- without a supervisor ------------------------------------------------------------------------------------

    def _begin_file(self) -> None:
        """Continue the journal where the supervisor stopped, however much of it has reached the disk."""
        if self._file is not None or self._path is None:
            return
        if self._ending_file is not None and not self._ending_file.request_close():
            return  # tried again with the next frame or line
        self._ending_file = None
        beside = self._path.with_name(self._path.name + SNAPSHOT_SUFFIX)
        kept = self._link.snapshots_kept
        self._file = JournalFile(self._path, beside, unwritten=self._unwritten_rest(), kept=kept)

    def _unwritten_rest(self) -> UnfinishedFile:
        self._drop_written()  # use the supervisor's last confirmation
        return UnfinishedFile(self._link.log.header, self._link.written or WriteProgress(), list(self._unwritten))

    def _write(self, line: str) -> None:
        self._number = max(self._number, self._channel.sent) + 1
        self._keep(self._number, line)
        if self._file is not None:
            self._file.put(line, self._number)
        else:
            self._begin_file()

    def _on_adopted(self) -> UnfinishedFile:
        """Return the lines that the new supervisor has to write; some may reach the disk before this process stops
        writing."""
        rest = self._unwritten_rest()
        self._adoption_pending = True
        self._ending_file, self._file = self._file or self._ending_file, None
        self._unwritten = deque((0, line) for _, line in self._unwritten)
        self._link.written = replace(rest.written, number=-1)
        return rest

    def _seal(self) -> None:
        while (taken := self._snapshot_queue.get()) is not None:
            try:
                data = taken.seal()
            except Exception:  # drop this snapshot
                self._lost += 1
                continue
            text = base64.b64encode(data).decode()
            line = json.dumps({"tick": taken.tick, "snapshot": text}, separators=(",", ":"))
            self._sealed.append((line, data))
