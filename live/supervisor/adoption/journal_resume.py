"""Resuming of an interrupted show, of which no process is left, from its journal, in the measure it would be in by now.

The journal's header holds the origin of the show's clock on the machine's clock, which is valid until the machine is
restarted. Lines of the file are treated as data, and snapshots are checked before use.
"""

import base64
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from live.clock.ticks import TICK
from live.show.journal.journal_writer import SNAPSHOT_SUFFIX, read_snapshots
from live.show.journal.line_writer import UnfinishedFile, WriteProgress
from live.supervisor.network.peer_messages import read_line
from live.supervisor.recovery_log import PATCH_EVENTS, RecoveryLog

MAX_INTERRUPTION: Final = 300.0
"""Longest interruption [s]; after that the show starts from the beginning."""
LARGEST: Final = 1 << 30
"""Most bytes of a journal that is read."""
END_MARK: Final = b'"end":true'


@dataclass(frozen=True, slots=True)
class InterruptedShow:
    """State of an interrupted show."""

    lines: list[str]
    """The show so far, as returned by `RecoveryLog.since`."""
    unwritten: UnfinishedFile
    """State for continuing its journal."""
    snapshots_kept: int
    """Bytes of the snapshot file that stay."""
    interrupted_s: float
    """Longest possible time since the interruption [s]."""


def read_interrupted(path: Path) -> InterruptedShow | None:
    """Read the journal `path`; None if the show never began, has ended, is too old or predates the machine's start."""
    try:
        written = path.stat()
        if written.st_size > LARGEST or not _is_recent(written.st_mtime):
            return None
        data = path.read_bytes()
    except OSError:
        return None
    whole = data[: data.rfind(b"\n") + 1]
    rows = whole.splitlines()
    if len(rows) < 2 or END_MARK in rows[-1]:
        return None
    header, last = read_line(rows[0]), read_line(rows[-1])
    origin, tick = header.get("origin"), last.get("tick")
    if not isinstance(origin, float) or not isinstance(tick, int) or header.get("journal") is None:
        return None
    gone = time.perf_counter() - (origin + tick * TICK)
    if not -1.0 < gone < MAX_INTERRUPTION:
        return None
    first = rows[0].decode("utf-8", "replace")
    snapshot, kept = _last_snapshot(path, rows, tick)
    unwritten = UnfinishedFile(first, WriteProgress(0, len(whole), 0), ())
    return InterruptedShow(_replay_lines(rows, snapshot), unwritten, kept, gone)


def _is_recent(written: float) -> bool:
    """Return whether a file time is recent and after this machine's start."""
    now = time.time()
    return max(now - time.clock_gettime(time.CLOCK_BOOTTIME), now - MAX_INTERRUPTION) < written


def _last_snapshot(path: Path, rows: list[bytes], last: int) -> tuple[tuple[int, bytes] | None, int]:
    """Return the last snapshot readable with the header's patch and steps, with its tick, and the end of the intact
    snapshots."""
    changed = next((row for row in rows if any(name.encode() in row for name in PATCH_EVENTS)), b"")
    until = min(last, int(read_line(changed).get("tick", last)) - bool(changed))
    problems: list[str] = []
    found, end = None, 0
    for data in read_snapshots(path.with_name(path.name + SNAPSHOT_SUFFIX), problems):
        tick = int(read_line(data.partition(b"\n")[0])["tick"])
        end += len(data) if not problems else 0
        if tick <= until:
            found = tick, data
    return found, end


def _replay_lines(rows: list[bytes], snapshot: tuple[int, bytes] | None) -> list[str]:
    log = RecoveryLog()
    for row in rows:
        if snapshot is not None and read_line(row[:40].partition(b",")[0] + b"}").get("tick", 0) > snapshot[0]:
            text = base64.b64encode(snapshot[1]).decode()
            log.add_line(json.dumps({"tick": snapshot[0], "snapshot": text}, separators=(",", ":")))
            snapshot = None
        log.add_line(row.decode("utf-8", "replace"))
    return list(log.replay_lines())
