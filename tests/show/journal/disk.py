"""Waiting for journal writes, for tests that run a show faster than real time."""

from live.show.journal.journal import JournalWriter
from live.show.journal.journal_writer import JournalFile
from tests.control.waiting import wait_for


def wait_until_written(writer: JournalWriter) -> None:
    """Wait until all queued lines are written; returns at once without files."""
    sink = writer.sink
    if not isinstance(sink, JournalFile):
        return
    assert wait_for(lambda: sink._lines.behind == 0 and (sink._snapshots is None or sink._snapshots.behind == 0), 10)
