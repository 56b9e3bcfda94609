"""Fault isolation: an exception in a worker thread or a callback stops neither the show nor that part for good.

A thread's work is restarted after a growing pause (`keep_running`). Each callback of a frame has its own bulkhead
(`Bulkhead`; Nygard, *Release It!*, 2007): after repeated failures it is skipped for some calls, then tried again.
All failures are counted and reported in plain words (`FAULTS`).

Nothing here waits or reads a clock: the caller supplies a thread's wait function, and callbacks are skipped for a
number of calls.
"""

import re
from collections import deque
from collections.abc import Callable
from typing import Any, Final, TypeVar

FIRST_PAUSE: Final = 0.05
"""First pause before work is restarted [s]."""
LONGEST_PAUSE: Final = 1.0
"""Longest pause [s]; each pause is twice the last one."""
FAILURES_BEFORE_SKIP: Final = 3
"""Number of consecutive failures after which a callback is skipped."""
FIRST_SKIP: Final = 64
"""Calls that are skipped at first: a second of frames."""
LONGEST_SKIP: Final = 4096
"""Maximum of calls skipped, a minute of frames; each time twice the last number."""
MAX_PARTS: Final = 32
"""Maximum number of parts that are counted by name."""

_CAMEL: Final = re.compile(r"(?<=[a-z])(?=[A-Z])")
Result = TypeVar("Result")


class FaultLog:
    """Failures in this process. Thread: any; two failures at the same moment may be counted as one."""

    def __init__(self) -> None:
        self.counts: dict[str, int] = {}
        """Failures by part."""
        self.last: dict[str, str] = {}
        """The last failure of each part, in words."""
        self.skipped: dict[str, str] = {}
        """Parts that are skipped now, and why."""
        self._last_notice = ""
        self.traces: deque[BaseException] = deque(maxlen=4)
        """The last exceptions, for debugging."""

    def record(self, part: str, error: BaseException) -> None:
        """Record a failure of a part."""
        if part not in self.counts and len(self.counts) >= MAX_PARTS:
            part = "other parts"
        count = self.counts[part] = self.counts.get(part, 0) + 1
        self.last[part] = words = f"{type(error).__name__}: {' '.join(str(error).split())}"[:200]
        self.traces.append(error)
        if count & (count - 1) == 0:  # at powers of two, so that a failure in each frame does not fill the terminal
            often = "" if count == 1 else f" ({count} times by now)"
            self._last_notice = f"{part} failed and continues{often}: {words}"

    def record_skip(self, part: str) -> None:
        """Record that a part is skipped for a while."""
        self.skipped[part] = self._last_notice = (
            f"{part} fails repeatedly and is skipped for a while: {self.last[part]}"
        )

    def record_retry(self, part: str) -> None:
        """Record that a part is not available yet and is retried."""
        self.skipped[part] = self._last_notice = f"{part} is retried until it works: {self.last[part]}"

    def record_recovery(self, part: str) -> None:
        """Record that a part works again."""
        if self.skipped.pop(part, None) is not None:
            self._last_notice = f"{part} works again"

    def failures_since(self, counts: dict[str, int]) -> list[str]:
        """Return the failures since `counts` was copied, in words."""
        return [
            f"{part} failed {count - counts.get(part, 0)} times: {self.last[part]}"
            for part, count in self.counts.items()
            if count > counts.get(part, 0)
        ]

    @property
    def total(self) -> int:
        """Number of all failures."""
        return sum(self.counts.values())

    def facts(self) -> dict[str, Any]:
        """Return the fields for the status message."""
        return {"failed": dict(self.counts), "left_out": list(self.skipped), "last": dict(self.last)}

    def last_notice(self) -> str:
        """Return the last notice; empty before the first."""
        return self._last_notice

    def problem(self) -> str:
        """Return the parts that are skipped now, for the overlay; empty: none."""
        return "; ".join(list(self.skipped.values())[:3])


FAULTS: Final = FaultLog()
"""The failures of this process, shared by all threads."""


def keep_running(
    part: str, work: Callable[[], None], wait: Callable[[float], bool], *, faults: FaultLog = FAULTS
) -> None:
    """Run `work` until it returns; after an exception, restart it after a pause.

    `wait(seconds)` pauses, and returns True if the thread has to end: `threading.Event.wait` does. Thread: the work's
    own.
    """
    pause = FIRST_PAUSE
    while True:
        try:
            work()
        except Exception as error:
            faults.record(part, error)
        else:
            return
        if wait(pause):
            return
        pause = min(2.0 * pause, LONGEST_PAUSE)


def run_once(part: str, work: Callable[[], None], *, faults: FaultLog = FAULTS) -> bool:
    """Run `work` and return whether it succeeded. An exception is recorded."""
    try:
        work()
    except Exception as error:
        faults.record(part, error)
        return False
    return True


class Bulkhead:
    """Calls callbacks, with the failures of each kept apart. Thread: one."""

    def __init__(self, faults: FaultLog = FAULTS) -> None:
        self._faults = faults
        self._failed: dict[str, list[int]] = {}  # consecutive failures, calls still to skip, length of the next skip

    def call(self, part: str, act: Callable[..., Result], *arguments: Any) -> Result | None:
        """Return the result of `act`; None if it fails or is skipped. `part`: its name for messages."""
        failed = self._failed.get(part)
        if failed is not None and failed[1] > 0:
            failed[1] -= 1
            return None
        try:
            result = act(*arguments)
        except Exception as error:
            self._record_failure(part, error)
            return None
        if failed is not None:
            del self._failed[part]
            self._faults.record_recovery(part)
        return result

    def _record_failure(self, part: str, error: Exception) -> None:
        failed = self._failed.setdefault(part, [0, 0, FIRST_SKIP])
        failed[0] += 1
        self._faults.record(part, error)
        if failed[0] >= FAILURES_BEFORE_SKIP:
            failed[1], failed[2] = failed[2], min(2 * failed[2], LONGEST_SKIP)
            self._faults.record_skip(part)


def callback_name(act: Callable[..., Any]) -> str:
    """Return a readable name of a callback: its class, or its own name."""
    owner = getattr(act, "__self__", None)
    if owner is None:
        return str(getattr(act, "__qualname__", type(act).__name__)).partition(".<locals>")[0].replace("_", " ")
    return _CAMEL.sub(" ", type(owner).__name__).lower()
