"""What a show left out when it went on calmer: events that are in its journal and did not act after all.

After too many crashes another engine goes on without the last events, for one of them may be the cause (`live.alive`).
They had been noted before they acted, so the journal has them. A line after them says how many of the last do not
count: `{"tick":6400,"left_out":3}`. Measures that began between the first of them and that line have hashes of what no
longer holds; nobody compares these.
"""

import json
import re
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

LEFT_OUT: Final = "left_out"
SINCE: Final = "since"
"""Of an event that acted at an earlier tick than that of its line: what was danced since was danced anew."""
LONGEST: Final = 1 << 26
"""Characters of a line at most, as for who reads the journal."""
MOST: Final = 65536
"""Events that one such line can mean; two seconds have far fewer."""
MOST_ANEW: Final = 256
"""Stages that were put out of service so; each takes three engines."""
TICK_OF: Final = re.compile(r'"tick":\s*(\d{1,13})')
KEPT: Final = "TicksSkipped"
"""Never left out: it only says how ticks are counted."""


@dataclass(frozen=True, slots=True)
class Gap:
    """Events that do not count, by their lines in the file (from 1)."""

    first: int
    """The line of the first of them."""
    mark: int
    """The line that says so."""
    events: frozenset[int]
    ticks: tuple[int, int]
    """Of the first of them and of that line."""
    anew: str = ""
    """The line of an event that acts at the first of these ticks, whose own line it is that says so."""

    def holds(self, tick: int) -> bool:
        """Whether a state taken after that tick is one that no longer holds."""
        return self.ticks[0] < tick <= self.ticks[1]


def can_be_left_out(event: object) -> bool:
    """Whether an event, as it is in the journal, may be left out."""
    return not (isinstance(event, dict) and event.get("type") == KEPT)


def left_out_line(tick: int, count: int) -> dict[str, Any]:
    """The line that says: the last `count` events before this tick did not act."""
    return {"tick": tick, LEFT_OUT: count}


def without_the_last(lines: Sequence[tuple[int, str]], count: int) -> list[tuple[int, str]]:
    """Lines, each with its tick, without the last `count` events and the measures noted since the first of them."""
    kept: list[tuple[int, str]] = []
    for tick, line in reversed(lines):
        event = _is_event(line)
        if count <= 0 or not (event or '"measure"' in line):
            kept.append((tick, line))
        elif event:
            count -= 1
    return kept[::-1]


def left_out(path: Path) -> list[Gap]:
    """All that a journal says of events that do not count; quick: only the lines that say so are looked into."""
    most, anew = 0, list[tuple[int, int, str]]()
    for number, row in _rows(path):
        if f'"{LEFT_OUT}"' in row:
            most = max(most, _count(row, LEFT_OUT))
        elif f'"{SINCE}":' in row and _is_event(row) and len(anew) < MOST_ANEW:
            anew.append((number, _count(row, SINCE), row))
    if not most and not anew:
        return []
    gaps: list[Gap] = []
    events: deque[tuple[int, int]] = deque(maxlen=min(most, MOST))
    first: dict[int, int] = {}
    for number, row in _rows(path):
        tick = _tick(row)
        for mark, since, _ in anew:
            if number <= mark and tick > since:
                first.setdefault(mark, number)
        if f'"{LEFT_OUT}"' in row and (count := _count(row, LEFT_OUT)) > 0:
            last = [events.pop() for _ in range(min(count, len(events)))]
            if last:
                ticks = last[-1][1], tick
                gaps.append(Gap(last[-1][0], number, frozenset(line for line, _ in last), ticks))
        elif _is_event(row) and f'"{SINCE}":' not in row:
            events.append((number, tick))
    for mark, since, row in anew:
        gaps.append(Gap(first.get(mark, mark), mark, frozenset([mark]), (since, _tick(row)), row))
    return gaps


def _rows(path: Path) -> Iterator[tuple[int, str]]:
    """All rows but the first, with their numbers (from 1)."""
    with path.open(encoding="utf-8", errors="replace") as file:
        for number, row in enumerate(iter(lambda: file.readline(LONGEST), ""), 1):
            if number > 1:
                yield number, row


def _is_event(row: str) -> bool:
    return '"event":' in row and f'"type":"{KEPT}"' not in row


def _tick(row: str) -> int:
    found = TICK_OF.search(row)
    return 0 if found is None else int(found[1])


def _count(row: str, key: str) -> int:
    try:
        value = json.loads(row)
    except (ValueError, RecursionError):
        return 0
    count = value.get(key) if isinstance(value, dict) else None
    return count if isinstance(count, int) and not isinstance(count, bool) and 0 <= count < 1 << 40 else 0
