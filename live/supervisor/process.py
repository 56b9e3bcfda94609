"""Child processes of the supervisor, auxiliary processes that are restarted, and the selector loop that reads them."""

import contextlib
import os
import selectors
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final, Protocol

from live.supervisor.heartbeat import Heartbeat, Phase
from live.supervisor.line_channel import Wire, WireBroken
from live.supervisor.process_stats import machine, stat_of, usage_of
from live.supervisor.restart_policy import Backoff
from live.supervisor.watchdog import MachineLoad, Verdict, Watchdog

CODE: Final = 49
"""Index of the exit code among the words of /proc/PID/stat after the name: field 52 of proc(5)."""


class Process(Protocol):
    """Process handle: `subprocess.Popen`, or a process forked by the prefork process."""

    pid: int

    def poll(self) -> int | None:
        """Return its exit code (negative: the signal); None while it runs."""
        ...

    def wait(self, timeout: float | None = None) -> int:
        """Wait until it has ended; raises `subprocess.TimeoutExpired` after `timeout` seconds."""
        ...

    def send_signal(self, number: int) -> None:
        """Send it a signal, if it still lives."""
        ...


class Child:
    """A child process in its own session, so that Ctrl-C on the terminal reaches only the supervisor, which passes it
    on.

    Thread: the supervisor's.
    """

    def __init__(
        self,
        role: str,
        command: Sequence[str],
        *,
        inherit: Sequence[int] = (),
        born: Callable[[int, int], Process] | None = None,
    ) -> None:
        """Start `command`, with the descriptors of its channel and its heartbeat as two more arguments.

        `inherit`: more descriptors that it inherits, with the same numbers; `born`: starts the process instead, given
        those two descriptors. OSError if it cannot be started.
        """
        self.role = role
        self.heart = Heartbeat()
        self.watch = Watchdog()
        try:
            mine, theirs = socket.socketpair()
        except OSError:
            self.heart.close()
            raise
        self.wire = Wire(mine)
        self.process: Process
        try:
            if born is not None:
                self.process = born(theirs.fileno(), self.heart.descriptor)
            else:
                self.process = subprocess.Popen(
                    [*command, str(theirs.fileno()), str(self.heart.descriptor)],
                    stdin=subprocess.DEVNULL,
                    pass_fds=(theirs.fileno(), self.heart.descriptor, *inherit),
                    start_new_session=True,
                )
        except OSError:
            self.wire.close()
            self.heart.close()
            raise
        finally:
            theirs.close()
        self.started = time.monotonic()
        self.killed = False
        """Whether it was killed, even if it has not ended yet."""

    @classmethod
    def adopted(cls, role: str, wire: Wire, heart: Heartbeat, process: Process) -> "Child":
        """Make one for a process that already runs and that another supervisor started."""
        child = cls.__new__(cls)
        child.role, child.wire, child.heart, child.process = role, wire, heart, process
        child.watch, child.started, child.killed = Watchdog(), time.monotonic(), False
        return child

    @property
    def phase(self) -> Phase:
        """The phase it reports."""
        return self.heart.phase

    def hangs(self, now: float, slowdown: float) -> bool:
        """Whether it has given no sign of life for too long; `slowdown`: of the machine.

        A process that starts or waits need not send heartbeats, but every process must within a tick.
        """
        if self.phase is not Phase.RUNNING and not self.heart.running[1]:
            return False
        process = self.process.pid
        return self.watch.look(now, self.heart.last, lambda: usage_of(process), slowdown) is Verdict.HUNG

    def memory(self) -> int:
        """Return its resident bytes; 0 if the system does not report them."""
        try:
            with open(f"/proc/{self.process.pid}/statm", encoding="ascii") as file:
                return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        except (OSError, ValueError, IndexError):
            return 0

    def gone(self) -> int | None:
        """Return its exit code (negative: the signal) once its main thread is dead; None before.

        A killed process is not over for the system until all its threads have ended: a driver's thread of low priority
        may take seconds on a busy machine.
        """
        code = self.process.poll()
        if code is not None:
            return code
        with contextlib.suppress(ValueError, IndexError):
            words = stat_of(self.process.pid)
            if words and words[0] == "Z":
                return os.waitstatus_to_exitcode(int(words[CODE]))
        return None

    def ends(self, within: float) -> bool:
        """Wait up to `within` seconds for its end; return whether it ended."""
        try:
            self.process.wait(within)
        except subprocess.TimeoutExpired:
            return False
        return True

    def signal(self, number: int) -> None:
        """Send it a signal, if it still lives."""
        with contextlib.suppress(OSError):
            self.process.send_signal(number)

    def kill(self) -> None:
        """Kill it."""
        self.killed = True
        self.signal(signal.SIGKILL)

    def terminate(self) -> None:
        """Ask it to end (SIGTERM)."""
        self.signal(signal.SIGTERM)

    def end(self, *, within: float = 2.0) -> int:
        """Close its channel, wait, and kill it if needed; return its exit code (negative: the signal)."""
        self.wire.close()
        try:
            code = self.process.wait(within)
        except subprocess.TimeoutExpired:
            self.signal(signal.SIGKILL)
            try:
                code = self.process.wait(within)
            except subprocess.TimeoutExpired:
                code = -signal.SIGKILL
        with contextlib.suppress(ValueError, OSError):
            self.heart.close()
        return code


@dataclass(slots=True)
class Side:
    """An auxiliary process (audio, OSC reader or fallback window) that is restarted when it dies, with back-off.

    Thread: the supervisor's.
    """

    start: Callable[[], Child]
    """Starts one and sends its configuration."""
    say: Callable[[str], None]
    child: Child | None = None
    restarts: int = 0
    _backoff: Backoff = field(default_factory=lambda: Backoff(free=3, first=5.0, settled=30.0))
    _start_at: float | None = None

    def look(self, now: float, slowdown: float) -> None:
        """Restart it if it has died or hangs. One that ended with code 0 is not restarted: it has nothing to do here.

        `slowdown`: of the machine.
        """
        child = self.child
        if child is None:
            if self._start_at is not None and now >= self._start_at:
                self.begin(now)
                self.restarts += self.child is not None
            return
        if not child.killed and child.hangs(now, slowdown):
            child.kill()
        if child.process.poll() is None:
            child.wire.flush()
            return
        role, code, self.child = child.role, child.end(), None
        if code == 0:
            return
        wait = self._backoff.after(now)
        self._start_at = now + wait
        when = f" again; it is started once more in {wait:.0f} s" if wait else "; it is started again"
        self.say(f"the {role} process ended{when}")

    def begin(self, now: float) -> None:
        """Start it; if the system lacks resources, try again later."""
        self.child, self._start_at = None, None
        try:
            self.child = self.start()
        except OSError:
            self._start_at = now + max(self._backoff.after(now), 1.0)

    def close(self) -> None:
        """End it."""
        self._start_at = None
        if self.child is not None:
            self.child.terminate()
            self.child.end()
            self.child = None


ROUND: Final = 0.02
"""Seconds of a round: between two checks of the heartbeats."""
SLEPT: Final = 0.5
"""In a round longer than this [s] this process itself did not run."""

READ_EVERY: Final = 0.25
"""Seconds between two readings of the machine's load."""

Hear = Callable[[str], None]


class Starter:
    """Starts processes and reads all channels in one selector. Thread: the supervisor's."""

    def __init__(self) -> None:
        self.selector = selectors.DefaultSelector()
        self.awake = time.monotonic()
        """When this process itself last stalled: silence before that does not mean death."""
        self.load = MachineLoad(ROUND)
        """Load of the machine."""
        self._read_at = 0.0
        self.meanwhile: Callable[[float], None] = lambda now: None
        """Called while a channel is drained, so that other machines do not take the wait for silence."""

    def turn(self) -> float:
        """Read what arrives within a round; return the time [s, monotonic]."""
        before = time.monotonic()
        ready = self.selector.select(ROUND)
        woken = time.monotonic()
        self.load.woke(max(woken - before - ROUND, 0.0), woken - before)
        for key, _ in ready:
            key.data()
        now = time.monotonic()
        if now - before > SLEPT:
            self.awake = now
        if now >= self._read_at:
            self._read_at = now + READ_EVERY
            self.load.read(now, machine())
        return now

    def start(
        self,
        role: str,
        command: Sequence[str],
        hear: Hear,
        *inherit: int,
        born: Callable[[int, int], Process] | None = None,
    ) -> Child:
        """Start a process (see `Child`); `hear` gets every line it sends."""
        child = Child(role, command, inherit=inherit, born=born)
        self.listen(child.wire, hear, child.kill)
        return child

    def listen(self, wire: Wire, hear: Hear, broken: Callable[[], None] = lambda: None) -> None:
        """Read a channel until it ends; `broken` is called if the data violates the protocol."""

        def read() -> None:
            try:
                lines = wire.lines()
            except WireBroken:
                lines, wire.ended = [], True
                broken()
            if wire.ended:
                self.forget(wire)
            for line in lines:
                wire.heard += 1
                hear(line)

        self.selector.register(wire.socket, selectors.EVENT_READ, read)

    def forget(self, wire: Wire) -> None:
        """Stop reading a channel; harmless if it is not read."""
        if wire.fileno() >= 0 and wire.socket in self.selector.get_map():
            self.selector.unregister(wire.socket)

    def hear_rest(self, wire: Wire, within: float, *, dead: bool = False) -> None:
        """Read a channel to its end, because the last lines count however the process ended. `dead`: the process has
        ended, so one round reads all there is."""
        if dead:
            self.turn()
            return
        deadline = time.monotonic() + within
        while not wire.ended and time.monotonic() < deadline:
            self.meanwhile(self.turn())

    def close(self) -> None:
        """Close the selector."""
        self.selector.close()
