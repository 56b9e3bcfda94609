"""Helper: a process beside the show's that is told things and never waited for; and its own end of that.

Packets (`packet.py`) are whole, in a socket pair that the system ends with either process. What does not fit is left
out and counted; a helper that has died is started again, and told anew what it has to know.
"""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any, Final

from live.base.fault_isolation import run_once
from live.clock.time_source import Clock
from live.control.message_codec import PacketError, packet_of, read_packet

LARGEST: Final = 1 << 16
RESTART_AFTER: Final = 2.0
ENDS_WITHIN: Final = 2.0
PER_FRAME: Final = 8
HELLO: Final = {"hello": True}
"""What a process says first that is started by somebody else: it knows nothing yet."""


class Helper:
    """The show's side. Thread: the one that runs the show; a restart begins in one of its own."""

    def __init__(
        self, module: str, clock: Clock, plan: dict[str, Any], anew: Callable[[], None], *inherit: int,
        on: Callable[[Any], None] = lambda told: None, joined: int | None = None,
    ) -> None:  # fmt: skip
        """`module` is run with what `Told` reads first: `plan`, and the origin of the clock; `anew`: a fresh one has to
        be told everything; `inherit`: descriptors that it has under the same numbers; `on`: gets what it says that
        is no facts, which are a dict. `joined`: the descriptor of a socket to a process that somebody else starts, and
        starts again; it says `HELLO` then. Once nobody holds its other end any more, one is started here."""
        self._inherit, self._on, self._joined = inherit, on, joined
        self._module, self._clock, self._plan, self._anew = module, clock, plan, anew
        self._socket: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._starting: threading.Thread | None = None
        self._started_at = 0.0
        self._facts: dict[str, Any] = {}
        self.left_out = 0
        """Packets for which there was no room."""
        self.restarts = 0
        self.damaged = 0
        """Packets of it that could not be read."""

    @property
    def process(self) -> int | None:
        """Its number; None while there is none."""
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        """Start the process; it is ready some tenths of a second later, what it is told meanwhile waits."""
        if self._joined is not None:
            self._socket = socket.socket(fileno=os.dup(self._joined))
            self._socket.setblocking(False)
            self._tell_plan()
            return
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        ours.setblocking(False)
        with theirs:
            command = [sys.executable, "-m", self._module, str(theirs.fileno())]
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                pass_fds=[theirs.fileno(), *self._inherit],
                start_new_session=True,  # Ctrl-C ends the show, and the show this
            )  # fmt: skip
        self._socket, old = ours, self._socket
        if old is not None:
            old.close()
        self._started_at = self._clock.now()
        self._tell_plan()

    def _tell_plan(self) -> None:
        self.send(self._plan | {"origin": time.perf_counter() - self._clock.now()})
        self._anew()

    def send(self, what: object) -> bool:
        """Tell something; whether there was room for it."""
        if self._socket is None:
            return False
        try:
            self._socket.send(packet_of(what))
        except OSError:
            self.left_out += 1
            return False
        return True

    def frame(self, news: int = PER_FRAME) -> None:
        """In each frame: take up what it says, of what is no facts so much, and start it again if it has died."""
        if self._socket is None or self._starting is not None:
            if self._starting is not None and not self._starting.is_alive():
                self._starting = None
            return
        for _ in range(PER_FRAME):
            try:
                data = self._socket.recv(LARGEST)
            except BlockingIOError:
                return
            except OSError:
                data = b""
            if not data:
                break
            try:
                told = read_packet(data)
            except PacketError:
                self.damaged += 1
                continue
            if told == HELLO:
                self._tell_plan()
            elif isinstance(told, dict):
                self._facts = told
            else:
                self._on(told)
                news -= 1
                if not news:
                    return
        else:
            return
        lost = self._joined is not None  # nobody keeps that process any more: one of our own goes on
        if lost or self._clock.now() - self._started_at > RESTART_AFTER:
            self._joined = None
            self.restarts += 1
            self._starting = threading.Thread(target=self._start_again, daemon=True)
            self._starting.start()

    def _start_again(self) -> None:
        def again() -> None:
            with contextlib.suppress(OSError):  # a system that has no room for one now is asked again
                self._reap()
                self.start()

        run_once(f"the restart of {self._module}", again)

    def stop(self) -> None:
        """End it."""
        if self._starting is not None:
            self._starting.join(ENDS_WITHIN)
        if self._socket is not None:
            self._socket.close()
            self._socket = None
        self._reap()

    def _reap(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        try:
            process.wait(timeout=ENDS_WITHIN)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def facts(self) -> dict[str, Any]:
        """What it said last, a second old, with what was left out."""
        return {**self._facts, "left_out": self.left_out, "restarts": self.restarts}


class Told:
    """The helper's own end. Thread: one."""

    def __init__(self, descriptor: int, plan: dict[str, Any] | None = None) -> None:
        """Waits for the plan; `plan`: this process has one, and whoever starts it is not the show."""
        for number in (signal.SIGINT, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        self.socket = socket.socket(fileno=descriptor)
        if plan is None:
            self.socket.setblocking(True)
            plan = read_packet(self.socket.recv(LARGEST))
        self.plan: dict[str, Any] = plan
        self.socket.setblocking(False)
        with contextlib.suppress(OSError):
            os.nice(self.plan.get("nice", 2))  # the frame goes before
        self.ended = False
        """Whether the show has gone."""

    def packets(self) -> Iterator[Any]:
        """What has come."""
        while not self.ended:
            try:
                data = self.socket.recv(LARGEST)
            except BlockingIOError:
                return
            except OSError:
                data = b""
            if not data:
                self.ended = True
                return
            with contextlib.suppress(PacketError):
                yield read_packet(data)

    def say(self, facts: dict[str, Any]) -> None:
        """How things are, for the status."""
        with contextlib.suppress(OSError):
            self.socket.send(packet_of(facts))
