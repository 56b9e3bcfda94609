"""Reports of `live journal`: figures of a journal, and its events and measures as a table."""

import csv
import json
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events.event_json import event_to_json
from live.show.journal.journal_reader import Journal, JournalError, Survey, read_journal
from live.show.journal.journal_writer import read_snapshots
from live.show.journal.replay import snapshots_of
from live.show.state.snapshot import snapshot_header

COLUMNS: Final = ("line", "tick", "seconds", "measure", "kind", "source", "values")


def read_journal_file(path: Path) -> Journal:
    """Read a journal; raise PersonError if that fails."""
    try:
        return read_journal(path)
    except JournalError as error:
        raise PersonError(str(error)) from None


def journal_facts(found: Survey) -> dict[str, Any]:
    """Return the figures of a journal for JSON: show, duration, measures, tempo, events, snapshots, problems."""
    header, problems = found.journal.header, list(found.problems)
    path = snapshots_of(found.journal)
    measures = [snapshot_header(data)["measure"] for data in read_snapshots(path, problems)]
    tempo = [bpm for _, bpm in found.tempo()]
    return {
        "journal": str(found.journal.path),
        "format": header.get("journal"),
        "version": header.get("version"),
        "show": found.journal.patch.get("name"),
        "seed": header.get("seed"),
        "complete": found.journal.complete,
        "seconds": found.seconds,
        "skipped_ticks": found.skipped,
        "measures": len(found.measure),
        "bpm": [min(tempo), max(tempo)] if tempo else None,
        "events": [{"source": s, "type": t, "count": n} for (s, t), n in found.counts.most_common()],
        "bytes": found.journal.path.stat().st_size,
        "snapshots": {"measures": measures, "bytes": path.stat().st_size if path.is_file() else 0},
        "damaged": found.damaged,
        "problems": problems,
    }


def write_table(journal: Journal, out: Path) -> None:
    """Write the journal as CSV; raise PersonError if that fails. `values` are JSON; a measure's is its state hash."""
    try:
        with out.open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(COLUMNS)
            measure = 1
            for line in journal.lines_with_damage():
                row: tuple[str, str, str] | None = None
                if line.damaged is not None:
                    row = "damaged", "", line.damaged
                elif line.event is not None:
                    values = event_to_json(line.event)
                    kind, source = values.pop("type"), values.pop("source")
                    row = kind, source, json.dumps(values, ensure_ascii=False)
                elif line.measure is not None:
                    measure = line.measure
                    row = "measure", "", line.state or ""
                if row is not None:
                    table.writerow((line.number, line.tick, f"{line.tick * TICK:.6f}", measure, *row))
    except OSError as error:
        raise PersonError(f"{out}: cannot be written: {error.strerror}", "choose another folder") from None
