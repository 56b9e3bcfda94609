"""Tests of the WebSocket reader: frames split at any position, and frames that end the connection."""

import asyncio
import random

import pytest

from live.control.audience.phone_registry import Phone
from live.control.audience.session_state import SessionState
from live.control.audience.websocket_reader import WebSocketReader
from tests.control.audience.test_hostile_phones import frame


class FakeTransport:
    """A transport that records writes and its end."""

    def __init__(self):
        self.written, self.ended = [], ""

    def write(self, data):
        self.written.append(data)

    def abort(self):
        self.ended = "aborted"

    def close(self):
        self.ended = "closed"


class RecordingSession(SessionState):
    """A session that records its messages."""

    def __init__(self):
        super().__init__({"most": 4, "per_address": 4, "first": 1, "visible": 4, "origin": 0.0})
        self.heard = []

    def handle_message(self, phone, data, now):
        self.heard.append(data)
        return b"pong" if data[:1] == b"\x02" else b""


def read_chunks(*chunks):
    """The session after reading these bytes, and the transport."""

    async def everything():
        hall, wire = RecordingSession(), FakeTransport()
        reading = WebSocketReader(hall, Phone(1, 0, 0, None, wire), wire)
        for chunk in chunks:
            if wire.ended != "aborted":
                reading.data_received(chunk)
        return hall, wire

    return asyncio.run(everything())


def test_messages_are_independent_of_chunk_boundaries():
    chance = random.Random(9)
    for _ in range(40):
        sent = [chance.randbytes(chance.choice((0, 1, 3, 6, 9, 125))) for _ in range(chance.randrange(1, 12))]
        data, chunks = b"".join(map(frame, sent)), []
        while data:
            cut = chance.randrange(1, 40)
            chunks, data = [*chunks, data[:cut]], data[cut:]
        hall, wire = read_chunks(*chunks)
        assert hall.heard == sent
        assert wire.written == [b"\x82\x04pong"] * sum(each[:1] == b"\x02" for each in sent)
        assert wire.ended == ""


@pytest.mark.parametrize(
    ("data", "ended", "written"),
    [
        (frame(b"x" * 126), "aborted", []),
        (frame(b"", length=1 << 62), "aborted", []),
        (frame(b"abcdef", masked=False), "aborted", []),
        (frame(b"abcdef", fin=False), "aborted", []),
        (frame(b"abcdef", opcode=0), "aborted", []),
        (frame(b"abcdef", opcode=3), "aborted", []),
        (frame(b"abcdef", reserved=0x40), "aborted", []),
        (frame(b"", opcode=8), "closed", [b"\x88\x00"]),
        (frame(b"there?", opcode=9), "", [b"\x8a\x06there?"]),
        (frame(b"here", opcode=10), "", []),
        (frame(b"words", opcode=1), "", []),
        (b"".join(frame(b"words", opcode=1) for _ in range(4)), "aborted", []),
    ],
)
def test_unexpected_frame_is_answered_ignored_or_ends_connection(data, ended, written):
    hall, wire = read_chunks(data)
    assert (wire.ended, wire.written) == (ended, written)
    assert set(hall.heard) <= {b""}
