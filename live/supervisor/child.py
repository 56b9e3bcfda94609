"""Child: a process that the supervisor started, with the wire to it and the heartbeat it gives."""

import contextlib
import os
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Sequence
from typing import Final, Protocol

from live.supervisor.heartbeat import Heartbeat, Phase
from live.supervisor.procfs import stat_of, usage_of
from live.supervisor.watchdog import Verdict, Watchdog
from live.supervisor.wire import Wire

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
