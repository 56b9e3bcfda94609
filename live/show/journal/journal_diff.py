"""Comparison of two journals: the first differences of headers, events and state hashes."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

from live.control.events.event_json import event_to_json
from live.show.journal.journal_reader import Journal, JournalLine

IGNORED_KEYS = ("patch_path", "recordings", "version", "journal", "columns", "origin", "kernels")
"""Header keys that are not compared, because they do not affect the show."""


@dataclass(frozen=True, slots=True)
class Difference:
    """The first lines that differ, one of each journal; None at the end of a journal."""

    first: JournalLine | None
    second: JournalLine | None

    def in_words(self) -> str:
        """Return both lines in words, on one line."""
        return f"{_words(self.first)}  |  {_words(self.second)}"

    def as_json(self) -> dict[str, Any]:
        """Return both lines as JSON data."""
        return {"first": _facts(self.first), "second": _facts(self.second)}


@dataclass(frozen=True, slots=True)
class Differences:
    """Differences of two journals; header, event and state are empty if the shows are the same."""

    header: tuple[str, ...]
    """Keys of the header; keys of the patch as `patch.name`."""
    event: Difference | None
    state: Difference | None
    events: tuple[int, int]
    measures: tuple[int, int]
    """Number of events and measures in each journal."""

    @property
    def equal(self) -> bool:
        """Whether both journals are of the same show."""
        return not self.header and self.event is None and self.state is None


def differences(first: Journal, second: Journal) -> Differences:
    """Compare two journals line by line, in constant memory."""
    event, events = _first(_events(first), _events(second), _same_event)
    state, measures = _first(_states(first), _states(second), lambda a, b: (a.measure, a.state) == (b.measure, b.state))
    return Differences(tuple(_header(first.header, second.header)), event, state, events, measures)


def _header(first: dict[str, Any], second: dict[str, Any]) -> Iterator[str]:
    for key in sorted(first.keys() | second.keys()):
        a, b = first.get(key), second.get(key)
        if key in IGNORED_KEYS or a == b:
            continue
        if key == "patch" and isinstance(a, dict) and isinstance(b, dict):
            yield from (f"patch.{name}" for name in sorted(a.keys() | b.keys()) if a.get(name) != b.get(name))
        else:
            yield key


def _events(journal: Journal) -> Iterator[JournalLine]:
    return (line for line in journal.lines_with_damage() if line.event is not None)


def _states(journal: Journal) -> Iterator[JournalLine]:
    return (line for line in journal.lines_with_damage() if line.measure is not None)


def _same_event(a: JournalLine, b: JournalLine) -> bool:
    return a.tick == b.tick and a.event == b.event


def _first(first: Iterator[JournalLine], second: Iterator[JournalLine], same: Any) -> tuple[Any, tuple[int, int]]:
    found, count = None, [0, 0]
    for a, b in zip_longest(first, second):
        count[0] += a is not None
        count[1] += b is not None
        if found is None and (a is None or b is None or not same(a, b)):
            found = Difference(a, b)
    return found, (count[0], count[1])


def _words(line: JournalLine | None) -> str:
    if line is None:
        return "end of the journal"
    if line.event is not None:
        values = event_to_json(line.event)
        kind, source = values.pop("type"), values.pop("source")
        return f"line {line.number}, tick {line.tick}: {kind} of {source} {values}"
    return f"line {line.number}, tick {line.tick}: measure {line.measure} {line.state}"


def _facts(line: JournalLine | None) -> dict[str, Any] | None:
    if line is None:
        return None
    if line.event is not None:
        return {"line": line.number, "tick": line.tick, "event": event_to_json(line.event)}
    return {"line": line.number, "tick": line.tick, "measure": line.measure, "hash": line.state}
