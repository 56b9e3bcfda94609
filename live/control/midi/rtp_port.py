"""RtpPort: MIDI over RTP as a port that is listened to: sessions of macOS and iOS, rtpMIDI of Windows, rtpmidid."""

import contextlib
import os
import select
import socket
import threading
import time
from typing import Final

from live.base.fault_isolation import keep_running
from live.control.midi.midi_streams import RTP, Direction, Receive, address_of
from live.control.midi.rtp_midi import RtpMidi
from live.control.osc.osc_subscriptions import is_near

LOOK: Final = 0.1
"""Seconds after which it is looked whether to end."""
LARGEST: Final = 2048
AT_ONCE: Final = 64
"""Datagrams that are read of one socket before the other has its turn."""


class RtpPort:
    """Two sockets, control at PORT and data at PORT + 1, and a thread of its own. It hears and is never told."""

    system_runs = True

    def __init__(self, direction: Direction, name: str) -> None:
        """Bind both; OSError, or ValueError for an address that is none."""
        host, port = address_of(name)
        if direction == "output":
            raise ValueError(f"{RTP} hears and cannot be told: name a MIDI port or tcp:HOST:PORT")
        if port == 65535:
            raise ValueError(f"{name!r}: the port after it is needed, too")
        self.name = name
        self.there = True
        self.protocol = RtpMidi(int.from_bytes(os.urandom(4)))
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._sockets: list[socket.socket] = []
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        try:
            for number in (port, port + 1):
                sock = socket.socket(family, socket.SOCK_DGRAM)
                self._sockets.append(sock)
                sock.bind((host, number))
                sock.setblocking(False)
        except BaseException:
            self.close()
            raise

    def listen(self, receive: Receive) -> None:
        """Hand over what comes, on a thread of its own."""
        self._thread = threading.Thread(target=self._run, args=(receive,), name=self.name, daemon=True)
        self._thread.start()

    def send(self, message: bytes) -> None:
        """It cannot."""
        raise OSError("MIDI over RTP is only listened to")

    def close(self) -> None:
        """Free both sockets."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=2.0)
        for sock in self._sockets:
            sock.close()
        self.there = False

    def _run(self, receive: Receive) -> None:
        keep_running(f"MIDI at {self.name}", lambda: self._hear(receive), self._stop.wait)
        self.there = False

    def _hear(self, receive: Receive) -> None:
        control, data = self._sockets
        while not self._stop.is_set():
            try:
                ready, _, _ = select.select([control, data], [], [], LOOK)
            except (OSError, ValueError):
                break
            for sock in ready:
                for _ in range(AT_ONCE):
                    if not self._read(sock, receive, control=sock is control):
                        break

    def _read(self, sock: socket.socket, receive: Receive, *, control: bool) -> bool:
        """Read one datagram, if there is one."""
        try:
            datagram, sender = sock.recvfrom(LARGEST)
        except BlockingIOError:
            return False
        except OSError:  # an answer could not be delivered
            return True
        if not is_near(sender[0]):
            self.protocol.rejected += 1
            return True
        answers, messages = self.protocol.hear(datagram, (sender[0], sender[1]), time.monotonic(), control=control)
        for answer in answers:
            with contextlib.suppress(OSError):
                sock.sendto(answer, sender)
        for message in messages:
            receive(message)
        return True
