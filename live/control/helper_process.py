"""Child process of the show with a non-blocking packet channel, and the child's end of that channel.

Packets (see `message_codec`) go through a socket pair that closes when either process ends. A packet that does not fit
is dropped and counted. A child that has died is restarted and gets its configuration again.
"""

import contextlib
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any, Final

from live.base.fault_isolation import run_once
from live.base.system.channel import (
    MAX_PACKET_BYTES,
    Packets,
    listening_socket_of,
    packets_of_argument,
    start_packet_child,
)
from live.base.system.process_control import ignore_interrupts, yield_priority
from live.clock.time_source import Clock
from live.control.message_codec import PacketError, decode_packet, encode_packet

RESTART_AFTER: Final = 2.0
STOP_TIMEOUT: Final = 2.0
PACKETS_PER_FRAME: Final = 8
HELLO: Final = {"hello": True}
"""First message of a process that the show did not start: it asks for the plan."""


def spawn_helper(module: str, *inherit: int) -> tuple[Packets, "subprocess.Popen[bytes]"]:
    """Start a child that runs `module`; return the non-blocking end of its channel, and the child. OSError if there are
    no resources for it.

    `inherit`: file descriptors that the child gets under the same numbers.
    """
    return start_packet_child([sys.executable, "-m", module], inherit=inherit, stdout=subprocess.DEVNULL)


class HelperProcess:
    """The show's end. Thread: the show's; a restart runs in a thread of its own."""

    def __init__(
        self, module: str, clock: Clock, plan: dict[str, Any], on_start: Callable[[], None], *inherit: int,
        on_packet: Callable[[Any], None] = lambda told: None, descriptor: int | None = None,
    ) -> None:  # fmt: skip
        """Configure the child; nothing is started yet.

        `module` is run with `plan` and the clock's origin as its first packet. `on_start` is called for each new child
        and has to send all state. `inherit`: file descriptors that the child gets under the same numbers. `on_packet`
        receives all packets of the child other than facts, which are dicts. `descriptor`: of a socket to a
        process that another program starts and restarts; such a process sends `HELLO`. When the other end of that
        socket is closed, a child is started here.
        """
        self._inherit, self._on_packet, self._descriptor = inherit, on_packet, descriptor
        self._module, self._clock, self._plan, self._on_start = module, clock, plan, on_start
        self._socket: Packets | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._starting: threading.Thread | None = None
        self._started_at = 0.0
        self._facts: dict[str, Any] = {}
        self.dropped = 0
        """Packets dropped for lack of room."""
        self.restarts = 0
        self.damaged = 0
        """Packets from the child that could not be read."""

    @property
    def pid(self) -> int | None:
        """The child's process id; None while there is none."""
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        """Start the process. It is ready some tenths of a second later; packets sent meanwhile wait."""
        if self._descriptor is not None:
            self._socket = socket.socket(fileno=os.dup(self._descriptor))
            self._socket.setblocking(False)
            self._send_plan()
            return
        old = self._socket
        self._socket, self._process = spawn_helper(self._module, *self._inherit)
        if old is not None:
            old.close()
        self._started_at = self._clock.now()
        self._facts = {}  # those of another process
        self._send_plan()

    def _send_plan(self) -> None:
        self.send(self._plan | {"origin": time.perf_counter() - self._clock.now()})
        self._on_start()

    def send(self, packet: object) -> bool:
        """Send a packet; return whether there was room for it."""
        if self._socket is None:
            return False
        try:
            self._socket.send(encode_packet(packet))
        except OSError:
            self.dropped += 1
            return False
        return True

    def frame(self, most: int = PACKETS_PER_FRAME) -> None:
        """Receive the child's packets, and restart it if it has died; called once per frame.

        At most `most` packets other than facts are handled.
        """
        if self._socket is None or self._starting is not None:
            if self._starting is not None and not self._starting.is_alive():
                self._starting = None
            return
        for _ in range(PACKETS_PER_FRAME):
            try:
                data = self._socket.recv(MAX_PACKET_BYTES)
            except BlockingIOError:
                return
            except OSError:
                data = b""
            if not data:
                break
            try:
                told = decode_packet(data)
            except PacketError:
                self.damaged += 1
                continue
            if told == HELLO:
                self._send_plan()
            elif isinstance(told, dict):
                self._facts = told
            else:
                self._on_packet(told)
                most -= 1
                if not most:
                    return
        else:
            return
        lost = self._descriptor is not None  # that process has no keeper any more: replace it by a child
        if lost or self._clock.now() - self._started_at > RESTART_AFTER:
            self._descriptor = None
            self.restarts += 1
            self._starting = threading.Thread(target=self._start_again, daemon=True)
            self._starting.start()

    def _start_again(self) -> None:
        def again() -> None:
            with contextlib.suppress(OSError):  # without resources now, the next frame tries again
                self._reap()
                self.start()

        run_once(f"the restart of {self._module}", again)

    def restart(self) -> None:
        """End the child; the next frames start another one."""
        if self._process is not None:
            self._process.terminate()

    def stop(self) -> None:
        """Stop the child and close the channel."""
        if self._starting is not None:
            self._starting.join(STOP_TIMEOUT)
        if self._socket is not None:
            self._socket.close()
            self._socket = None
        self._reap()

    def _reap(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        try:
            process.wait(timeout=STOP_TIMEOUT)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def status(self) -> dict[str, Any]:
        """Return the child's latest facts (about one second old), with dropped packets and restarts."""
        return {**self._facts, "left_out": self.dropped, "restarts": self.restarts}


class HelperChannel:
    """The child's end of the channel. Thread: one."""

    def __init__(self, word: str, plan: dict[str, Any] | None = None) -> None:
        """Wait for the plan; `word`: how to find this end. A process that already has a plan, because the show did not
        start it, passes it."""
        ignore_interrupts()
        try:
            self.socket = packets_of_argument(word)
        except OSError:  # the show has ended meanwhile
            raise SystemExit(0) from None
        if plan is None:
            self.socket.setblocking(True)
            plan = decode_packet(self.socket.recv(MAX_PACKET_BYTES))
        self.plan: dict[str, Any] = plan
        self.socket.setblocking(False)
        yield_priority(self.plan.get("nice", 2))  # the show's frames have priority
        self.closed = False
        """Whether the show has closed the channel."""

    def listening_socket(self) -> socket.socket:
        """Return the listening socket that the show handed over (`http` in the plan)."""
        return listening_socket_of(self.plan["http"])

    def packets(self) -> Iterator[Any]:
        """Return the packets received so far."""
        while not self.closed:
            try:
                data = self.socket.recv(MAX_PACKET_BYTES)
            except BlockingIOError:
                return
            except OSError:
                data = b""
            if not data:
                self.closed = True
                return
            with contextlib.suppress(PacketError):
                yield decode_packet(data)

    def send(self, packet: object) -> bool:
        """Send a packet; return whether there was room for it."""
        try:
            self.socket.send(encode_packet(packet))
        except OSError:
            return False
        return True

    def send_facts(self, facts: dict[str, Any]) -> None:
        """Send facts for the show's status."""
        self.send(facts)
