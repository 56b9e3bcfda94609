"""Journal: patch, seed and every event with the tick at which it acted, one JSON object a line (T148, T150).

Written by a thread of its own: the show never waits for the disk. When the disk is slow or full, lines are dropped and
counted, and the show goes on.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from live import __version__
from live.control.events import ControlEvent, event_from_json, event_to_json
from live.show.line_writer import LineWriter

FORMAT = 1


class JournalError(Exception):
    """A journal cannot be written or read; the message names file and line."""


def keep_aside(path: Path) -> Path | None:
    """Move a file that is there to the first free of path.1, path.2 …; None if there is none worth keeping."""
    if not path.is_file() or path.stat().st_size == 0:
        return None
    number = 1
    while (kept := path.with_name(f"{path.name}.{number}")).exists():
        number += 1
    path.replace(kept)
    return kept


class JournalWriter:
    """Notes what enters the show; the lines are written by a thread of their own (`LineWriter`).

    Thread: all methods from the show's.
    """

    def __init__(self, path: Path, header: dict[str, Any]) -> None:
        """`header`: what is needed to run the show again. Raises JournalError if the file cannot be made."""
        try:
            self.kept = keep_aside(path)
            """Where a journal of the same name was moved to; None if there was none."""
            self._writer = LineWriter(path, name="journal")
        except OSError as error:
            raise JournalError(f"cannot write the journal {path}: {error.strerror}") from None
        self._put({"journal": FORMAT, "version": __version__, **header})

    @property
    def dropped(self) -> int:
        """Lines lost because the disk did not keep up or refused them."""
        return self._writer.dropped

    def event(self, tick: int, event: ControlEvent) -> None:
        """Note an event that acts from the tick after `tick` on."""
        self._put({"tick": tick, "event": event_to_json(event)})

    def measure(self, tick: int, measure: int, state: str) -> None:
        """Note the state hash at the first tick of a measure (measures from 1)."""
        self._put({"tick": tick, "measure": measure, "hash": state})

    def close(self, tick: int) -> None:
        """Note the last tick, write what waits and close."""
        self._put({"tick": tick, "end": True})
        self._writer.close()

    def _put(self, line: dict[str, Any]) -> None:
        self._writer.put(json.dumps(line, separators=(",", ":")))


@dataclass(frozen=True, slots=True)
class JournalLine:
    """One line after the header: the tick, and an event, a measure's state hash, or the end."""

    tick: int
    event: ControlEvent | None = None
    measure: int | None = None
    state: str | None = None
    end: bool = False


@dataclass(frozen=True, slots=True)
class Journal:
    """A journal that has been read: its header and its lines in order."""

    header: dict[str, Any]
    lines: tuple[JournalLine, ...]
    complete: bool
    """False if the last line was cut off (the machine stopped): everything before it counts."""


def read_journal(path: Path) -> Journal:
    """Read a journal; JournalError names file, line and what was expected. A cut-off last line is tolerated."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise JournalError(f"cannot read the journal {path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise JournalError(f"{path} is not a journal: it is not text") from None
    rows = text.split("\n")
    header = _parse(rows[0], path, 1)
    if header.get("journal") != FORMAT:
        found = f"format {header['journal']!r}" if "journal" in header else "no 'journal' key"
        raise JournalError(f"{path}, line 1: a journal of format {FORMAT} expected, found {found}")
    whole = rows[1:-1]
    lines = tuple(_lines(whole, path))
    return Journal(header, lines, complete=bool(lines) and lines[-1].end and rows[-1] == "")


def _parse(row: str, path: Path, number: int) -> dict[str, Any]:
    try:
        value = json.loads(row)
    except (ValueError, RecursionError):
        raise JournalError(f"{path}, line {number}: not a JSON object") from None
    if not isinstance(value, dict):
        raise JournalError(f"{path}, line {number}: a JSON object expected")
    return value


def _lines(rows: list[str], path: Path) -> Iterator[JournalLine]:
    last = 0
    for number, row in enumerate(rows, start=2):
        value = _parse(row, path, number)
        tick = value.get("tick")
        if not isinstance(tick, int) or isinstance(tick, bool) or tick < last or tick > 1 << 40:
            raise JournalError(f"{path}, line {number}: 'tick' must be a number not below {last}, found {tick!r}")
        last = tick
        if "event" in value:
            try:
                event = event_from_json(value["event"])
            except (ValueError, AttributeError, TypeError) as error:
                raise JournalError(f"{path}, line {number}: {error}") from None
            if not math.isfinite(event.time):
                raise JournalError(f"{path}, line {number}: the event's time is not a number")
            yield JournalLine(tick, event=event)
        elif "measure" in value:
            measure = value["measure"]
            if not isinstance(measure, int) or isinstance(measure, bool):
                raise JournalError(f"{path}, line {number}: 'measure' must be a whole number, found {measure!r}")
            yield JournalLine(tick, measure=measure, state=str(value.get("hash")))
        else:
            yield JournalLine(tick, end=bool(value.get("end")))
