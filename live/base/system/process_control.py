"""Processes: their sessions, ends, priorities, memory and processor time; whatever a system refuses has no effect."""

import contextlib
import ctypes
import os
import platform
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any, Final, NoReturn

from live.base.system.features import LINUX

KILL_CODE: Final = -9
"""Exit code of a process that was killed (negative: the signal)."""
INTERRUPT_CODE: Final = 128 + 2
TERMINATE_CODE: Final = 128 + 15
RESTART_CODE: Final = 75
"""Exit code of a process that is to be started again (EX_TEMPFAIL of sysexits.h)."""
HANG_UP_CODE: Final = 128 + 1
"""Exit codes of a show that a signal ended: SIGINT, SIGTERM, SIGHUP."""


def own_session() -> dict[str, Any]:
    """Arguments of `subprocess.Popen` with which Ctrl-C on the terminal does not reach the child."""
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"start_new_session": True}


def restart_program() -> NoReturn:
    """Start this program again by the command line with which it was started, in its place."""
    command = [sys.executable, *sys.orig_argv[1:]]
    if sys.platform == "win32":  # where a process cannot be replaced
        sys.exit(subprocess.call(command))
    os.execv(sys.executable, command)


def ignore_interrupts() -> None:
    """Let neither Ctrl-C nor a closed terminal end this process: its parent does."""
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)


@contextlib.contextmanager
def defer_signals() -> Iterator[Callable[[], None]]:
    """Delay the handlers of SIGINT, SIGTERM and SIGHUP until the end; yield a function that calls them earlier.

    What a handler raises is lost where native code calls Python, as LLVM does. In other threads than the main one,
    which never run handlers, nothing happens.
    """
    asked: list[int] = []
    usual: dict[int, Callable[[int, Any], Any]] = {}
    if threading.current_thread() is threading.main_thread():
        for name in ("SIGINT", "SIGTERM", "SIGHUP"):
            number = getattr(signal, name, None)
            if number is not None and callable(own := signal.getsignal(number)):
                usual[number] = own
                signal.signal(number, lambda number, _frame: asked.append(number))

    def end_if_asked() -> None:
        while asked:
            number = asked.pop(0)
            usual[number](number, None)

    try:
        yield end_if_asked
    finally:
        for number, handler in usual.items():
            if signal.getsignal(number) is not signal.SIG_IGN:  # set by a handler that ran: it ignores further signals
                signal.signal(number, handler)
        end_if_asked()


def on_promotion_signal(handle: Callable[[int, Any], None]) -> None:
    """Call `handle` for SIGUSR1, with which a person makes a standby machine lead; Windows has no such signal."""
    if sys.platform != "win32":
        signal.signal(signal.SIGUSR1, handle)


def processor_count() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def machine_memory() -> int:
    """Return the machine's memory [bytes]."""
    if LINUX:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    import psutil

    return int(psutil.virtual_memory().total)


def processor_name() -> str:
    """Return the name of the processor, as far as the system says it."""
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8", errors="replace") as file:
        for line in file:
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def return_free_memory() -> None:
    """Return to the system what this process has freed, which glibc keeps in pieces for later; 20 ms for 500 MB."""
    if LINUX:
        with contextlib.suppress(OSError, AttributeError):  # other C libraries of Linux keep nothing
            ctypes.CDLL(None).malloc_trim(0)


def memory_of(process: int) -> int:
    """Return the resident bytes of a process; 0 if it has gone."""
    if LINUX:  # read each second by the supervisor, which needs no more than one file for it
        with contextlib.suppress(OSError, ValueError, IndexError), open(f"/proc/{process}/statm", "rb") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        return 0
    import psutil

    with contextlib.suppress(psutil.Error):
        return int(psutil.Process(process).memory_info().rss)
    return 0


def processor_time_of(process: int) -> float | None:
    """Return the seconds for which a process has run; None if it has gone."""
    import psutil

    with contextlib.suppress(psutil.Error):
        times = psutil.Process(process).cpu_times()
        return float(times.user + times.system)
    return None


def yield_priority(nice: int) -> None:
    """Let other processes go before this one; `nice` as nice(2)."""
    if sys.platform != "win32":
        with contextlib.suppress(OSError):
            os.nice(nice)
    elif nice > 0:
        lower_priority_of(os.getpid(), nice)


def lower_priority_of(process: int, nice: int) -> None:
    """Let other processes go before that one; `nice` as nice(2)."""
    import psutil

    with contextlib.suppress(psutil.Error):
        psutil.Process(process).nice(psutil.BELOW_NORMAL_PRIORITY_CLASS if sys.platform == "win32" else nice)


def yield_thread_priority(nice: int) -> None:
    """Let other threads go before this one and those that it will start; only Linux can."""
    if sys.platform == "linux":
        thread = threading.get_native_id()
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, thread, os.getpriority(os.PRIO_PROCESS, thread) + nice)


def raise_open_files(wanted: int) -> None:
    """Allow this process so many open files, as far as its user may; Windows has no such limit."""
    if sys.platform == "win32":
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < wanted:
        most = wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
