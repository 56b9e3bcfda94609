"""Prefork process: modules, kernels, patch and library are loaded, but no window or device is open.

Engines forked from it are ready soon and share its unmodified memory. It has a single thread and no sockets but its own
and those that all engines share, so that a fork is complete. It forks twice, so that the supervisor adopts the engines
like its other children (PR_SET_CHILD_SUBREAPER of prctl(2), Linux 3.4).
"""

import contextlib
import ctypes
import os
import select
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Sequence
from typing import Any, Final

from live.base.system.features import LINUX
from live.supervisor.heartbeat import Phase
from live.supervisor.process import Child, ProcessManager
from live.supervisor.restart_policy import Backoff
from live.supervisor.supervisor_link import SupervisorLink, is_abandoned

PR_SET_CHILD_SUBREAPER: Final = 36
"""PR_SET_CHILD_SUBREAPER."""
FORK_TIMEOUT: Final = 1.0
"""Seconds for a fork on a quiet machine; a fork takes some hundredths. The limit grows with the slow-down ..."""
MAX_FORK_TIMEOUT: Final = 4.0
"""... up to this one, because the supervisor waits for it."""
MEMORY_FACTOR: Final = 2.5
"""Free memory required to start it, as a multiple of an engine's memory: it needs about as much as an engine."""
PAUSE: Final = 0.002
MAX_DEATHS: Final = 3
"""Number of its own deaths after which engines start without it."""


def become_subreaper() -> bool:
    """Make this process the parent of descendants that lose their own; False if the system does not support it."""
    if not LINUX:
        return False
    with contextlib.suppress(OSError, AttributeError):
        return bool(ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) == 0)
    return False


def free_memory() -> int:
    """Return the bytes available to programs without swapping; 0 if the system does not report it."""
    with contextlib.suppress(OSError, ValueError, IndexError), open("/proc/meminfo", encoding="ascii") as file:
        for line in file:
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    return 0


class ForkedProcess:
    """Adopted child process with the interface of `subprocess.Popen`."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self._code: int | None = None

    def poll(self) -> int | None:
        """Return its exit code (negative: the signal); None while it runs."""
        if self._code is None:
            try:
                pid, status = os.waitpid(self.pid, os.WNOHANG)
            except ChildProcessError:  # another part has waited for it
                self._code = 1
            else:
                self._code = os.waitstatus_to_exitcode(status) if pid else None
        return self._code

    def wait(self, timeout: float | None = None) -> int:
        """Wait until it has ended; raises `subprocess.TimeoutExpired` after `timeout` seconds."""
        deadline = None if timeout is None else time.monotonic() + timeout
        while (code := self.poll()) is None:
            if deadline is not None and time.monotonic() > deadline:
                raise subprocess.TimeoutExpired("", timeout or 0.0)
            time.sleep(PAUSE)
        return code

    def send_signal(self, number: int) -> None:
        """Send it a signal if it still runs."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """Kill it if it still runs."""
        self.send_signal(signal.SIGKILL)


class PreforkProcess:
    """The supervisor's handle on the prefork process. Thread: the supervisor's."""

    def __init__(self, starter: ProcessManager) -> None:
        self._starter = starter
        self._able = become_subreaper()
        self._stopped: list[Child] = []
        self._deaths = 0
        self._backoff, self._next_start = Backoff(first=5.0), 0.0
        self.child: Child | None = None

    def ensure_started(
        self, command: Sequence[str], brief: dict[str, Any], inherit: dict[str, int], engine: Callable[[], int]
    ) -> bool:
        """Start it if none runs and there is memory for it next to an engine; return whether one runs.

        `engine`: returns the bytes an engine uses.
        """
        if self.child is not None:
            return True
        early = time.monotonic() < self._next_start
        if early or not self._able or self._deaths >= MAX_DEATHS or free_memory() < MEMORY_FACTOR * engine():
            return False
        try:
            self.child = self._starter.start("nursery", command, lambda line: None, *inherit.values())
        except OSError:  # no resources for one now
            self._postpone()
            return False
        self.child.channel.send_json(alive="nursery", **brief, **inherit)
        return True

    @property
    def ready(self) -> bool:
        """Whether everything is loaded."""
        child = self.child
        return child is not None and child.phase is Phase.WAITING and child.process.poll() is None

    def update(self) -> None:
        """Clean up after it if it has died."""
        for child in (*self._stopped, *([] if self.child is None else [self.child])):
            child.channel.flush()
            if child.process.poll() is not None:
                self._starter.unregister(child.channel)
                child.end()
                self._stopped = [other for other in self._stopped if other is not child]
                if child is self.child:
                    self.child, self._deaths = None, self._deaths + 1
                    self._postpone()

    def _postpone(self) -> None:
        """Postpone the next start."""
        now = time.monotonic()
        self._next_start = now + self._backoff.next_delay(now)

    def fork_engine(self, wire: int, heart: int) -> ForkedProcess:
        """Fork another engine, which inherits these two descriptors; OSError if none starts."""
        child = self.child
        if child is None:
            raise OSError("there is no prefork process")
        try:
            socket.send_fds(child.channel.socket, [b"+"], [wire, heart])
            patience = min(FORK_TIMEOUT * self._starter.load.slowdown, MAX_FORK_TIMEOUT)
            select.select([child.channel.socket], [], [], patience)
            lines = child.channel.read_lines()
            return ForkedProcess(int(lines[0]))
        except (OSError, ValueError, IndexError):
            self.stop()
            self._postpone()
            raise OSError("the prefork process does not answer") from None

    def stop(self) -> None:
        """Stop it, because it does not answer or its loaded patch or steps are out of date."""
        if self.child is not None:
            self.child.kill()
            self._stopped.append(self.child)
            self.child = None

    def close(self) -> None:
        """Stop it and wait for its end."""
        self.stop()
        for child in self._stopped:
            child.end()
        self._stopped.clear()


def serve_forks(link: SupervisorLink) -> SupervisorLink | None:
    """Wait in the prefork process and fork whenever the supervisor asks.

    Returns in each forked engine with that engine's own supervisor link, and in the prefork process itself with None
    once supervisor and parent have gone.
    """
    sock = link.channel.socket
    while not is_abandoned(link):
        link.beat(0, Phase.WAITING)
        if not select.select([sock], [], [], FORK_TIMEOUT)[0]:
            continue
        word, descriptors, _, _ = socket.recv_fds(sock, 1, 2)
        if not word or len(descriptors) != 2:
            return None
        pid = _fork_twice()
        if not pid:
            link.channel.close()
            link.heartbeat.close()
            return SupervisorLink.of_descriptors(*descriptors)
        for descriptor in descriptors:
            os.close(descriptor)
        link.channel.send_line(str(pid))
    return None


def _fork_twice() -> int:
    """Fork a process whose parent exits at once; return its number, or 0 in that process."""
    reading, writing = os.pipe()
    between = os.fork()
    if between == 0:
        pid = os.fork()
        if pid:
            os.write(writing, str(pid).encode())
            os._exit(0)
        os.close(reading)
        os.close(writing)
        os.setsid()
        signal.signal(signal.SIGINT, signal.default_int_handler)
        return 0
    os.close(writing)
    os.waitpid(between, 0)
    pid = int(os.read(reading, 32))
    os.close(reading)
    return pid
