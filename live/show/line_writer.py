"""LineWriter: lines of text into a file by a thread of its own, so that the show never waits for the disk."""

import queue
import threading
from pathlib import Path

CAPACITY = 65536
"""Lines that may wait for the disk."""


class LineWriter:
    """Takes lines from the show's thread; when the disk is slow or full, lines are dropped and counted.

    Thread: `put` and `close` from the show's thread; the file is touched only by the writer's own, after the start.
    """

    def __init__(self, path: Path, *, name: str, more: bool = False) -> None:
        """Raises OSError if the file cannot be made; `name` is the thread's; `more`: behind what the file holds."""
        self._file = path.open("a" if more else "w", encoding="utf-8")
        self._lines: queue.Queue[str | None] = queue.Queue(CAPACITY)
        self.dropped = 0
        """Lines lost because the disk did not keep up or refused them."""
        self.lines, self.bytes = 0, 0
        """Lines taken, and bytes written, since the start."""
        self._thread = threading.Thread(target=self._write, name=name, daemon=True)
        self._thread.start()

    def put(self, line: str) -> None:
        """Hand over one line, without its end; never waits."""
        try:
            self._lines.put_nowait(line)
            self.lines += 1
        except queue.Full:
            self.dropped += 1

    @property
    def behind(self) -> int:
        """Lines that wait for the disk."""
        return self._lines.qsize()

    def close(self) -> None:
        """Write what waits and close; gives up on a stuck disk after two seconds."""
        try:
            self._lines.put(None, timeout=1.0)
        except queue.Full:
            return
        self._thread.join(2.0)

    def _write(self) -> None:
        while (line := self._lines.get()) is not None:
            try:
                self._file.write(line + "\n")
                self.bytes += len(line) + 1
                if self._lines.empty():
                    self._file.flush()
            except OSError:
                self.dropped += 1
        try:
            self._file.close()
        except OSError:
            self.dropped += 1
