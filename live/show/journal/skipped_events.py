"""Skipped events: events that a journal contains but that were not applied after a crash.

After repeated crashes a new engine continues without the last events, because one of them may be the cause
(`live.supervisor`). The journal has them, because events are written before they are applied; a later line states how
many of the last events were skipped: `{"tick":6400,"left_out":3}`. State hashes between the first skipped event and
that line are invalid and are not compared.
"""

import json
import re
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

SKIPPED_KEY: Final = "left_out"
SINCE_KEY: Final = "since"
"""Key of an event that acted at an earlier tick than that of its line; the ticks since were simulated again."""
MAX_LINE: Final = 1 << 26
"""Maximum length of a line in characters."""
MAX_SKIPPED: Final = 65536
"""Maximum number of events that one line can skip; two seconds have far fewer."""
MAX_INSERTED: Final = 256
"""Maximum number of such inserted events (tripped stages); each one takes three engine crashes."""
TICK_OF: Final = re.compile(r'"tick":\s*(\d{1,13})')
NEVER_SKIPPED: Final = "TicksSkipped"
"""Event type that is never skipped, because it only counts ticks."""


@dataclass(frozen=True, slots=True)
class Gap:
    """A group of skipped events, by line number in the file (from 1)."""

    first: int
    """Line of the first event."""
    mark: int
    """Line that declares the gap."""
    events: frozenset[int]
    ticks: tuple[int, int]
    """Ticks of the first event and of the declaring line."""
    inserted: str = ""
    """The declaring line, if it is itself an event that acts at the first of these ticks."""

    def invalidates(self, tick: int) -> bool:
        """Whether a state recorded after that tick is invalid."""
        return self.ticks[0] < tick <= self.ticks[1]


def can_be_skipped(event: object) -> bool:
    """Whether an event, in its journal form, may be skipped."""
    return not (isinstance(event, dict) and event.get("type") == NEVER_SKIPPED)


def gap_line(tick: int, count: int) -> dict[str, Any]:
    """Return the line that declares the last `count` events before this tick as skipped."""
    return {"tick": tick, SKIPPED_KEY: count}


def drop_last_events(lines: Sequence[tuple[int, str]], count: int) -> list[tuple[int, str]]:
    """Return lines (tick, text) without the last `count` events and the measures recorded since the first of them."""
    kept: list[tuple[int, str]] = []
    for tick, line in reversed(lines):
        event = _is_event(line)
        if count <= 0 or not (event or '"measure"' in line):
            kept.append((tick, line))
        elif event:
            count -= 1
    return kept[::-1]


def skipped_gaps(path: Path) -> list[Gap]:
    """Return all gaps of skipped events in a journal; fast, because only the declaring lines are parsed."""
    most, anew = 0, list[tuple[int, int, str]]()
    for number, row in _rows(path):
        if f'"{SKIPPED_KEY}"' in row:
            most = max(most, _count(row, SKIPPED_KEY))
        elif f'"{SINCE_KEY}":' in row and _is_event(row) and len(anew) < MAX_INSERTED:
            anew.append((number, _count(row, SINCE_KEY), row))
    if not most and not anew:
        return []
    gaps: list[Gap] = []
    events: deque[tuple[int, int]] = deque(maxlen=min(most, MAX_SKIPPED))
    first: dict[int, int] = {}
    for number, row in _rows(path):
        tick = _tick(row)
        for mark, since, _ in anew:
            if number <= mark and tick > since:
                first.setdefault(mark, number)
        if f'"{SKIPPED_KEY}"' in row and (count := _count(row, SKIPPED_KEY)) > 0:
            last = [events.pop() for _ in range(min(count, len(events)))]
            if last:
                ticks = last[-1][1], tick
                gaps.append(Gap(last[-1][0], number, frozenset(line for line, _ in last), ticks))
        elif _is_event(row) and f'"{SINCE_KEY}":' not in row:
            events.append((number, tick))
    for mark, since, row in anew:
        gaps.append(Gap(first.get(mark, mark), mark, frozenset([mark]), (since, _tick(row)), row))
    return gaps


def _rows(path: Path) -> Iterator[tuple[int, str]]:
    """Yield all rows but the first, with their numbers (from 1)."""
    with path.open(encoding="utf-8", errors="replace") as file:
        for number, row in enumerate(iter(lambda: file.readline(MAX_LINE), ""), 1):
            if number > 1:
                yield number, row


def _is_event(row: str) -> bool:
    return '"event":' in row and f'"type":"{NEVER_SKIPPED}"' not in row


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
