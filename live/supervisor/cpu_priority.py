"""Priority: what a process of the show may ask of the scheduler; what is refused changes nothing."""

import contextlib
import os
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Final

ENGINE_NICE: Final = -5
AUDIO_NICE: Final = -10
BACK_NICE: Final = 5
"""Of the session of whoever prepares itself: a third of the weight. Anybody may take it back, unlike a thread's."""
AGAIN: Final = 0.03
"""The system lets users without rights change such a weight ten times a second; who is told to wait asks again after
so many seconds, ..."""
TIMES: Final = 8
"""... so often."""


def _threads(process: int | str = "self") -> list[int]:
    """The kernel's numbers of all threads of this process, or of another one."""
    with contextlib.suppress(OSError):
        return [int(path.name) for path in Path(f"/proc/{process}/task").iterdir()]
    return [0] if process == "self" else []


def _use(processors: Iterable[int], policy: int, process: int | str = "self") -> None:
    for thread in _threads(process):
        with contextlib.suppress(OSError):
            os.sched_setaffinity(thread, processors)
        with contextlib.suppress(OSError):
            os.sched_setscheduler(thread, policy, os.sched_param(0))


def _weigh(nice: int, process: int | str = "self") -> bool:
    """Weigh a process' whole session against others; whether that was allowed.

    Where the scheduler groups threads by session (sched_autogroup(7)), their own nice values only count within it, and
    every process of a show is a session of its own.
    """
    for _ in range(TIMES):
        try:
            with open(f"/proc/{process}/autogroup", "w", encoding="utf-8") as file:
                file.write(str(nice))
            return True
        except BlockingIOError:
            time.sleep(AGAIN)
        except OSError:
            break
    return False


def stand_back() -> frozenset[int]:
    """Whoever prepares itself while a show runs: one processor only, and after all others that want it.

    Not `nice`, from which nobody without a right comes back. Returns the processors it had.
    """
    if sys.platform != "linux":
        return frozenset()
    mine = os.sched_getaffinity(0)
    _use(sorted(mine)[-1:], os.SCHED_BATCH)
    _weigh(BACK_NICE)
    return frozenset(mine)


def bring_forward(process: int) -> None:
    """Let a process that stood back prepare itself as fast as it can, for it is needed now."""
    if sys.platform == "linux":
        _use(os.sched_getaffinity(0), os.SCHED_OTHER, process)
        _weigh(0, process)


def come_forward(nice: int, processors: frozenset[int] = frozenset()) -> None:
    """Those processors again (none: as it is), and a better share where the system allows it (limits.conf, nice)."""
    if sys.platform == "linux":
        if processors:
            _use(processors, os.SCHED_OTHER)
        if not _weigh(nice):  # the system allows that to some only
            _weigh(0)
        for thread in _threads():
            with contextlib.suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, thread, nice)
