"""A disk that keeps up: a show that runs faster than life waits for it now and then, as no show on a stage has to."""

from live.show.journal.journal import JournalWriter
from live.show.journal.journal_writer import JournalFile
from tests.control.waiting import wait_for


def settled(writer: JournalWriter) -> None:
    """Everything handed over is written; without files nothing is waited for."""
    sink = writer.sink
    if not isinstance(sink, JournalFile):
        return
    assert wait_for(lambda: sink._lines.behind == 0 and (sink._snapshots is None or sink._snapshots.behind == 0), 10)
