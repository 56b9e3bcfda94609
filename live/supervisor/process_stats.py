"""What Linux says of processes and of the machine: /proc, read as it is; nothing of it is there on other systems.

Reaper: waits for children that nobody else waits for, so that none stays a zombie.

The supervisor adopts whoever below it loses its parent: the helpers of an engine that was killed, who was between the
two forks of a nursery that was killed. Nobody holds a handle on these.
"""

import contextlib
import os
from collections.abc import Iterator
from typing import Final

from live.supervisor.watchdog import MachineReading, Usage

CLOCK: Final = os.sysconf("SC_CLK_TCK")
PARENT, USER, KERNEL = 1, 11, 12
"""Which words of /proc/PID/stat behind the name are the parent and the processor times: fields 4, 14, 15 of proc(5)."""


def stat_of(process: int, thread: int | None = None) -> list[str]:
    """The words of /proc/PID/stat behind the name, the state first; empty if there is none such."""
    where = f"/proc/{process}/stat" if thread is None else f"/proc/{process}/task/{thread}/stat"
    with contextlib.suppress(OSError), open(where, encoding="utf-8", errors="replace") as file:
        return file.read().rpartition(")")[2].split()
    return []


def usage_of(process: int) -> Usage | None:
    """Times of a process' threads; None if there is none such. Some tenths of a millisecond."""
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
    """Seconds run and waited for a processor; None where the kernel does not count them."""
    with contextlib.suppress(OSError, ValueError):
        with open(f"/proc/{process}/task/{thread}/schedstat", encoding="ascii") as file:
            run, delay, slices = (int(word) for word in file.read().split())
        if run or slices:
            return run * 1e-9, delay * 1e-9
    return None


def machine() -> MachineReading:
    """Who wants a processor now, and how long was waited for processors, memory and disks."""
    runnable = None
    with contextlib.suppress(OSError, ValueError, IndexError), open("/proc/loadavg", encoding="ascii") as file:
        runnable = max(int(file.read().split()[3].partition("/")[0]) - 1, 0) / len(os.sched_getaffinity(0))
    memory, io = _pressure("memory"), _pressure("io")
    return MachineReading(
        runnable, _pressure("cpu").get("some"), memory.get("some"), memory.get("full"), io.get("full")
    )  # fmt: skip


def _pressure(resource: str) -> dict[str, float]:
    """Seconds of stall, by kind; empty where the kernel does not count them, or is told not to (psi=0)."""
    with contextlib.suppress(OSError, ValueError), open(f"/proc/pressure/{resource}", encoding="ascii") as file:
        return {line.split()[0]: int(line.rpartition("total=")[2]) * 1e-6 for line in file if "total=" in line}
    return {}


def zombies() -> Iterator[int]:
    """Children of this process that are dead and not waited for yet."""
    mine = str(os.getpid())
    for name in os.listdir("/proc"):
        if name.isdecimal():
            stat = stat_of(int(name))
            if len(stat) > PARENT and stat[0] == "Z" and stat[PARENT] == mine:
                yield int(name)


EVERY: Final = 0.25
"""Seconds between two looks."""
GRACE: Final = 1.0
"""Seconds that whoever started a process has for waiting for it: exit codes are theirs."""


class Reaper:
    """Thread: the one that starts processes, for the system knows children by process."""

    def __init__(self) -> None:
        self._look_at = 0.0
        self._seen: dict[int, float] = {}
        self.count = 0
        """Processes that were cleared away here."""

    def look(self, now: float) -> None:
        """Clear away who has been dead for longer than a moment; `now` [s]."""
        if now < self._look_at:
            return
        self._look_at = now + EVERY
        try:
            dead = os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
        except ChildProcessError:
            dead = False
        self._seen = {process: self._seen.get(process, now) for process in zombies()} if dead else {}
        for process, since in self._seen.items():
            if now - since > GRACE:
                with contextlib.suppress(ChildProcessError):
                    self.count += os.waitpid(process, os.WNOHANG)[0] == process
