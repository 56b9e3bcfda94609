"""CutOff: a show of which no process is left goes on from its journal, in the measure in which it would be by now.

The journal's first line says where the show's clock began, on the machine's own clock: that holds until the machine is
started anew. What is read is a file: lines are data to whoever runs them, and snapshots are checked before that.
"""

import base64
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from live.clock.ticks import TICK
from live.show.journal.journal_writer import SNAPSHOTS, Unwritten, Written, read_snapshots
from live.supervisor.recovery_log import CHANGES, Log

WITHIN: Final = 300.0
"""Seconds that a show may have been gone; after that it begins anew."""
LARGEST: Final = 1 << 30
"""Bytes of a journal that is read."""
END: Final = b'"end":true'


@dataclass(frozen=True, slots=True)
class CutOff:
    """What is left of a show."""

    lines: list[str]
    """The show so far, as `Log.since` tells it."""
    unwritten: Unwritten
    """How its journal is gone on with."""
    snapshots_kept: int
    """Bytes of the file of snapshots that stay."""
    gone: float
    """Since when it has been gone [s], at most."""


def cut_off(path: Path) -> CutOff | None:
    """What is left in the journal `path`; None if it was never begun, has ended, is too old or of another start."""
    try:
        written = path.stat()
        if written.st_size > LARGEST or not _since_the_start(written.st_mtime):
            return None
        data = path.read_bytes()
    except OSError:
        return None
    whole = data[: data.rfind(b"\n") + 1]
    rows = whole.splitlines()
    if len(rows) < 2 or END in rows[-1]:
        return None
    header, last = _json(rows[0]), _json(rows[-1])
    origin, tick = header.get("origin"), last.get("tick")
    if not isinstance(origin, float) or not isinstance(tick, int) or header.get("journal") is None:
        return None
    gone = time.perf_counter() - (origin + tick * TICK)
    if not -1.0 < gone < WITHIN:
        return None
    first = rows[0].decode("utf-8", "replace")
    snapshot, kept = _last_snapshot(path, rows, tick)
    unwritten = Unwritten(first, Written(0, len(whole), 0), ())
    return CutOff(_so_far(rows, snapshot), unwritten, kept, gone)


def _since_the_start(written: float) -> bool:
    """Whether something was written since this machine was started, and lately."""
    now = time.time()
    return max(now - time.clock_gettime(time.CLOCK_BOOTTIME), now - WITHIN) < written


def _json(row: bytes) -> dict[str, Any]:
    try:
        value = json.loads(row)
    except (ValueError, RecursionError):
        return {}
    return value if isinstance(value, dict) else {}


def _last_snapshot(path: Path, rows: list[bytes], last: int) -> tuple[tuple[int, bytes] | None, int]:
    """The last snapshot that whoever begins with the first line can read, with its tick, and where the whole ones
    end."""
    changed = next((row for row in rows if any(name.encode() in row for name in CHANGES)), b"")
    until = min(last, int(_json(changed).get("tick", last)) - bool(changed))
    problems: list[str] = []
    found, end = None, 0
    for data in read_snapshots(path.with_name(path.name + SNAPSHOTS), problems):
        tick = int(_json(data.partition(b"\n")[0])["tick"])
        end += len(data) if not problems else 0
        if tick <= until:
            found = tick, data
    return found, end


def _so_far(rows: list[bytes], snapshot: tuple[int, bytes] | None) -> list[str]:
    log = Log()
    for row in rows:
        if snapshot is not None and _json(row[:40].partition(b",")[0] + b"}").get("tick", 0) > snapshot[0]:
            text = base64.b64encode(snapshot[1]).decode()
            log.take(json.dumps({"tick": snapshot[0], "snapshot": text}, separators=(",", ":")))
            snapshot = None
        log.take(row.decode("utf-8", "replace"))
    return list(log.since())
