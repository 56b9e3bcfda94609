"""Part faults: an exception in a thread or a callback beside the show ends neither the show nor that part for good.

A thread's work is begun again after a pause that grows (`keep_running`). A callback that a frame makes is one of many,
each behind a bulkhead of its own (`Bulkhead`; Nygard, *Release It!*, 2007): one that fails again and again is left out
for some calls, then tried once more. All of it is counted, and told in a person's words (`FAULTS`).

Nothing here waits or reads a clock: how a thread waits it says itself, and callbacks rest for so many calls.
"""

import re
from collections import deque
from collections.abc import Callable
from typing import Any, Final, TypeVar

FIRST_PAUSE: Final = 0.05
"""Seconds after which work is begun again at first ..."""
LONGEST_PAUSE: Final = 1.0
"""... and at most: each pause is twice the last one."""
IN_A_ROW: Final = 3
"""After so many failures in a row a callback is left out ..."""
FIRST_REST: Final = 64
"""... for so many calls at first, a second of frames ..."""
LONGEST_REST: Final = 4096
"""... and at most a minute of frames; each rest is twice the last one."""
KEPT: Final = 32
"""Parts that are remembered by name; a program has no more."""

_CAMEL: Final = re.compile(r"(?<=[a-z])(?=[A-Z])")
Result = TypeVar("Result")


class PartFaults:
    """What has failed in this process. Thread: any; counts of two that fail in the same moment may be one too few."""

    def __init__(self) -> None:
        self.counts: dict[str, int] = {}
        """Failures by part."""
        self.last: dict[str, str] = {}
        """The last failure of each, in words."""
        self.resting: dict[str, str] = {}
        """What is left out now, and why."""
        self._news = ""
        self.traces: deque[BaseException] = deque(maxlen=4)
        """The last exceptions, for whoever looks closer."""

    def note(self, part: str, error: BaseException) -> None:
        """A part has failed."""
        if part not in self.counts and len(self.counts) >= KEPT:
            part = "other parts"
        count = self.counts[part] = self.counts.get(part, 0) + 1
        self.last[part] = words = f"{type(error).__name__}: {' '.join(str(error).split())}"[:200]
        self.traces.append(error)
        if count & (count - 1) == 0:  # at powers of two: whoever fails in each frame fills no terminal
            often = "" if count == 1 else f" ({count} times by now)"
            self._news = f"{part} failed and goes on{often}: {words}"

    def rest(self, part: str) -> None:
        """A part is left out for a while."""
        self.resting[part] = self._news = f"{part} fails again and again and is left out for a while: {self.last[part]}"

    def wait(self, part: str) -> None:
        """A part cannot be had yet, and is tried again."""
        self.resting[part] = self._news = f"{part} is tried again until it goes well: {self.last[part]}"

    def works(self, part: str) -> None:
        """A part that was left out works again."""
        if self.resting.pop(part, None) is not None:
            self._news = f"{part} works again"

    def since(self, counts: dict[str, int]) -> list[str]:
        """What has failed since `counts` was copied, in words."""
        return [
            f"{part} failed {count - counts.get(part, 0)} times: {self.last[part]}"
            for part, count in self.counts.items()
            if count > counts.get(part, 0)
        ]

    @property
    def total(self) -> int:
        """All failures."""
        return sum(self.counts.values())

    def facts(self) -> dict[str, Any]:
        """For the status."""
        return {"failed": dict(self.counts), "left_out": list(self.resting), "last": dict(self.last)}

    def news(self) -> str:
        """The last news in words; empty before the first."""
        return self._news

    def problem(self) -> str:
        """What is left out now, for the overlay; empty: nothing."""
        return "; ".join(list(self.resting.values())[:3])


FAULTS: Final = PartFaults()
"""Of this process: threads have nobody else to tell."""


def keep_running(
    part: str, work: Callable[[], None], wait: Callable[[float], bool], *, faults: PartFaults = FAULTS
) -> None:
    """Do `work` until it returns; where it ends in an exception it is begun again after a pause.

    `wait(seconds)` pauses, and is True if the thread is to end: `threading.Event.wait` is one. Thread: the work's own.
    """
    pause = FIRST_PAUSE
    while True:
        try:
            work()
        except Exception as error:
            faults.note(part, error)
        else:
            return
        if wait(pause):
            return
        pause = min(2.0 * pause, LONGEST_PAUSE)


def run_once(part: str, work: Callable[[], None], *, faults: PartFaults = FAULTS) -> bool:
    """Do `work`; whether it went well. An exception is noted."""
    try:
        work()
    except Exception as error:
        faults.note(part, error)
        return False
    return True


class Bulkhead:
    """Calls what is beside the show, each part on its own. Thread: one."""

    def __init__(self, faults: PartFaults = FAULTS) -> None:
        self._faults = faults
        self._failed: dict[str, list[int]] = {}  # in a row, calls still to be left out, length of the next rest

    def call(self, part: str, act: Callable[..., Result], *arguments: Any) -> Result | None:
        """What `act` returns; None if it fails or is left out. `part`: its name, in a person's words."""
        failed = self._failed.get(part)
        if failed is not None and failed[1] > 0:
            failed[1] -= 1
            return None
        try:
            result = act(*arguments)
        except Exception as error:
            self._fail(part, error)
            return None
        if failed is not None:
            del self._failed[part]
            self._faults.works(part)
        return result

    def _fail(self, part: str, error: Exception) -> None:
        failed = self._failed.setdefault(part, [0, 0, FIRST_REST])
        failed[0] += 1
        self._faults.note(part, error)
        if failed[0] >= IN_A_ROW:
            failed[1], failed[2] = failed[2], min(2 * failed[2], LONGEST_REST)
            self._faults.rest(part)


def name_of(act: Callable[..., Any]) -> str:
    """How a callback is called for people who were not told a better name: its class, or its own name."""
    owner = getattr(act, "__self__", None)
    if owner is None:
        return str(getattr(act, "__qualname__", type(act).__name__)).partition(".<locals>")[0].replace("_", " ")
    return _CAMEL.sub(" ", type(owner).__name__).lower()
