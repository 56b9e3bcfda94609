"""Child process of the show with a non-blocking packet channel, and the child's end of that channel.

Packets (see `message_codec`) go through a socket pair that closes when either process ends. A packet that does not fit
is dropped and counted. A child that has died is restarted and gets its configuration again.
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
"""First message of a process that the show did not start: it asks for the plan."""


class Helper:
    """The show's end. Thread: the show's; a restart runs in a thread of its own."""

    def __init__(
        self, module: str, clock: Clock, plan: dict[str, Any], anew: Callable[[], None], *inherit: int,
        on: Callable[[Any], None] = lambda told: None, joined: int | None = None,
    ) -> None:  # fmt: skip
        """Configure the child; nothing is started yet.

        `module` is run with `plan` and the clock's origin as its first packet. `anew` is called for each new child and
        has to send all state. `inherit`: file descriptors that the child gets under the same numbers. `on` receives all
        packets of the child other than facts, which are dicts. `joined`: descriptor of a socket to a process that
        another program starts and restarts; such a process sends `HELLO`. When the other end of that socket is closed,
        a child is started here.
        """
        self._inherit, self._on, self._joined = inherit, on, joined
        self._module, self._clock, self._plan, self._anew = module, clock, plan, anew
        self._socket: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._starting: threading.Thread | None = None
        self._started_at = 0.0
        self._facts: dict[str, Any] = {}
        self.left_out = 0
        """Packets dropped for lack of room."""
        self.restarts = 0
        self.damaged = 0
        """Packets from the child that could not be read."""

    @property
    def process(self) -> int | None:
        """The child's process id; None while there is none."""
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        """Start the process. It is ready some tenths of a second later; packets sent meanwhile wait."""
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
                start_new_session=True,  # Ctrl-C ends the show, which then ends the child
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
        """Send a packet; return whether there was room for it."""
        if self._socket is None:
            return False
        try:
            self._socket.send(packet_of(what))
        except OSError:
            self.left_out += 1
            return False
        return True

    def frame(self, news: int = PER_FRAME) -> None:
        """Receive the child's packets, and restart it if it has died; called once per frame.

        At most `news` packets other than facts are handled.
        """
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
        lost = self._joined is not None  # that process has no keeper any more: replace it by a child
        if lost or self._clock.now() - self._started_at > RESTART_AFTER:
            self._joined = None
            self.restarts += 1
            self._starting = threading.Thread(target=self._start_again, daemon=True)
            self._starting.start()

    def _start_again(self) -> None:
        def again() -> None:
            with contextlib.suppress(OSError):  # without resources now, the next frame tries again
                self._reap()
                self.start()

        run_once(f"the restart of {self._module}", again)

    def stop(self) -> None:
        """Stop the child and close the channel."""
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
        """Return the child's latest facts (about one second old), with dropped packets and restarts."""
        return {**self._facts, "left_out": self.left_out, "restarts": self.restarts}


class Told:
    """The child's end of the channel. Thread: one."""

    def __init__(self, descriptor: int, plan: dict[str, Any] | None = None) -> None:
        """Wait for the plan. A process that already has one, because the show did not start it, passes it as `plan`."""
        for number in (signal.SIGINT, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        self.socket = socket.socket(fileno=descriptor)
        if plan is None:
            self.socket.setblocking(True)
            plan = read_packet(self.socket.recv(LARGEST))
        self.plan: dict[str, Any] = plan
        self.socket.setblocking(False)
        with contextlib.suppress(OSError):
            os.nice(self.plan.get("nice", 2))  # the show's frames have priority
        self.ended = False
        """Whether the show has closed the channel."""

    def packets(self) -> Iterator[Any]:
        """Return the packets received so far."""
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
        """Send facts for the show's status."""
        with contextlib.suppress(OSError):
            self.socket.send(packet_of(facts))
