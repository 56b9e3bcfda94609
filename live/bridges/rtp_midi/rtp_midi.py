"""MIDI over RTP: payload format (RFC 6295), session protocol (Apple's), and an input port for both.

Works with sessions of macOS and iOS, rtpMIDI on Windows and rtpmidid. It only accepts invitations. Recovery journals
are not read; if packets are lost, all notes are ended.
"""

import contextlib
import os
import select
import socket
import struct
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from live.control.midi.midi_streams import Direction, MidiTokenizer, Receive, parse_address
from live.control.osc.osc_subscriptions import is_local_network
from live.control.worker_thread import WorkerThread

SocketAddress = tuple[str, int]

INVITATION, ACCEPTED, REFUSED, GOODBYE, SYNC = b"IN", b"OK", b"NO", b"BY", b"CK"
VERSION: Final = 2
MAX_SESSIONS: Final = 8
SESSION_TIMEOUT: Final = 70.0
"""Seconds without a packet after which a session ends; initiators synchronise about every ten seconds."""
MAX_NAME: Final = 64
TICKS_PER_SECOND: Final = 10_000.0
"""Timestamps count tenths of a millisecond."""
_EXCHANGE: Final = struct.Struct(">H2sIII")
_SYNC: Final = struct.Struct(">H2sIB3xQQQ")
_RTP: Final = struct.Struct(">BBHII")
MIDI_TYPE: Final = 0x61
ALL_NOTES_OFF: Final = 123
_LENGTHS: Final = {8: 3, 9: 3, 10: 3, 11: 3, 12: 2, 13: 2, 14: 3}
_COMMON: Final = {0xF1: 2, 0xF2: 3, 0xF3: 2}


class BadPacket(ValueError):
    """The datagram is not valid MIDI over RTP."""


def midi_bytes(payload: bytes) -> bytes:
    """Return the MIDI bytes of a payload without the delta times; BadPacket if it is truncated.

    An exclusive message may be split over packets: F0 … F0, F7 … F0, F7 … F7; F7 … F4 cancels it.
    """
    if not payload:
        raise BadPacket("no header")
    long = payload[0] & 0x80
    if long and len(payload) < 2:
        raise BadPacket("no length")
    size = (payload[0] & 0x0F) << 8 | payload[1] if long else payload[0] & 0x0F
    begin = 2 if long else 1
    part = payload[begin : begin + size]
    if len(part) < size:
        raise BadPacket("cut off")
    found, at, running = bytearray(), 0, 0
    timed = bool(payload[0] & 0x20)
    while at < size:
        if timed:
            at = _end_of_time(part, at)
            if at == size:  # a delta time may come last
                break
        timed = True
        end, running = _end_of_command(part, at, running)
        found += _without_segment_marks(part[at:end])
        at = end
    return bytes(found)


def _without_segment_marks(command: bytes) -> bytes:
    """Return a command as sent over a MIDI cable: segments of an exclusive message lose their segment marks."""
    if command[0] not in (0xF0, 0xF7):
        return command
    return command[command[0] == 0xF7 : len(command) - (command[-1] == 0xF0)]


def _end_of_time(part: bytes, at: int) -> int:
    """Return the position after a delta time of one to four bytes."""
    for end in range(at + 1, at + 5):
        if end > len(part):
            raise BadPacket("a time is cut off")
        if part[end - 1] < 0x80:
            return end
    raise BadPacket("a time of more than four bytes")


def _end_of_command(part: bytes, at: int, running: int) -> tuple[int, int]:
    """Return the position after the command at `at`, and the running status there."""
    status, end = part[at], at
    if status < 0x80:
        if not running:
            raise BadPacket("data without a status")
        return _checked(part, at, at + _LENGTHS[running >> 4] - 1), running
    if status < 0xF0:
        return _checked(part, at, at + _LENGTHS[status >> 4]), status
    if status in (0xF0, 0xF7):  # an exclusive message, or a segment of one
        end = at + 1
        while end < len(part) and part[end] < 0x80:
            end += 1
        if end == len(part) or part[end] not in (0xF0, 0xF7, 0xF4):
            raise BadPacket("an exclusive message without end")
        return end + 1, 0
    if status >= 0xF8:
        return at + 1, running
    return _checked(part, at, at + _COMMON.get(status, 1)), 0


def _checked(part: bytes, at: int, end: int) -> int:
    if end > len(part):
        raise BadPacket("a command is cut off")
    return end


@dataclass(slots=True)
class _Session:
    """One session with a participant that has invited us."""

    source: int
    token: int
    name: str
    last_packet: float
    data: SocketAddress | None = None
    """Source address of its MIDI data, set when it has also sent the invitation to the data port."""
    number: int | None = None
    """Sequence number of its last packet."""
    tokens: MidiTokenizer = field(default_factory=MidiTokenizer)


class RtpMidi:
    """Protocol state of one pair of ports. No I/O: datagrams are passed in. Use from one thread at a time."""

    def __init__(self, source: int, name: str = "ChoreoGraphics") -> None:
        """`source`: our own identifier (SSRC), any 32-bit number."""
        self.rejected = 0
        """Number of datagrams that were malformed, refused, or outside any session."""
        self.lost = 0
        """Number of lost packets."""
        self._source, self._name = source, name
        self._sessions: dict[tuple[str, int], _Session] = {}

    @property
    def participants(self) -> tuple[str, ...]:
        """Names of the connected participants."""
        return tuple(session.name for session in self._sessions.values() if session.data is not None)

    def handle(
        self, datagram: bytes, sender: SocketAddress, now: float, *, control: bool
    ) -> tuple[list[bytes], list[bytes]]:
        """Return (answers, MIDI messages) for a datagram from `sender` at `now` [s], on the control or data port."""
        self._expire(now)
        try:
            if datagram[:2] == b"\xff\xff":
                return self._handle_command(datagram, sender, now, control=control), []
            if control:
                raise BadPacket("MIDI data on the control port")
            return [], list(self._decode_data(datagram, sender, now))
        except (BadPacket, struct.error):
            self.rejected += 1
            return [], []

    def _handle_command(self, datagram: bytes, sender: SocketAddress, now: float, *, control: bool) -> list[bytes]:
        what = datagram[2:4]
        if what == SYNC:
            return self._synchronise(datagram, sender, now)
        _, _, version, token, source = _EXCHANGE.unpack_from(datagram)
        key = (sender[0], source)
        if what == INVITATION and version == VERSION:
            name = datagram[_EXCHANGE.size :].split(b"\0")[0][:MAX_NAME].decode("utf-8", "replace")
            return [self._accept_invitation(key, token, name, sender, now, control=control)]
        session = self._sessions.get(key)
        if what == GOODBYE and session is not None:  # with or without its token; macOS sends none
            del self._sessions[key]
            return []
        if what == b"RS":
            return []
        raise BadPacket("no such session")

    def _accept_invitation(
        self, key: SocketAddress, token: int, name: str, sender: SocketAddress, now: float, *, control: bool
    ) -> bytes:
        session = self._sessions.get(key)
        if control and session is None and len(self._sessions) < MAX_SESSIONS:
            session = self._sessions[key] = _Session(key[1], token, name, now)
        if session is None or (session.token != token and not control):
            self.rejected += 1
            return _EXCHANGE.pack(0xFFFF, REFUSED, VERSION, token, self._source)
        session.token, session.last_packet = token, now
        if not control:
            session.data, session.number = sender, None
        answer = _EXCHANGE.pack(0xFFFF, ACCEPTED, VERSION, token, self._source)
        return answer + self._name.encode() + b"\0"

    def _synchronise(self, datagram: bytes, sender: SocketAddress, now: float) -> list[bytes]:
        _, _, source, count, first, _, _ = _SYNC.unpack_from(datagram)
        session = self._sessions.get((sender[0], source))
        if session is None or session.data != sender:
            raise BadPacket("no such session")
        session.last_packet = now
        if count != 0:
            return []
        return [_SYNC.pack(0xFFFF, SYNC, self._source, 1, first, int(now * TICKS_PER_SECOND), 0)]

    def _decode_data(self, datagram: bytes, sender: SocketAddress, now: float) -> Iterator[bytes]:
        flags, kind, number, _, source = _RTP.unpack_from(datagram)
        session = self._sessions.get((sender[0], source))
        if session is None or session.data != sender or flags >> 6 != 2 or kind & 0x7F != MIDI_TYPE:
            raise BadPacket("of no session")
        data = midi_bytes(datagram[_RTP.size + 4 * (flags & 0x0F) :])
        session.last_packet = now
        missed = 0 if session.number is None else (number - session.number - 1) & 0xFFFF
        if missed >= 0x8000:
            raise BadPacket("late, or twice")
        session.number = number
        if missed:
            self.lost += missed
            session.tokens.reset()
            yield from (bytes((0xB0 | channel, ALL_NOTES_OFF, 0)) for channel in range(16))
        yield from session.tokens.feed(data)

    def _expire(self, now: float) -> None:
        for key in [key for key, session in self._sessions.items() if now - session.last_packet > SESSION_TIMEOUT]:
            del self._sessions[key]


CHECK_INTERVAL: Final = 0.1
"""Seconds between checks whether to stop."""
MAX_DATAGRAM_BYTES: Final = 2048
MAX_DATAGRAMS: Final = 64
"""Maximum number of datagrams read from one socket before the other has its turn."""


class RtpPort:
    """RTP-MIDI input port with its own thread and two sockets: control at PORT and data at PORT + 1."""

    system_runs = True

    def __init__(self, direction: Direction, name: str) -> None:
        """Bind both sockets; OSError, or ValueError for an invalid address."""
        host, port = parse_address(name)
        if direction == "output":
            raise ValueError("rtp: is for input only: name a MIDI port or tcp:HOST:PORT")
        if port == 65535:
            raise ValueError(f"{name!r}: the next port is needed, too; choose a lower one")
        self.name = name
        self.exists = True
        self.protocol = RtpMidi(int.from_bytes(os.urandom(4)))
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._sockets: list[socket.socket] = []
        self._receive: Receive = lambda message: None
        self._worker = WorkerThread(name, self._read_loop, part=f"MIDI at {name}", end=self._end)
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
        """Pass messages to `receive` from its own thread."""
        self._receive = receive
        self._worker.start()

    def send(self, message: bytes) -> None:
        """Not supported; raises OSError."""
        raise OSError("MIDI over RTP is for input only")

    def close(self) -> None:
        """Close both sockets."""
        self._worker.stop()
        for sock in self._sockets:
            sock.close()
        self.exists = False

    def _end(self) -> None:
        self.exists = False

    def _read_loop(self) -> None:
        control, data = self._sockets
        while not self._worker.stopping.is_set():
            try:
                ready, _, _ = select.select([control, data], [], [], CHECK_INTERVAL)
            except (OSError, ValueError):
                break
            for sock in ready:
                for _ in range(MAX_DATAGRAMS):
                    if not self._read(sock, control=sock is control):
                        break

    def _read(self, sock: socket.socket, *, control: bool) -> bool:
        """Read one datagram; return False if there is none."""
        try:
            datagram, sender = sock.recvfrom(MAX_DATAGRAM_BYTES)
        except BlockingIOError:
            return False
        except OSError:  # an earlier answer was undeliverable
            return True
        if not is_local_network(sender[0]):
            self.protocol.rejected += 1
            return True
        answers, messages = self.protocol.handle(datagram, (sender[0], sender[1]), time.monotonic(), control=control)
        for answer in answers:
            with contextlib.suppress(OSError):
                sock.sendto(answer, sender)
        for message in messages:
            self._receive(message)
        return True
