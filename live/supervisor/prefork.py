"""Nursery: a process that has loaded everything and opened nothing. Engines that are forked from it are ready soon.

It has one thread, no window, no device and no socket but its own and those that all engines share, so that a fork of it
is whole. What it bears are children of the supervisor, as all others are: it forks twice, and the supervisor adopts
whoever loses its parent (PR_SET_CHILD_SUBREAPER of prctl(2), Linux 3.4). Memory that nobody writes to they share.
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

from live.supervisor.heartbeat import Heartbeat, Phase
from live.supervisor.line_channel import Wire
from live.supervisor.process import Child, Starter
from live.supervisor.restart_policy import Backoff
from live.supervisor.supervisor_link import Lifeline, nobody_left

ADOPT: Final = 36
"""PR_SET_CHILD_SUBREAPER."""
WITHIN: Final = 1.0
"""Seconds in which one is born; forking takes some hundredths ..."""
WITHIN_MOST: Final = 4.0
"""... or as many times longer as the machine is slower, but not more than this: the supervisor waits for it."""
ROOM: Final = 2.5
"""So many times an engine's memory has to be free for a nursery: it needs about as much as an engine itself."""
PAUSE: Final = 0.002
TIRED: Final = 3
"""So often it may die by itself; then engines begin without it."""


def adopts() -> bool:
    """Let this process become the parent of whoever below it loses its own; False where the system knows no such."""
    with contextlib.suppress(OSError, AttributeError):
        return bool(ctypes.CDLL(None).prctl(ADOPT, 1, 0, 0, 0) == 0)
    return False


def free_memory() -> int:
    """Bytes that programs can still have without others being swapped out; 0 where the system does not say."""
    with contextlib.suppress(OSError, ValueError, IndexError), open("/proc/meminfo", encoding="ascii") as file:
        for line in file:
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    return 0


class Born:
    """A process that this one has adopted, as `subprocess.Popen` shows its own."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self._code: int | None = None

    def poll(self) -> int | None:
        """Its exit code (negative: the signal), None while it lives."""
        if self._code is None:
            try:
                pid, status = os.waitpid(self.pid, os.WNOHANG)
            except ChildProcessError:  # somebody else has waited for it
                self._code = 1
            else:
                self._code = os.waitstatus_to_exitcode(status) if pid else None
        return self._code

    def wait(self, timeout: float | None = None) -> int:
        """Wait until it has ended; `subprocess.TimeoutExpired` after so many seconds."""
        deadline = None if timeout is None else time.monotonic() + timeout
        while (code := self.poll()) is None:
            if deadline is not None and time.monotonic() > deadline:
                raise subprocess.TimeoutExpired("", timeout or 0.0)
            time.sleep(PAUSE)
        return code

    def send_signal(self, number: int) -> None:
        """Send it a signal, if it still lives."""
        if self.poll() is None:
            os.kill(self.pid, number)


class Nursery:
    """The supervisor's side of it. Thread: the supervisor's."""

    def __init__(self, starter: Starter) -> None:
        self._starter = starter
        self._able = adopts()
        self._stopped: list[Child] = []
        self._deaths = 0
        self._backoff, self._begin_at = Backoff(first=5.0), 0.0
        self.child: Child | None = None

    def begin(
        self, command: Sequence[str], brief: dict[str, Any], inherit: dict[str, int], engine: Callable[[], int]
    ) -> bool:
        """Start it if there is none, and there is room for it beside an engine, whose bytes are told; whether there is
        one."""
        if self.child is not None:
            return True
        early = time.monotonic() < self._begin_at
        if early or not self._able or self._deaths >= TIRED or free_memory() < ROOM * engine():
            return False
        try:
            self.child = self._starter.start("nursery", command, lambda line: None, *inherit.values())
        except OSError:  # the system has no room for one now
            self._stand_back()
            return False
        self.child.wire.tell(alive="nursery", **brief, **inherit)
        return True

    @property
    def ready(self) -> bool:
        """Whether everything is loaded."""
        child = self.child
        return child is not None and child.phase is Phase.WAITING and child.process.poll() is None

    def look(self) -> None:
        """Forget it if it has died."""
        for child in (*self._stopped, *([] if self.child is None else [self.child])):
            child.wire.flush()
            if child.process.poll() is not None:
                self._starter.forget(child.wire)
                child.end()
                self._stopped = [other for other in self._stopped if other is not child]
                if child is self.child:
                    self.child, self._deaths = None, self._deaths + 1
                    self._stand_back()

    def _stand_back(self) -> None:
        """Begin no other one for a while."""
        now = time.monotonic()
        self._begin_at = now + self._backoff.after(now)

    def bear(self, wire: int, heart: int) -> Born:
        """One more engine, which gets these two descriptors; OSError if none comes."""
        child = self.child
        if child is None:
            raise OSError("there is no nursery")
        try:
            socket.send_fds(child.wire.socket, [b"+"], [wire, heart])
            patience = min(WITHIN * self._starter.load.slowdown, WITHIN_MOST)
            select.select([child.wire.socket], [], [], patience)
            lines = child.wire.lines()
            return Born(int(lines[0]))
        except (OSError, ValueError, IndexError):
            self.stop()
            self._stand_back()
            raise OSError("the nursery does not answer") from None

    def stop(self) -> None:
        """End it: what it has loaded is no longer what is danced, or it does not answer."""
        if self.child is not None:
            self.child.kill()
            self._stopped.append(self.child)
            self.child = None

    def close(self) -> None:
        """End it, and wait for it."""
        self.stop()
        for child in self._stopped:
            child.end()
        self._stopped.clear()


def wait_to_be_born(nursery: Lifeline) -> Lifeline | None:
    """Wait in the nursery, forking whenever the supervisor asks; returns in each engine that is born, with its own
    lifeline, and in the nursery itself (None) when nobody is left."""
    sock = nursery.wire.socket
    while not nobody_left(nursery):
        nursery.beat(0, Phase.WAITING)
        if not select.select([sock], [], [], WITHIN)[0]:
            continue
        word, descriptors, _, _ = socket.recv_fds(sock, 1, 2)
        if not word or len(descriptors) != 2:
            return None
        pid = _fork_twice()
        if not pid:
            nursery.wire.close()
            nursery.heart.close()
            return Lifeline(Wire(socket.socket(fileno=descriptors[0])), Heartbeat(descriptors[1]))
        for descriptor in descriptors:
            os.close(descriptor)
        nursery.wire.put(str(pid))
    return None


def _fork_twice() -> int:
    """Fork a process whose parent is gone, and return its number; 0 in that process itself."""
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
