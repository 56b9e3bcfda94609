"""Decoder and encoder for Open Sound Control 1.0 packets.

The decoder is strict and bounded: a packet that is malformed or too large is refused as a whole with OscRejected, the
only exception it raises. Work is linear in the packet's length. Besides the standard's types i f s b it accepts
h d T F N I t m; N (nil) and I (impulse) both become None, "no value". All other types (S, c, r, arrays), NaN,
infinities and messages without a type tag string are refused. Time tags and wildcard addresses are returned as they
are. The encoder builds messages with python-osc and packs several into bundles that fit into one datagram.
"""

import re
import struct
from collections.abc import Iterable, Iterator, Sequence
from typing import Final, NamedTuple

from pythonosc.osc_message_builder import OscMessageBuilder

from live.control.registry.rejections import Reason

MAX_PACKET_BYTES: Final = 16_384
MAX_BUNDLE_DEPTH: Final = 4
MAX_MESSAGES: Final = 64
MAX_ARGUMENTS: Final = 64
MAX_ADDRESS_BYTES: Final = 256
MAX_STRING_BYTES: Final = 16_000
"""Maximum length of a text argument; controls allow less, see `Argument.length`."""
MAX_BLOB_BYTES: Final = 1024
IMMEDIATELY: Final = 1
"""The time tag that means "now"; also given to a message outside any bundle."""

Value = float | int | bool | str | bytes | tuple[int, int, int, int] | None
"""Types f d; i h t (a time tag as its 64-bit number); T F; s; b; m (port, status, data 1, data 2); N I."""

_ADDRESS = re.compile(rb"/[!-~]*")
_FORBIDDEN = re.compile(rb"[#,]")
_FORBIDDEN_IN_PATTERN = re.compile(rb"#")
_ZEROS: Final = (b"", b"\0", b"\0\0", b"\0\0\0", b"\0\0\0\0")
_BUNDLE: Final = b"#bundle\0"
_BUNDLE_HEADER = struct.Struct(">8sQ")
_SIZE = struct.Struct(">i")
_NUMBERS: Final = {tag: struct.Struct(form) for tag, form in zip(b"fidht", (">f", ">i", ">d", ">q", ">Q"), strict=True)}
_MIDI = struct.Struct(">4B")
_CONSTANTS: Final[dict[int, bool | None]] = {ord("T"): True, ord("F"): False, ord("N"): None, ord("I"): None}
_INFINITY: Final = float("inf")


class OscRejected(Exception):
    """A packet was refused as a whole, for `reason`."""

    def __init__(self, reason: Reason) -> None:
        super().__init__(reason)
        self.reason = reason


class Message(NamedTuple):
    """One OSC message. A named tuple costs a third of a frozen dataclass, which matters in a flood."""

    address: str
    arguments: tuple[Value, ...]
    timetag: int = IMMEDIATELY
    """NTP time of the innermost bundle (seconds since 1900 in the upper 32 bits)."""


def decode(packet: bytes | bytearray | memoryview) -> list[Message]:
    """Return the messages of one packet in order; OscRejected if any part of it is wrong."""
    data = packet if type(packet) is bytes else bytes(packet)
    size = len(data)
    if not 0 < size <= MAX_PACKET_BYTES:
        raise OscRejected(Reason.PACKET_SIZE)
    if size & 3:
        raise OscRejected(Reason.ALIGNMENT)
    if data[0] == 0x23:  # "#"
        messages: list[Message] = []
        _decode_bundle(data, 0, size, 1, messages)
        return messages
    return [_message(data, 0, size, IMMEDIATELY)]


def _decode_bundle(data: bytes, start: int, stop: int, depth: int, messages: list[Message]) -> None:
    """Append the messages of the bundle data[start:stop]."""
    if depth > MAX_BUNDLE_DEPTH:
        raise OscRejected(Reason.DEPTH)
    if stop - start < _BUNDLE_HEADER.size:
        raise OscRejected(Reason.TRUNCATED)
    name, timetag = _BUNDLE_HEADER.unpack_from(data, start)
    if name != _BUNDLE:
        raise OscRejected(Reason.ADDRESS)
    position = start + _BUNDLE_HEADER.size
    while position < stop:
        (size,) = _SIZE.unpack_from(data, position)  # packets and elements are multiples of 4, so four bytes remain
        position += 4
        if size <= 0 or size & 3 or size > stop - position:
            raise OscRejected(Reason.ELEMENT_SIZE)
        if data[position] == 0x23:
            _decode_bundle(data, position, position + size, depth + 1, messages)
        elif len(messages) >= MAX_MESSAGES:
            raise OscRejected(Reason.MANY_MESSAGES)
        else:
            messages.append(_message(data, position, position + size, timetag))
        position += size


def _message(data: bytes, start: int, stop: int, timetag: int) -> Message:
    """Return the message that fills data[start:stop]."""
    end, position = _string_end(data, start, stop, MAX_ADDRESS_BYTES)
    address = data[start:end]
    forbidden = _FORBIDDEN_IN_PATTERN if b"{" in address else _FORBIDDEN
    if _ADDRESS.fullmatch(address) is None or forbidden.search(address):
        raise OscRejected(Reason.ADDRESS)
    if position >= stop or data[position] != 0x2C:  # ","
        raise OscRejected(Reason.NO_TYPES)
    if data.find(b"\0", position, min(stop, position + 2 + MAX_ARGUMENTS)) < 0 and stop - position > 1 + MAX_ARGUMENTS:
        raise OscRejected(Reason.MANY_ARGUMENTS)
    end, position_of_values = _string_end(data, position, stop, MAX_ADDRESS_BYTES)
    arguments, position = _arguments(data, data[position + 1 : end], position_of_values, stop)
    if position != stop:
        raise OscRejected(Reason.TRAILING)
    return Message(address.decode("ascii"), arguments, timetag)


def _arguments(data: bytes, tags: bytes, position: int, stop: int) -> tuple[tuple[Value, ...], int]:
    """Return the values of type `tags` from `position` on, and the position after them."""
    values: list[Value] = []
    for tag in tags:
        number = _NUMBERS.get(tag)
        if number is not None:
            if position + number.size > stop:
                raise OscRejected(Reason.TRUNCATED)
            (value,) = number.unpack_from(data, position)
            if not -_INFINITY < value < _INFINITY:
                raise OscRejected(Reason.NOT_FINITE)
            values.append(value)
            position += number.size
        elif tag == 0x73:  # "s"
            end, after = _string_end(data, position, stop, MAX_STRING_BYTES)
            try:
                values.append(data[position:end].decode("utf-8"))
            except UnicodeDecodeError:
                raise OscRejected(Reason.TEXT) from None
            position = after
        elif tag in _CONSTANTS:
            values.append(_CONSTANTS[tag])
        elif tag == 0x62:  # "b"
            blob, position = _blob(data, position, stop)
            values.append(blob)
        elif tag == 0x6D:  # "m"
            if position + 4 > stop:
                raise OscRejected(Reason.TRUNCATED)
            values.append(_MIDI.unpack_from(data, position))
            position += 4
        else:
            raise OscRejected(Reason.UNKNOWN_TYPE)
    return tuple(values), position


def _string_end(data: bytes, start: int, stop: int, longest: int) -> tuple[int, int]:
    """Return the end of the string of at most `longest` bytes at `start`, and the position after its padding."""
    end = data.find(b"\0", start, min(stop, start + longest + 1))
    if end < 0:
        raise OscRejected(Reason.UNTERMINATED)
    after = (end + 4) & ~3  # strings begin and end at multiples of 4 from the packet's start
    if data[end:after] != _ZEROS[after - end]:
        raise OscRejected(Reason.PADDING)
    return end, after


def _blob(data: bytes, position: int, stop: int) -> tuple[bytes, int]:
    """Return the blob at `position`, and the position after its padding."""
    if position + 4 > stop:
        raise OscRejected(Reason.TRUNCATED)
    (size,) = _SIZE.unpack_from(data, position)
    if not 0 <= size <= MAX_BLOB_BYTES:
        raise OscRejected(Reason.BLOB)
    end = position + 4 + size
    after = (end + 3) & ~3
    if after > stop:
        raise OscRejected(Reason.TRUNCATED)
    if data[end:after] != _ZEROS[after - end]:
        raise OscRejected(Reason.PADDING)
    return data[position + 4 : end], after


MAX_DATAGRAM_BYTES: Final = 1400
"""Size of a datagram that networks do not fragment."""
_HEAD: Final = b"#bundle\0" + struct.pack(">Q", 1)


def encode(address: str, values: Sequence[object] = ()) -> bytes:
    """Return one message as bytes."""
    builder = OscMessageBuilder(address)
    for value in values:
        builder.add_arg(value)  # type: ignore[arg-type]
    return bytes(builder.build().dgram)


def bundles(messages: Iterable[bytes]) -> Iterator[bytes]:
    """Yield datagrams that hold these messages in order: a single message as it is, several as a bundle."""
    row: list[bytes] = []
    size = len(_HEAD)
    for message in messages:
        if row and size + 4 + len(message) > MAX_DATAGRAM_BYTES:
            yield _encode_bundle(row)
            row, size = [], len(_HEAD)
        row.append(message)
        size += 4 + len(message)
    if row:
        yield _encode_bundle(row)


def _encode_bundle(row: list[bytes]) -> bytes:
    if len(row) == 1:
        return row[0]
    return _HEAD + b"".join(_SIZE.pack(len(message)) + message for message in row)
