"""The lines of a show as a numbered stream, for machines that follow it and may lose their connection for a while.

A *stream* is all lines of one leader. Whoever followed it resumes where it was if the lines since are still kept, and
begins anew from the last snapshot otherwise. Standby machines (`remote_standby`) and render nodes (`live.nodes`) follow
in this way.
"""

import secrets
from collections import deque
from typing import Any, Final

from live.show.journal.skipped_events import MAX_SKIPPED, SKIPPED_KEY
from live.supervisor.recovery_log import RecoveryLog

RECENT: Final = 8 * 1024 * 1024
"""Most bytes of recent lines that are kept for machines that reconnect, ..."""
RECENT_LINES: Final = 8192
"""... and most lines: about a minute."""
MOST_TICKS: Final = 64 * 600
"""Lines farther ahead of all before are refused: ten minutes."""
LATEST_TICK: Final = 64 * 86400 * 30


class ShowStream:
    """Name of the stream, number of its last line, and its recent lines. Thread: one."""

    def __init__(self) -> None:
        self._recent: deque[str] = deque()
        self.restart()

    def restart(self) -> None:
        """Begin another stream."""
        self.name = secrets.token_hex(8)
        self.number = 0
        """Lines so far."""
        self._recent.clear()
        self._bytes = 0

    def add(self, line: str) -> None:
        """Append a line."""
        self.number += 1
        self._recent.append(line)
        self._bytes += len(line)
        while self._bytes > RECENT or len(self._recent) > RECENT_LINES:
            self._bytes -= len(self._recent.popleft())

    def resume(self, stream: str, number: int, log: RecoveryLog) -> tuple[int, bool, list[str]]:
        """Return what a machine gets that knows the lines of `stream` up to `number`: the number before the first
        line, whether that is another beginning (the last snapshot of `log`), and the lines."""
        recent = self.since(stream, number)
        return (self.number, True, list(log.replay_lines())) if recent is None else (number, False, recent)

    def since(self, stream: str, number: int) -> list[str] | None:
        """Return the lines after line `number` of that stream; None if they are not kept."""
        first = self.number - len(self._recent)
        if stream != self.name or not first <= number <= self.number:
            return None
        return list(self._recent)[number - first :]


def is_show_line(told: dict[str, Any], *, begun: bool, tick: int) -> bool:
    """Return whether a line from another machine can belong to a followed show.

    `begun`: whether its first line was there before; `tick`: the last one so far.
    """
    if "journal" in told:
        return True
    now = told.get("tick")
    if not isinstance(now, int) or isinstance(now, bool) or not 0 <= now <= LATEST_TICK:
        return False
    if not begun or (tick and now > tick + MOST_TICKS):
        return False
    kinds = (("event", dict | list), ("measure", int), ("hash", str), ("snapshot", str), (SKIPPED_KEY, int))
    if not all(isinstance(told[key], kind) for key, kind in kinds if key in told):
        return False
    return ("measure" in told) <= ("hash" in told) and 0 <= told.get(SKIPPED_KEY, 0) <= MAX_SKIPPED
