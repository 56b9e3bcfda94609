"""One connection's bytes in both directions over a bus that may lose messages: in order, complete, and bounded.

Each side numbers the bytes that it sends, keeps them until they have arrived, and sends again what is missed (selective
repeat, as in RFC 3366 section 2). It sends no more than the other side has room for: what a slow browser has not
read waits where it is made, not on the way.
"""

from collections import deque
from collections.abc import Callable
from typing import Final

CHUNK: Final = 16 * 1024
"""Most bytes of a message."""
WINDOW: Final = 256 * 1024
"""Most bytes on the way, or arrived and not handed on."""
RESEND_AFTER: Final = 0.3
"""Seconds without progress after which what has not arrived is sent again, ..."""
LOST_AGAIN: Final = 0.05
"""... the same piece at most so often where the other side misses it, ..."""
GIVE_UP: Final = 10.0
"""... and after which the connection has failed."""

Send = Callable[[str, int, int, bytes], None]
"""Sends a message: kind, offset, up to where bytes have been handed on, data (`live.nodes.messages.PageFrame`)."""


class ByteFlow:
    """One end of a connection. Thread: one. Times are of any monotonic clock [s]."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self._waiting: deque[tuple[int, bytes]] = deque()  # sent, and not arrived yet, with their places
        self._next = self._arrived = self._read_there = 0
        self._ended_at: int | None = None  # where the own bytes end
        self._progress_at = self._resent_at = 0.0
        self._missed = -1  # the place of what was sent again last because it was missed
        self._received: deque[bytes] = deque()
        self._expected = self._read = 0
        self._unconfirmed = False
        self._early: dict[int, bytes] = {}  # arrived before others that are missing, by their places
        self.end_received = False
        """Whether the other side sends no more."""
        self.failed = False
        """Whether the other side does not answer any more, or has given up."""

    # -- the own bytes ---------------------------------------------------------------------------------------------

    @property
    def room(self) -> int:
        """How many bytes may be sent now; 0 while there is no room for a whole chunk, lest chunks become ever smaller
        (RFC 1122 section 4.2.3.4)."""
        room = self._read_there + WINDOW - self._next
        return room if self._ended_at is None and room >= CHUNK else 0

    @property
    def done(self) -> bool:
        """Whether both directions have ended, and all has arrived and been handed on."""
        return self._ended_at is not None and not self._waiting and self.end_received and not self._received

    def write(self, data: bytes, now: float) -> None:
        """Send bytes, at most `room`."""
        for begin in range(0, len(data), CHUNK):
            self._put(data[begin : begin + CHUNK], now)

    def end(self, now: float) -> None:
        """Send no more."""
        if self._ended_at is None:
            self._put(b"", now)
            self._ended_at = self._next

    def _put(self, data: bytes, now: float) -> None:
        if not self._waiting:
            self._progress_at = now
        self._waiting.append((self._next, data))
        self._transmit(self._next, data)
        self._next += len(data) or 1  # the end counts as a byte

    def _transmit(self, offset: int, data: bytes) -> None:
        self._send("data" if data else "end", offset, self._read, data)

    # -- the other side's ------------------------------------------------------------------------------------------

    def take(self) -> bytes:
        """Return bytes that have arrived; empty if there are none."""
        return self._received.popleft() if self._received else b""

    def handed_on(self, count: int) -> None:
        """Say that so many bytes of `take` have been read: there is room for others."""
        self._read += count
        self._acknowledge("ack")

    def _acknowledge(self, kind: str) -> None:
        self._unconfirmed = False
        self._send(kind, self._expected, self._read, b"")

    def receive(self, kind: str, offset: int, read: int, data: bytes, now: float) -> None:
        """Take a message of the other side; ValueError for one that cannot be."""
        if kind in ("data", "end"):
            self._read_there = max(self._read_there, min(read, self._next))
            self._receive_bytes(kind, offset, data)
        elif kind in ("ack", "lost"):
            if not 0 <= read <= offset <= self._next:
                raise ValueError("more bytes arrived than were sent")
            self._read_there = max(self._read_there, read)
            self._confirm(offset, now)
            if kind == "lost" and self._waiting and (offset != self._missed or now - self._resent_at >= LOST_AGAIN):
                self._missed, self._resent_at = offset, now
                self._transmit(*self._waiting[0])
        elif kind == "ask":
            self._acknowledge("ack")
        elif kind == "reset":
            self.failed = True
        else:
            raise ValueError("no kind of message")

    def _receive_bytes(self, kind: str, offset: int, data: bytes) -> None:
        if len(data) > CHUNK or (kind == "data") is not bool(data):
            raise ValueError("a chunk of data expected")
        if offset + len(data) > self._read + WINDOW:
            raise ValueError("more bytes than there is room for")
        if offset >= self._expected and not self.end_received:
            self._early[offset] = data
        while (data_next := self._early.pop(self._expected, None)) is not None:
            self._expected += len(data_next) or 1
            if data_next:
                self._received.append(data_next)
            else:
                self.end_received = True
        if self._early:
            self._acknowledge("lost")
        elif self.end_received or offset + len(data) < self._expected:
            self._acknowledge("ack")  # nothing will be handed on, or the word of it was lost
        else:
            self._unconfirmed = True  # usually with the word that it has been handed on, a moment later

    def _confirm(self, arrived: int, now: float) -> None:
        if arrived > self._arrived:
            self._arrived, self._progress_at = arrived, now
        while self._waiting and self._waiting[0][0] + (len(self._waiting[0][1]) or 1) <= arrived:
            self._waiting.popleft()

    def update(self, now: float) -> None:
        """Confirm what has arrived, and send again what has not; called several times a second."""
        if self._unconfirmed:
            self._acknowledge("ack")
        if not self._waiting:
            if not self.room and self._ended_at is None and now - self._resent_at > RESEND_AFTER:
                self._resent_at = now
                self._acknowledge("ask")  # the word that there is room may have been lost
            return
        if now - self._progress_at > GIVE_UP:
            self.failed = True
        elif now - max(self._progress_at, self._resent_at) > RESEND_AFTER:
            self._resent_at = now
            for offset, data in self._waiting:
                self._transmit(offset, data)
