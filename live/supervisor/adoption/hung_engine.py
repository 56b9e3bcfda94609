"""Detection and kill of a hung engine that has lost its supervisor and does not answer the next one.

Its process number is not known yet, but the system knows which process holds its rendezvous socket.
"""

import contextlib
import os
import signal
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

from live.supervisor.process_stats import read_machine, usage_of
from live.supervisor.restart_policy import MAX_SILENCE
from live.supervisor.watchdog import MachineLoad, Verdict, Watchdog

ROUND: Final = 0.05
"""Seconds between two checks."""
READ_EVERY: Final = 0.5
"""Seconds between two readings of the machine's load."""
GONE_WITHIN: Final = 5.0
"""Seconds for a killed process to disappear."""


def socket_holders(name: str) -> list[int]:
    """Return the other processes of this user that hold the listening socket `name`; at most one in a show."""
    inodes = set(_inodes(name))
    return (
        [int(pid) for pid in os.listdir("/proc") if pid.isdecimal() and inodes & set(_open_files(pid))]
        if inodes
        else []
    )


def _inodes(name: str) -> Iterator[str]:
    with contextlib.suppress(OSError), open("/proc/net/unix", encoding="utf-8", errors="replace") as file:
        for line in file:
            words = line.split()
            if len(words) == 8 and words[7].endswith(f"/{name}"):
                yield f"socket:[{words[6]}]"


def _open_files(pid: str) -> Iterator[str]:
    if int(pid) == os.getpid():
        return
    with contextlib.suppress(OSError):
        folder = f"/proc/{pid}/fd"
        if os.stat(folder).st_uid != os.getuid():
            return
        for descriptor in os.listdir(folder):
            with contextlib.suppress(OSError):
                yield os.readlink(f"{folder}/{descriptor}")


def kill_if_hung(name: str, answers: Callable[[], bool]) -> list[int]:
    """Watch the process that holds the socket `name` until it `answers`, has ended or hangs; kill it if it hangs.

    Returns the numbers of killed processes. Uses the same watchdog as for a supervisor's own engine: time without a
    processor does not count.
    """
    begin = time.monotonic()
    load, last_read = MachineLoad(ROUND), begin
    watched = {pid: Watchdog() for pid in socket_holders(name)}
    while watched and time.monotonic() - begin < MAX_SILENCE + 1.0:
        before = time.monotonic()
        if answers():
            return []
        time.sleep(ROUND)
        now = time.monotonic()
        load.record_wakeup(max(now - before - ROUND, 0.0), now - before)
        if now - last_read > READ_EVERY:
            load.record_reading(now, read_machine())
            last_read = now
        verdicts = [dog.update(now, begin, partial(usage_of, pid), load.slowdown) for pid, dog in watched.items()]
        if all(verdict is Verdict.HUNG for verdict in verdicts):
            return [pid for pid in socket_holders(name) if pid in watched and _kill(pid)]
        watched = {pid: dog for pid, dog in watched.items() if pid in socket_holders(name)}
    return []


def _kill(pid: int) -> bool:
    try:
        descriptor = os.pidfd_open(pid)
    except OSError:
        return False
    try:
        signal.pidfd_send_signal(descriptor, signal.SIGKILL)
    except OSError:
        return False
    finally:
        os.close(descriptor)
    deadline = time.monotonic() + GONE_WITHIN
    while os.path.exists(f"/proc/{pid}/fd/0") and time.monotonic() < deadline:
        time.sleep(ROUND)
    return True
