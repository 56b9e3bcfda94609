"""Scheduling priority of the show's processes; requests that the system refuses have no effect."""

import contextlib
import os
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from live.base.system.features import LINUX

ENGINE_NICE: Final = -5
AUDIO_NICE: Final = -10
BACKGROUND_NICE: Final = 5
"""Nice value of the session of a process that prepares itself: a third of the weight. Unlike a thread's nice value, it
can be lowered again without privileges."""
RETRY_DELAY: Final = 0.03
"""Seconds between two attempts: unprivileged users may change this weight only ten times a second, ..."""
MAX_TRIES: Final = 8
"""... and number of attempts."""


def _threads(process: int | str = "self") -> list[int]:
    """Return the kernel's numbers of all threads of a process."""
    with contextlib.suppress(OSError):
        return [int(path.name) for path in Path(f"/proc/{process}/task").iterdir()]
    return [0] if process == "self" else []


def _set_scheduling(processors: Iterable[int], policy: int, process: int | str = "self") -> None:
    for thread in _threads(process):
        with contextlib.suppress(OSError):
            os.sched_setaffinity(thread, processors)
        with contextlib.suppress(OSError):
            os.sched_setscheduler(thread, policy, os.sched_param(0))


def _set_session_nice(nice: int, process: int | str = "self") -> bool:
    """Set the nice value of a process' whole session; return whether that was allowed.

    Where the scheduler groups threads by session (sched_autogroup(7)), their own nice values count only within it, and
    every process of a show has its own session.
    """
    for _ in range(MAX_TRIES):
        try:
            with open(f"/proc/{process}/autogroup", "w", encoding="utf-8") as file:
                file.write(str(nice))
            return True
        except BlockingIOError:
            time.sleep(RETRY_DELAY)
        except OSError:
            break
    return False


def lower_priority() -> frozenset[int]:
    """Lower the priority of this process while it prepares itself during a show: one processor, after all other
    processes.

    Does not use `nice`, which cannot be undone without privileges. Returns the processors it had.
    """
    if not LINUX:
        return frozenset()
    mine = os.sched_getaffinity(0)
    _set_scheduling(sorted(mine)[-1:], os.SCHED_BATCH)
    _set_session_nice(BACKGROUND_NICE)
    return frozenset(mine)


def restore_priority(process: int) -> None:
    """Give a process of lowered priority all processors and normal weight, because it is needed now."""
    if LINUX:
        _set_scheduling(os.sched_getaffinity(0), os.SCHED_OTHER, process)
        _set_session_nice(0, process)


def raise_priority(nice: int, processors: frozenset[int] = frozenset()) -> None:
    """Restore those processors (none: no change) and raise the priority if the system allows it (limits.conf, nice)."""
    if LINUX:
        if processors:
            _set_scheduling(processors, os.SCHED_OTHER)
        if not _set_session_nice(nice):  # needs a privilege
            _set_session_nice(0)
        for thread in _threads():
            with contextlib.suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, thread, nice)
