"""Checks of the measures in the journal of a show whose processes failed."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from live.show.journal.line_writer import GAP_KEY
from live.show.journal.skipped_events import SKIPPED_KEY


@dataclass(slots=True)
class MeasureStatistics:
    """Statistics of the measures of a journal."""

    begun: int = 0
    twice: list[int] = field(default_factory=list)
    """Measures that began again."""
    missed: list[int] = field(default_factory=list)
    """Measures that never began, without skipped ticks or missing lines."""
    leapt: list[int] = field(default_factory=list)
    """Measures in skipped ticks."""
    lacking: list[int] = field(default_factory=list)
    """Measures whose lines could not be written."""
    skipped: int = 0
    """Number of skipped ticks."""
    lost: int = 0
    """Number of lines that could not be written, as recorded in the journal."""
    left_out: int = 0
    tripped: list[str] = field(default_factory=list)
    """Stages disabled by circuit breakers."""
    ended: bool = False

    def facts(self) -> dict[str, Any]:
        """Return the fields for a report."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


def read_measures(path: Path) -> MeasureStatistics:
    """Read the measure lines of a journal. Raises OSError if it does not exist."""
    found = MeasureStatistics()
    last: int | None = None
    skipped = gap = 0
    with path.open(encoding="utf-8", errors="replace") as file:
        next(file, "")
        for row in file:
            try:
                line = json.loads(row)
            except ValueError:
                continue
            if not isinstance(line, dict):
                continue
            missing = line.get(GAP_KEY, 0)
            found.lost += missing
            gap += missing
            found.left_out += line.get(SKIPPED_KEY, 0)
            found.ended = found.ended or bool(line.get("end"))
            event = line.get("event")
            if isinstance(event, dict):
                if event.get("type") == "TicksSkipped":
                    skipped += event.get("count", 0)
                    found.skipped += event.get("count", 0)
                elif event.get("type") == "BreakerTripped":
                    found.tripped.append(str(event.get("name")))
            if "measure" in line and "event" not in line:
                number = int(line["measure"])
                if last is not None:
                    _classify(found, last, number, skipped, gap)
                found.begun += 1
                last, skipped, gap = number, 0, 0
    return found


def _classify(found: MeasureStatistics, last: int, number: int, skipped: int, gap: int) -> None:
    if number <= last:
        found.twice.append(number)
        return
    between = list(range(last + 1, number))
    if gap:
        found.lacking += between
    elif skipped:
        found.leapt += between
    else:
        found.missed += between
