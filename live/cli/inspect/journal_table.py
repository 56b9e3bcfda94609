"""A journal as a table: a row for each event and each measure, for any spreadsheet."""

import csv
import json
from pathlib import Path

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events.event_json import event_to_json
from live.show.journal.journal_reading import Journal

COLUMNS = ("line", "tick", "seconds", "measure", "kind", "source", "values")


def write_table(journal: Journal, out: Path) -> None:
    """Write it row by row; PersonError if that fails. `values` are JSON; a measure's is its hash."""
    try:
        with out.open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(COLUMNS)
            measure = 1
            for line in journal.usable():
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
