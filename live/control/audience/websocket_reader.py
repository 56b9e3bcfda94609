"""WebSocket reader for phones that handles frames directly in the protocol callback, without a task switch per frame.

It supports the part of RFC 6455 that phones need: whole, masked frames of at most 125 bytes, close, ping and pong.
Longer, fragmented, unmasked or reserved frames close the connection. Sending uses aiohttp's own path.
"""

import asyncio
from typing import Any, Final

from live.control.audience.phone_registry import Phone
from live.control.audience.rate_limit import RefusalReason
from live.control.audience.session_state import SessionState

BINARY: Final = 0x82
TEXT: Final = 0x81
CLOSE: Final = 0x88
PING: Final = 0x89
PONG: Final = 0x8A
"""First bytes of whole frames."""
MAX_PAYLOAD: Final = 125


def binary_frame(payload: bytes) -> bytes:
    """Return a server's frame of a message of less than 64 KiB (RFC 6455, 5.2)."""
    size = len(payload)
    return (bytes((BINARY, size)) if size <= MAX_PAYLOAD else bytes((BINARY, 126, size >> 8, size & 255))) + payload


class WebSocketReader(asyncio.Protocol):
    """Protocol that takes a connection over from the server's `handler`. Thread: the gateway's loop."""

    def __init__(self, hall: SessionState, phone: Phone, handler: Any) -> None:
        self._session, self._phone, self._handler = hall, phone, handler
        self._transport: Any = phone.transport
        self._rest = b""
        self.disconnected: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        """Done when the connection is lost."""

    def data_received(self, data: bytes) -> None:
        """Handle every whole frame."""
        if self._rest:
            data, self._rest = self._rest + data, b""
        begin, end, now = 0, len(data), self._session.now()
        while end - begin >= 6:
            size = data[begin + 1] - 0x80
            if not 0 <= size <= MAX_PAYLOAD:
                self._session.refused[RefusalReason.LONG if size > MAX_PAYLOAD else RefusalReason.MALFORMED] += 1
                self._transport.abort()
                return
            after = begin + 6 + size
            if after > end:
                break
            payload = data[begin + 6 : after]
            if size:
                mask = (data[begin + 2 : begin + 6] * (size // 4 + 1))[:size]
                whole = int.from_bytes(payload, "little") ^ int.from_bytes(mask, "little")
                payload = whole.to_bytes(size, "little")
            if not self._handle_frame(data[begin], payload, now):
                self._transport.abort()
                return
            begin = after
        self._rest = data[begin:]

    def _handle_frame(self, first: int, payload: bytes, now: float) -> bool:
        """Handle one frame; return whether the phone may stay."""
        if first == BINARY:
            answer = self._session.handle_message(self._phone, payload, now)
            if answer:
                self._transport.write(binary_frame(answer))
            return answer is not None
        if first == PING:
            self._transport.write(bytes((PONG, len(payload))) + payload)
            return (
                self._session.handle_message(self._phone, b"", now) is not None
            )  # it counts against the rate limit only
        if first == PONG:
            return True
        if first == CLOSE:
            self._phone.left_by_itself = True
            self._transport.write(bytes((CLOSE, 0)))
            self._transport.close()
            return True
        return self._session.count_fault(self._phone, RefusalReason.MALFORMED) and first == TEXT

    def pause_writing(self) -> None:
        """Forward the pause to the handler."""
        self._handler.pause_writing()

    def resume_writing(self) -> None:
        """Forward the resumption to the handler."""
        self._handler.resume_writing()

    def eof_received(self) -> bool:
        """Close the connection at the end of input."""
        return False

    def connection_lost(self, error: Exception | None) -> None:
        """Forward the end of the connection to the handler."""
        self._handler.connection_lost(error)
        if not self.disconnected.done():
            self.disconnected.set_result(None)
