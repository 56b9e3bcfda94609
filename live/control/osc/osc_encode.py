"""What is sent as OSC: messages as python-osc builds them, and rows of them in bundles that fit into a datagram."""

import struct
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from pythonosc.osc_message_builder import OscMessageBuilder

MOST_BYTES: Final = 1400
"""A datagram that no network on the way has to cut up."""
_HEAD: Final = b"#bundle\0" + struct.pack(">Q", 1)
_SIZE = struct.Struct(">i")


def encode(address: str, values: Sequence[object] = ()) -> bytes:
    """One message."""
    builder = OscMessageBuilder(address)
    for value in values:
        builder.add_arg(value)  # type: ignore[arg-type]
    return bytes(builder.build().dgram)


def bundles(messages: Iterable[bytes]) -> Iterator[bytes]:
    """Datagrams that hold these messages in their order: one alone as it is, more in bundles."""
    row: list[bytes] = []
    size = len(_HEAD)
    for message in messages:
        if row and size + 4 + len(message) > MOST_BYTES:
            yield _bundle(row)
            row, size = [], len(_HEAD)
        row.append(message)
        size += 4 + len(message)
    if row:
        yield _bundle(row)


def _bundle(row: list[bytes]) -> bytes:
    if len(row) == 1:
        return row[0]
    return _HEAD + b"".join(_SIZE.pack(len(message)) + message for message in row)
