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

from live.base.system.channel import start_child
from live.base.system.process_control import KILL_CODE, memory_of
from live.supervisor.heartbeat import Heartbeat, Phase
from live.supervisor.line_channel import ChannelError, LineChannel
from live.supervisor.process_stats import read_machine, stat_of, usage_of
from live.supervisor.restart_policy import Backoff
from live.supervisor.watchdog import MachineLoad, Verdict, Watchdog

EXIT_CODE_INDEX: Final = 49
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

    def kill(self) -> None:
        """End it at once, if it still lives."""
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
        spawn: Callable[[int, int], Process] | None = None,
    ) -> None:
        """Start `command`, with the words for its channel and its heartbeat as two more arguments.

        `inherit`: more descriptors that it inherits, with the same numbers; `spawn`: starts the process instead, given
        those two descriptors. OSError if it cannot be started.
        """
        self.role = role
        self.heartbeat = Heartbeat()
        self.watchdog = Watchdog()
        page = self.heartbeat.page
        self.process: Process
        try:
            if spawn is None:
                mine, self.process = start_child(command, page.argument, inherit=(*page.inherit, *inherit))
            else:
                mine, self.process = _forked(spawn, page.descriptor)
        except OSError:
            self.heartbeat.close()
            raise
        self.channel = LineChannel(mine)
        self.killed = False
        """Whether it was killed, even if it has not ended yet."""

    @classmethod
    def adopted(cls, role: str, channel: LineChannel, heartbeat: Heartbeat, process: Process) -> "Child":
        """Make one for a process that already runs and that another supervisor started."""
        child = cls.__new__(cls)
        child.role, child.channel, child.heartbeat, child.process = role, channel, heartbeat, process
        child.watchdog, child.killed = Watchdog(), False
        return child

    @property
    def phase(self) -> Phase:
        """The phase it reports."""
        return self.heartbeat.phase

    def hangs(self, now: float, slowdown: float) -> bool:
        """Whether it has given no sign of life for too long; `slowdown`: of the machine.

        A process that starts or waits need not send heartbeats, but every process must within a tick.
        """
        if self.phase is not Phase.RUNNING and not self.heartbeat.running[1]:
            return False
        process = self.process.pid
        return self.watchdog.update(now, self.heartbeat.last, lambda: usage_of(process), slowdown) is Verdict.HUNG

    def memory(self) -> int:
        """Return its resident bytes; 0 if the system does not report them."""
        return memory_of(self.process.pid)

    def exit_code(self) -> int | None:
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
                return os.waitstatus_to_exitcode(int(words[EXIT_CODE_INDEX]))
        return None

    def wait_for_end(self, within: float) -> bool:
        """Wait up to `within` seconds for its end; return whether it ended."""
        try:
            self.process.wait(within)
        except subprocess.TimeoutExpired:
            return False
        return True

    def signal(self, number: int) -> None:
        """Send it a signal, if it still lives."""
        with contextlib.suppress(OSError, ValueError):  # Windows has few signals
            self.process.send_signal(number)

    def kill(self) -> None:
        """Kill it."""
        self.killed = True
        with contextlib.suppress(OSError):
            self.process.kill()

    def terminate(self) -> None:
        """Ask it to end (SIGTERM)."""
        self.signal(signal.SIGTERM)

    def end(self, *, within: float = 2.0) -> int:
        """Close its channel, wait, and kill it if needed; return its exit code (negative: the signal)."""
        self.channel.close()
        try:
            code = self.process.wait(within)
        except subprocess.TimeoutExpired:
            self.kill()
            try:
                code = self.process.wait(within)
            except subprocess.TimeoutExpired:
                code = KILL_CODE
        with contextlib.suppress(ValueError, OSError):
            self.heartbeat.close()
        return code


def _forked(spawn: Callable[[int, int], Process], page: int) -> tuple[socket.socket, Process]:
    """Return this end of a process' channel, and the process, forked elsewhere."""
    mine, theirs = socket.socketpair()
    try:
        with theirs:
            return mine, spawn(theirs.fileno(), page)
    except OSError:
        mine.close()
        raise


@dataclass(slots=True)
class AuxiliaryProcess:
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

    def update(self, now: float, slowdown: float) -> None:
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
            child.channel.flush()
            return
        role, code, self.child = child.role, child.end(), None
        if code == 0:
            return
        wait = self._backoff.next_delay(now)
        self._start_at = now + wait
        when = f" again; it is started once more in {wait:.0f} s" if wait else "; it is started again"
        self.say(f"the {role} process ended{when}")

    def begin(self, now: float) -> None:
        """Start it; if the system lacks resources, try again later."""
        self.child, self._start_at = None, None
        try:
            self.child = self.start()
        except OSError:
            self._start_at = now + max(self._backoff.next_delay(now), 1.0)

    def close(self) -> None:
        """End it."""
        self._start_at = None
        if self.child is not None:
            self.child.terminate()
            self.child.end()
            self.child = None


ROUND: Final = 0.02
"""Seconds of a round: between two checks of the heartbeats."""

READ_EVERY: Final = 0.25
"""Seconds between two readings of the machine's load."""

LineHandler = Callable[[str], None]


class ProcessManager:
    """Starts processes and reads all channels in one selector. Thread: the supervisor's."""

    def __init__(self) -> None:
        self.selector = selectors.DefaultSelector()
        self._unconnected: dict[LineChannel, Callable[[], None]] = {}  # what reads them, looked at each round
        self.load = MachineLoad(ROUND)
        """Load of the machine."""
        self._read_at = 0.0
        self.on_drain: Callable[[float], None] = lambda now: None
        """Called while a channel is drained, so that other machines do not take the wait for silence."""

    def poll(self) -> float:
        """Read what arrives within a round; return the time [s, monotonic]."""
        for channel, read in list(self._unconnected.items()):
            read()
            if channel.connected and self._unconnected.pop(channel, None) is not None:
                self.selector.register(channel.socket, selectors.EVENT_READ, read)
        before = time.monotonic()
        ready = []
        if self.selector.get_map():
            ready = self.selector.select(ROUND)
        else:
            time.sleep(ROUND)  # Windows cannot wait for nothing
        woken = time.monotonic()
        self.load.record_wakeup(max(woken - before - ROUND, 0.0), woken - before)
        for key, _ in ready:
            key.data()
        now = time.monotonic()
        if now >= self._read_at:
            self._read_at = now + READ_EVERY
            self.load.record_reading(now, read_machine())
        return now

    def start(
        self,
        role: str,
        command: Sequence[str],
        on_line: LineHandler,
        *inherit: int,
        spawn: Callable[[int, int], Process] | None = None,
    ) -> Child:
        """Start a process (see `Child`); `on_line` gets every line it sends."""
        child = Child(role, command, inherit=inherit, spawn=spawn)
        self.register(child.channel, on_line, child.kill)
        return child

    def register(
        self, channel: LineChannel, on_line: LineHandler, on_broken: Callable[[], None] = lambda: None
    ) -> None:
        """Read a channel until it ends; `on_broken` is called if the data violates the protocol."""

        def read() -> None:
            try:
                lines = channel.read_lines()
            except ChannelError:
                lines, channel.ended = [], True
                on_broken()
            if channel.ended:
                self.unregister(channel)
            for line in lines:
                channel.received += 1
                on_line(line)

        if channel.connected:
            self.selector.register(channel.socket, selectors.EVENT_READ, read)
        else:
            self._unconnected[channel] = read
        channel.before_close = lambda: self.unregister(channel)

    def unregister(self, channel: LineChannel) -> None:
        """Stop reading a channel; harmless if it is not read."""
        self._unconnected.pop(channel, None)
        if channel.fileno() >= 0 and channel.socket in self.selector.get_map():
            self.selector.unregister(channel.socket)

    def drain(self, channel: LineChannel, within: float, *, dead: bool = False) -> None:
        """Read a channel to its end, because the last lines count however the process ended. `dead`: the process has
        ended, so one round reads all there is."""
        if dead:
            self.poll()
            return
        deadline = time.monotonic() + within
        while not channel.ended and time.monotonic() < deadline:
            self.on_drain(self.poll())

    def close(self) -> None:
        """Close the selector."""
        self.selector.close()
