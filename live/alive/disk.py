"""Disk: the journal's file, written beside the show and not by it, so that it is whole whatever ends an engine."""

from pathlib import Path

from live.show.journal import keep_aside
from live.show.line_writer import LineWriter


class Disk:
    """Writes the lines of a journal; begun with its first line, so that a start that is refused leaves an old one."""

    def __init__(self, path: Path | None) -> None:
        """`path`: where to; None: nowhere."""
        self._path = path
        self._writer: LineWriter | None = None
        self._notes: list[str] = []

    def put(self, line: str) -> None:
        """One line, without its end; never waits."""
        if self._path is not None and self._writer is None:
            self._open(self._path)
        if self._writer is not None:
            self._writer.put(line)

    def close(self) -> list[str]:
        """Write what waits; what there is to tell the person."""
        if self._writer is not None:
            self._writer.close()
            if self._writer.dropped:
                self._notes.append(
                    f"{self._writer.dropped} lines of the journal could not be written: it will not replay"
                )
        return self._notes

    def _open(self, path: Path) -> None:
        self._path = None
        try:
            kept = keep_aside(path)
            self._writer = LineWriter(path, name="journal")
        except OSError as error:
            self._notes.append(f"the journal {path} could not be written: {error.strerror}")
            return
        if kept is not None:
            self._notes.append(f"the journal that was there is now {kept}")
