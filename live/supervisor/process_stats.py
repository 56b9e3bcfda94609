"""Readings of processes and of the machine from /proc, and a reaper for orphaned children.

Other systems tell less: only how long a process has run; and their children are never orphaned.

The supervisor adopts descendants that lose their parent: helpers of a killed engine, or the intermediate process of a
killed prefork process. No part holds a handle on these, so `Reaper` waits for them and none stays a zombie.
"""

import contextlib
import os
from collections.abc import Iterator
from typing import Final

from live.base.system.features import LINUX
from live.base.system.process_control import processor_time_of
from live.supervisor.watchdog import MachineReading, Usage

CLOCK: Final = os.sysconf("SC_CLK_TCK") if LINUX else 100
PARENT, USER, KERNEL = 1, 11, 12
"""Indices of parent and processor times among the words of /proc/PID/stat after the name: fields 4, 14, 15 of proc(5).
"""


def stat_of(process: int, thread: int | None = None) -> list[str]:
    """Return the words of /proc/PID/stat after the name, the state first; empty if there is no such process, or no
    /proc."""
    if not LINUX:
        return []
    where = f"/proc/{process}/stat" if thread is None else f"/proc/{process}/task/{thread}/stat"
    with contextlib.suppress(OSError), open(where, encoding="utf-8", errors="replace") as file:
        return file.read().rpartition(")")[2].split()
    return []


def usage_of(process: int) -> Usage | None:
    """Return the times of a process' threads; None if there is no such process. Takes some tenths of a millisecond."""
    if not LINUX:
        run = processor_time_of(process)
        return None if run is None else Usage("S", run, None)
    stat = stat_of(process, process)
    if len(stat) <= KERNEL:
        return None
    main, others = _run_and_delay(process, process), [0.0, 0.0]
    if main is None:
        return Usage(stat[0], (int(stat[USER]) + int(stat[KERNEL])) / CLOCK, None)
    with contextlib.suppress(OSError):
        for thread in os.listdir(f"/proc/{process}/task"):
            if int(thread) != process and (told := _run_and_delay(process, int(thread))) is not None:
                others[0] += told[0]
                others[1] += told[1]
    return Usage(stat[0], *main, *others)


def _run_and_delay(process: int, thread: int) -> tuple[float, float] | None:
    """Return the seconds run and waited for a processor; None where the kernel does not count them."""
    with contextlib.suppress(OSError, ValueError):
        with open(f"/proc/{process}/task/{thread}/schedstat", encoding="ascii") as file:
            run, delay, slices = (int(word) for word in file.read().split())
        if run or slices:
            return run * 1e-9, delay * 1e-9
    return None


def read_machine() -> MachineReading:
    """Return the machine's runnable threads and its stalls for processors, memory and disks."""
    if not LINUX:
        return MachineReading()
    runnable = None
    with contextlib.suppress(OSError, ValueError, IndexError), open("/proc/loadavg", encoding="ascii") as file:
        runnable = max(int(file.read().split()[3].partition("/")[0]) - 1, 0) / len(os.sched_getaffinity(0))
    memory, io = _pressure("memory"), _pressure("io")
    return MachineReading(
        runnable, _pressure("cpu").get("some"), memory.get("some"), memory.get("full"), io.get("full")
    )  # fmt: skip


def _pressure(resource: str) -> dict[str, float]:
    """Return seconds of stall by kind; empty where the kernel does not count them (psi=0)."""
    with contextlib.suppress(OSError, ValueError), open(f"/proc/pressure/{resource}", encoding="ascii") as file:
        return {line.split()[0]: int(line.rpartition("total=")[2]) * 1e-6 for line in file if "total=" in line}
    return {}


def zombies() -> Iterator[int]:
    """Yield the children of this process that are dead and not reaped yet."""
    mine = str(os.getpid())
    for name in os.listdir("/proc"):
        if name.isdecimal():
            stat = stat_of(int(name))
            if len(stat) > PARENT and stat[0] == "Z" and stat[PARENT] == mine:
                yield int(name)


EVERY: Final = 0.25
"""Seconds between two checks."""
GRACE: Final = 1.0
"""Seconds in which the part that started a process can reap it itself and read its exit code."""


class Reaper:
    """Reaps children for which no other part waits. Thread: the one that starts processes, because children belong to
    it."""

    def __init__(self) -> None:
        self._look_at = 0.0
        self._dead_since: dict[int, float] = {}
        self.count = 0
        """Processes reaped here."""

    def update(self, now: float) -> None:
        """Reap children that have been dead for longer than `GRACE`; `now` [s]."""
        if now < self._look_at or not LINUX:
            return
        self._look_at = now + EVERY
        try:
            dead = os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
        except ChildProcessError:
            dead = False
        self._dead_since = {process: self._dead_since.get(process, now) for process in zombies()} if dead else {}
        for process, since in self._dead_since.items():
            if now - since > GRACE:
                with contextlib.suppress(ChildProcessError):
                    self.count += os.waitpid(process, os.WNOHANG)[0] == process
