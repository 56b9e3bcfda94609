"""Reader for journals, line by line in constant memory, and a survey of a journal's figures."""

import contextlib
import json
import math
from array import array
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, TextIO

from live.base.compression import json_value_bound
from live.clock.ticks import TICK
from live.control.events.event import ControlEvent
from live.control.events.event_json import event_from_json
from live.control.events.events import TicksSkipped
from live.show.journal.line_writer import GAP_KEY
from live.show.journal.old_events import LAST_OLD_FORMAT, upgrade_event
from live.show.journal.skipped_events import Gap, skipped_gaps

FORMAT: Final = 3
"""Current format. Format 1 had no snapshots, and wrote default values; 2 had other events (`old_events`)."""
READABLE_FORMATS: Final = (1, 2, 3)
MAX_LINE: Final = 1 << 24
"""Maximum length of a line in characters, so that a file that is not a journal is not read into memory."""
MAX_VALUES: Final = 1 << 20
"""Maximum number of JSON values in a line, for the same reason."""


MAX_TICK_GAP: Final = 64 * 600
"""Maximum number of ticks between two lines (ten minutes); measures are recorded more often."""


@dataclass(frozen=True, slots=True)
class EventForms:
    """How the events of a journal are written: the columns of rows by type, and whether it is an older format."""

    columns: dict[str, list[str]]
    old: bool

    def read(self, value: Any) -> ControlEvent:
        """Return an event; ValueError for an unknown type or field or a wrong value."""
        if self.old:
            if isinstance(value, list) and value and value[0] in self.columns:
                value = {"type": value[0], **dict(zip(self.columns[value[0]], value[1:], strict=False))}
            if isinstance(value, dict):
                value = upgrade_event(value)
        return event_from_json(value, self.columns)


class JournalError(Exception):
    """A journal that cannot be written or read; the message names file and line."""


@dataclass(frozen=True, slots=True)
class JournalLine:
    """A line after the header: a tick with an event, a measure's state hash, or the end."""

    tick: int
    event: ControlEvent | None = None
    measure: int | None = None
    state: str | None = None
    end: bool = False
    skipped: bool = False
    """Whether the event was skipped in crash recovery: it must not be applied."""
    number: int = 0
    """Line number in the file, from 1."""
    damaged: str | None = None
    """Description of the damage, if the line could not be read or lines are lost before it."""


@dataclass(frozen=True, slots=True)
class Journal:
    """A journal with its header in memory; its lines are read from the file at each access."""

    path: Path
    header: dict[str, Any]

    @property
    def patch(self) -> dict[str, Any]:
        """The patch in the header; empty if it is damaged."""
        patch = self.header.get("patch")
        return patch if isinstance(patch, dict) else {}

    @property
    def _forms(self) -> EventForms:
        columns = self.header.get("columns")
        old = self.header.get("journal", 0) <= LAST_OLD_FORMAT
        return EventForms(columns if isinstance(columns, dict) else {}, old)

    @property
    def lines(self) -> Iterator[JournalLine]:
        """Its lines in order; JournalError at the first damaged one. A truncated last line is ignored."""
        for line in self.lines_with_damage():
            if line.damaged is not None:
                raise JournalError(line.damaged)
            yield line

    def lines_with_damage(self) -> Iterator[JournalLine]:
        """Yield its lines in order; damaged ones have `damaged` set and the tick of the line before."""
        with self.path.open(encoding="utf-8", errors="replace") as file:
            _read_row(file)
            yield from _lines(file, self.path, self._forms, skipped_gaps(self.path))

    def lines_containing(self, *words: str) -> Iterator[JournalLine]:
        """Yield its undamaged lines that contain one of these words; fast, because only these are parsed."""
        with self.path.open(encoding="utf-8", errors="replace") as file:
            _read_row(file)
            number = 1
            while (row := _read_row(file)) is not None:
                number += 1
                if any(word in row for word in words):
                    with contextlib.suppress(JournalError, ValueError, TypeError, OverflowError):
                        value = _parse(row, self.path, number)
                        yield _line(value, self.path, number, min(int(value.get("tick", 0)), 1 << 40), self._forms)

    @property
    def last_tick(self) -> int:
        """The tick of its last complete line; 0 if none can be read."""
        for row in reversed(self._tail()[:-1]):
            with contextlib.suppress(JournalError, ValueError, TypeError, KeyError):
                return int(_parse(row.decode("utf-8", "replace"), self.path, 0)["tick"])
        return 0

    @property
    def seconds(self) -> float | None:
        """Exact length [s] of a show that was rendered as a film; None for others."""
        for row in self._tail()[-2:-1] if self.complete else ():
            with contextlib.suppress(JournalError):
                seconds = _parse(row.decode("utf-8", "replace"), self.path, 0).get("seconds")
                if isinstance(seconds, int | float) and not isinstance(seconds, bool) and 0.0 < seconds < 1e9:
                    return float(seconds)
        return None

    def _tail(self) -> list[bytes]:
        """Return its last rows; the last one is empty if the file is complete."""
        with self.path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(max(0, size - (1 << 16)))
            return file.read().split(b"\n")

    @property
    def complete(self) -> bool:
        """Whether it has an end line; without one (the machine stopped) the lines are valid all the same."""
        last = self._tail()
        return len(last) > 1 and last[-1] == b"" and b'"end":true' in last[-2].replace(b" ", b"")


def read_journal(path: Path) -> Journal:
    """Open a journal and read its header; JournalError names the file and what was expected."""
    try:
        with path.open(encoding="utf-8") as file:
            row = _read_row(file) or ""
            file.read(1 << 16)
    except OSError as error:
        raise JournalError(f"cannot read the journal {path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise JournalError(f"{path} is not a journal: it is not text") from None
    header = _parse(row, path, 1)
    if header.get("journal") not in READABLE_FORMATS:
        found = f"format {header['journal']!r}" if "journal" in header else "no 'journal' key"
        raise JournalError(
            f"{path}, line 1: a journal of format {' or '.join(map(str, READABLE_FORMATS))} expected, found {found}"
        )
    return Journal(path, header)


def _read_row(file: TextIO) -> str | None:
    """Return the next line without its line break; None after the last one and for a truncated one."""
    row = file.readline(MAX_LINE)
    return row[:-1] if row.endswith("\n") else None


def _parse(row: str, path: Path, number: int) -> dict[str, Any]:
    if json_value_bound(row) > MAX_VALUES:
        raise JournalError(f"{path}, line {number}: more values than a line may have")
    try:
        value = json.loads(row)
    except (ValueError, RecursionError):
        raise JournalError(f"{path}, line {number}: not a JSON object") from None
    if not isinstance(value, dict):
        raise JournalError(f"{path}, line {number}: a JSON object expected")
    return value


def _lines(file: TextIO, path: Path, forms: EventForms, gaps: Sequence[Gap]) -> Iterator[JournalLine]:
    last, number, lost = 0, 1, 0
    while (row := _read_row(file)) is not None:
        number += 1
        try:
            value = _parse(row, path, number)
            missing = _missing(value)
            line = _line(value, path, number, last, forms, far=missing > 0)
        except JournalError as error:
            yield JournalLine(last, number=number, damaged=str(error))
            continue
        now = value.get("lost", lost)
        if now != lost:
            words = f"{path}, line {number}: lines before it could not be written, {now} in total"
            yield JournalLine(last, number=number, damaged=words)
            lost = now
        if missing:
            words = f"{path}, line {number}: {missing} lines are missing before it; they could not be written"
            yield JournalLine(last, number=number, damaged=words)
        for gap in gaps:
            if gap.inserted and number == gap.first:
                yield _inserted_event(gap, path, last, forms)
        last = line.tick
        over = [gap for gap in gaps if gap.first <= number <= gap.mark]
        if over:
            state = None if any(number < gap.mark for gap in over) else line.state
            line = replace(line, skipped=any(number in gap.events for gap in over), state=state)
        yield line
        if isinstance(line.event, TicksSkipped):
            last += line.event.count


def _inserted_event(gap: Gap, path: Path, last: int, forms: EventForms) -> JournalLine:
    """Return the event that was inserted before a stretch that was simulated again."""
    try:
        value = _parse(gap.inserted, path, gap.mark) | {"tick": max(gap.ticks[0], last)}
        return _line(value, path, gap.mark, last, forms)
    except JournalError as error:
        return JournalLine(last, number=gap.mark, damaged=str(error))


def _missing(value: dict[str, Any]) -> int:
    """Return the number of lines missing before this one, as recorded in it."""
    count = value.get(GAP_KEY, 0)
    return count if isinstance(count, int) else 0


def _line(
    value: dict[str, Any], path: Path, number: int, last: int, forms: EventForms, *, far: bool = False
) -> JournalLine:
    """Return the parsed line. `far`: any distance to the line before is valid."""
    tick = value.get("tick")
    if not isinstance(tick, int) or isinstance(tick, bool) or tick < last or tick > 1 << 40:
        raise JournalError(f"{path}, line {number}: 'tick' must be a number not below {last}, found {tick!r}")
    if tick - last > MAX_TICK_GAP and not far:
        raise JournalError(f"{path}, line {number}: damaged: its tick {tick} is far after {last}")
    if "event" in value:
        try:
            event = forms.read(value["event"])
        except (ValueError, AttributeError, TypeError) as error:
            raise JournalError(f"{path}, line {number}: {error}") from None
        if not math.isfinite(event.time):
            raise JournalError(f"{path}, line {number}: the event's time is not a number")
        return JournalLine(tick, event=event, number=number)
    if "measure" in value:
        measure = value["measure"]
        if not isinstance(measure, int) or isinstance(measure, bool) or not 0 <= measure <= 1 << 40:
            raise JournalError(f"{path}, line {number}: 'measure' must be a whole number, found {measure!r:.80}")
        return JournalLine(tick, measure=measure, state=str(value.get("hash")), number=number)
    return JournalLine(tick, end=bool(value.get("end")), number=number)


MAX_PROBLEMS = 1000
"""Maximum number of problems kept in words; all are counted."""


@dataclass(slots=True)
class Survey:
    """Figures of one journal, with the ticks of its measures and events."""

    journal: Journal
    ticks: int = 0
    """The tick of the last line."""
    skipped: int = 0
    """Ticks skipped in stalls."""
    measure_tick: "array[int]" = field(default_factory=lambda: array("q"))
    """First tick of each measure."""
    measure: "array[int]" = field(default_factory=lambda: array("q"))
    """Number of each measure, from 1."""
    events: "dict[tuple[str, str], array[int]]" = field(default_factory=dict)
    """Ticks of the events, by source and type."""
    damaged: int = 0
    problems: list[str] = field(default_factory=list)

    @property
    def seconds(self) -> float:
        """Length of the show [s]."""
        return self.ticks * TICK

    @property
    def counts(self) -> Counter[tuple[str, str]]:
        """Number of events by source and type."""
        return Counter({key: len(ticks) for key, ticks in self.events.items()})

    def tempo(self) -> list[tuple[int, float]]:
        """Return tick and mean tempo [bpm] of each complete measure, in the patch's metre."""
        clock = self.journal.patch.get("clock")
        beats = clock.get("beats_per_measure") if isinstance(clock, dict) else None
        beats = beats if isinstance(beats, int) and 2 <= beats <= 12 else 4
        rows = zip(self.measure_tick, self.measure_tick[1:], self.measure, self.measure[1:], strict=False)
        return [
            (begin, 60.0 * beats * (number - first) / ((end - begin) * TICK))
            for begin, end, first, number in rows
            if end > begin and number > first
        ]


def survey(journal: Journal) -> Survey:
    """Survey a journal in one pass."""
    found = Survey(journal)
    for line in journal.lines_with_damage():
        found.ticks = max(found.ticks, line.tick)
        if line.damaged is not None:
            found.damaged += 1
            if len(found.problems) < MAX_PROBLEMS:
                found.problems.append(line.damaged)
        elif line.event is not None:
            key = line.event.source, type(line.event).__name__
            found.events.setdefault(key, array("q")).append(line.tick)
            if isinstance(line.event, TicksSkipped):
                found.skipped += line.event.count
        elif line.measure is not None:
            found.measure_tick.append(line.tick)
            found.measure.append(line.measure)
    return found
