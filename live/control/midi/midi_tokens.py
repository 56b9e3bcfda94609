"""MidiTokens: a stream of MIDI bytes cut into messages, as the MIDI 1.0 specification has them.

For bytes of a wire, a raw device, a socket or a network packet. mido 1.3.3's parser loses running status and every
message that a real-time byte falls into, and keeps exclusive messages without end; so these bytes are cut here.
"""

from collections.abc import Iterable, Iterator
from typing import Final

SYSEX, SYSEX_END = 0xF0, 0xF7
REAL_TIME: Final = 0xF8
UNDEFINED: Final = frozenset((0xF4, 0xF5, 0xF9, 0xFD))
SYSEX_MOST: Final = 4096
"""Bytes of an exclusive message at most; of a longer one nothing is kept."""

_CHANNEL_LENGTH: Final = (3, 3, 3, 3, 2, 2, 3)
"""Bytes of a channel message by its kind, from note-off (8) on."""
_COMMON_LENGTH: Final = {0xF1: 2, 0xF2: 3, 0xF3: 2, 0xF6: 1}


class MidiTokens:
    """Cuts one sender's bytes. Pure; thread: one at a time.

    A real-time byte is told at once, wherever it stands. Data bytes without a status use the last channel status
    again, until a system common or exclusive message. What is cut off by another status is dropped and counted.
    """

    def __init__(self) -> None:
        self.stray = 0
        """Data bytes that belong to nothing."""
        self.cut_off = 0
        """Messages that another status byte cut off, exclusive ones too."""
        self.undefined = 0
        """Status bytes that mean nothing."""
        self.too_long = 0
        """Exclusive messages that were longer than is kept."""
        self._running = 0
        self._message = bytearray()  # what has begun and is not whole
        self._length = 0  # of it when it is whole; 0: none has begun, or an exclusive one
        self._skips = False  # the rest of an exclusive message that is too long

    @property
    def rejected(self) -> int:
        """All that could not be used."""
        return self.stray + self.cut_off + self.undefined + self.too_long

    def feed(self, data: Iterable[int]) -> Iterator[bytes]:
        """The messages that are whole with `data` (0 to 255 each), each with its status byte first."""
        for byte in data:
            found = self._data(byte) if byte < 0x80 else self._status(byte)
            if found:
                yield found

    def end(self) -> None:
        """The sender has gone: what has begun is dropped, and running status with it."""
        self._cut()
        self._running = 0

    def _data(self, byte: int) -> bytes:
        message = self._message
        if not message:
            if not self._running:
                self.stray += not self._skips
                return b""
            message.append(self._running)
            self._length = _CHANNEL_LENGTH[(self._running >> 4) - 8]
        message.append(byte)
        if message[0] == SYSEX:
            if len(message) >= SYSEX_MOST:
                self.too_long += 1
                message.clear()
                self._skips = True
            return b""
        return self._whole() if len(message) == self._length else b""

    def _status(self, status: int) -> bytes:
        if status >= REAL_TIME:
            if status in UNDEFINED:
                self.undefined += 1
                return b""
            return bytes((status,))
        if status == SYSEX_END:
            return self._end_sysex()
        self._cut()
        self._running = status if status < SYSEX else 0
        if status in UNDEFINED:
            self.undefined += 1
            return b""
        self._message.append(status)
        self._length = _CHANNEL_LENGTH[(status >> 4) - 8] if status < SYSEX else _COMMON_LENGTH.get(status, 0)
        return self._whole() if self._length == 1 else b""

    def _end_sysex(self) -> bytes:
        skipped, self._skips = self._skips, False
        if self._message[:1] == b"\xf0":
            self._message.append(SYSEX_END)
            return self._whole()
        if not skipped:
            self._cut()
            self.undefined += 1  # the end of what never began
        self._running = 0
        return b""

    def _cut(self) -> None:
        self.cut_off += bool(self._message)
        self._message.clear()
        self._skips = False

    def _whole(self) -> bytes:
        found = bytes(self._message)
        self._message.clear()
        return found
