"""Child: a process that the supervisor started, with the wire to it and the heartbeat it gives.

Side: a process beside the engine that is started again when it dies, less and less often if it dies at once.

Starter: starts processes and hears what they say; the one place that selects.
"""

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
"""Which word of /proc/PID/stat behind the name is the exit code: field 52 of proc(5)."""


class Process(Protocol):
    """What a child is to the system: `subprocess.Popen`, or one that the nursery bore."""

    pid: int

    def poll(self) -> int | None:
        """Its exit code (negative: the signal), None while it lives."""
        ...

    def wait(self, timeout: float | None = None) -> int:
        """Wait until it has ended; `subprocess.TimeoutExpired` after so many seconds."""
        ...

    def send_signal(self, number: int) -> None:
        """Send it a signal, if it still lives."""
        ...


class Child:
    """One process in a session of its own: Ctrl-C on the terminal is the supervisor's to pass on.

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
        """Start `command`, with the numbers of its wire's and its heartbeat's descriptors as two more arguments.

        `inherit`: more descriptors that it shall have, by the same numbers; `born`: begins it instead, given those two
        descriptors. OSError if it cannot be started.
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
        """Whether it was ended at once, and is only not gone yet."""

    @classmethod
    def adopted(cls, role: str, wire: Wire, heart: Heartbeat, process: Process) -> "Child":
        """One that runs already, and that another supervisor started."""
        child = cls.__new__(cls)
        child.role, child.wire, child.heart, child.process = role, wire, heart, process
        child.watch, child.started, child.killed = Watchdog(), time.monotonic(), False
        return child

    @property
    def phase(self) -> Phase:
        """What it says that it is doing."""
        return self.heart.phase

    def hangs(self, now: float, slowdown: float) -> bool:
        """Whether it has given no sign of life for too long; `slowdown`: how many times slower the machine is.

        Who prepares itself need not beat, but within a tick everybody does.
        """
        if self.phase is not Phase.RUNNING and not self.heart.running[1]:
            return False
        process = self.process.pid
        return self.watch.look(now, self.heart.last, lambda: usage_of(process), slowdown) is Verdict.HUNG

    def memory(self) -> int:
        """Resident bytes; 0 where the system does not say."""
        try:
            with open(f"/proc/{self.process.pid}/statm", encoding="ascii") as file:
                return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        except (OSError, ValueError, IndexError):
            return 0

    def gone(self) -> int | None:
        """Its exit code (negative: the signal) as soon as it does nothing more, None before.

        A process that was killed is not over for the system while one of its threads has not come to die: a driver's
        thread of low priority takes seconds to, where much else wants the processor. Its main thread is dead by then.
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
        """Whether it ends by itself within so many seconds; waits for that."""
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
        """End it at once."""
        self.killed = True
        self.signal(signal.SIGKILL)

    def terminate(self) -> None:
        """Ask it to end."""
        self.signal(signal.SIGTERM)

    def end(self, *, within: float = 2.0) -> int:
        """Close its wire, wait, and kill it if need be; its exit code (negative: the signal)."""
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
    """The process that listens, or the one with the black window. Thread: the supervisor's."""

    start: Callable[[], Child]
    """Starts one and tells it what it has to know."""
    say: Callable[[str], None]
    child: Child | None = None
    restarts: int = 0
    _backoff: Backoff = field(default_factory=lambda: Backoff(free=3, first=5.0, settled=30.0))
    _start_at: float | None = None

    def look(self, now: float, slowdown: float) -> None:
        """Start it again if it has died or hangs. One that ended by itself, with code 0, can do nothing here.

        `slowdown`: how many times slower the machine is.
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
        """Start it, or try again later where the system has no room for it now."""
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
"""Seconds between two looks at the hearts."""
SLEPT: Final = 0.5
"""A round that took so long [s] was one in which this process itself did not run."""

READ_EVERY: Final = 0.25
"""Seconds between two readings of how loaded the machine is."""

Hear = Callable[[str], None]


class Starter:
    """The selector, and all wires in it. Thread: the supervisor's."""

    def __init__(self) -> None:
        self.selector = selectors.DefaultSelector()
        self.awake = time.monotonic()
        """When this process itself was last found to have slept: nobody's silence before that means death."""
        self.load = MachineLoad(ROUND)
        """How loaded the machine is."""
        self._read_at = 0.0
        self.meanwhile: Callable[[float], None] = lambda now: None
        """Called while somebody's rest is heard: other machines shall not take that for silence."""

    def turn(self) -> float:
        """Hear what comes within a round; the time [s, monotonic]."""
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
        """Start a process (see `Child`); `hear` gets every line it says."""
        child = Child(role, command, inherit=inherit, born=born)
        self.listen(child.wire, hear, child.kill)
        return child

    def listen(self, wire: Wire, hear: Hear, broken: Callable[[], None] = lambda: None) -> None:
        """Hear what comes over a wire, until it ends; `broken`: what it said made no sense."""

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
        """Hear it no more; harmless if it was not heard."""
        if wire.fileno() >= 0 and wire.socket in self.selector.get_map():
            self.selector.unregister(wire.socket)

    def hear_rest(self, wire: Wire, within: float, *, dead: bool = False) -> None:
        """Hear a wire to its end: what was said last counts, however its process ended. `dead`: it says nothing more,
        so that all there will be is there."""
        if dead:
            self.turn()
            return
        deadline = time.monotonic() + within
        while not wire.ended and time.monotonic() < deadline:
            self.meanwhile(self.turn())

    def close(self) -> None:
        """Select no more."""
        self.selector.close()
