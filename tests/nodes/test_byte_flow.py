"""Bytes arrive whole and in order whatever the bus loses, and no more are on the way than there is room for."""

import random

import pytest

from live.nodes.byte_flow import CHUNK, GIVE_UP, WINDOW, ByteFlow


class Line:
    """Two ends, with delays and losses between them; time is the test's."""

    def __init__(self, *, loss=0.0, delay=0.005, seed=2):
        self.now, self.loss, self.delay = 100.0, loss, delay
        self.chance, self.coming, self.sent = random.Random(seed), [], 0
        self.left = ByteFlow(lambda *what: self.post("right", what))
        self.right = ByteFlow(lambda *what: self.post("left", what))

    def post(self, to, what):
        self.sent += 1
        if self.chance.random() >= self.loss:
            self.coming.append((self.now + self.delay * (1.0 + self.chance.random()), to, what))

    def turn(self, seconds=0.01):
        self.now += seconds
        due = [each for each in self.coming if each[0] <= self.now]
        self.coming = [each for each in self.coming if each[0] > self.now]
        for _, to, what in due:  # not in the order of their times: they overtake each other
            getattr(self, to).receive(*what, self.now)
        self.left.update(self.now)
        self.right.update(self.now)


def taken(flow):
    found = b""
    while data := flow.take():
        flow.handed_on(len(data))
        found += data
    return found


@pytest.mark.parametrize("loss", [0.0, 0.02, 0.3])
def test_all_bytes_arrive_in_both_directions_and_both_ends_are_done(loss):
    line, data = Line(loss=loss), random.Random(1).randbytes(WINDOW + 12_345)
    there, back, at = b"", b"", {"left": 0, "right": 0}
    while not (line.left.done and line.right.done):
        for name in ("left", "right"):
            flow = getattr(line, name)
            part = data[at[name] : at[name] + flow.room]
            flow.write(part, line.now)
            at[name] += len(part)
            if at[name] == len(data):
                flow.end(line.now)
        line.turn()
        there, back = there + taken(line.right), back + taken(line.left)
        assert line.now < 200.0
        assert not line.left.failed
        assert not line.right.failed
    assert there == back == data
    if not loss:
        assert line.sent < 6 * len(data) / CHUNK + 20  # nothing is sent twice without need


def test_reader_that_does_not_read_stops_the_sender_at_the_window():
    line = Line()
    while line.left.room:
        line.left.write(bytes(line.left.room), line.now)
        line.turn()
    for _ in range(2000):  # 20 s: a slow browser is no dead one
        line.turn()
    assert not line.left.failed
    line.loss = 1.0
    assert len(taken(line.right)) == WINDOW  # the word of it is lost
    line.turn(0.4)
    line.loss = 0.0
    for _ in range(100):
        line.turn()
    assert line.left.room == WINDOW


def test_room_of_less_than_a_chunk_is_none_so_that_chunks_do_not_become_ever_smaller():
    line = Line()
    line.left.write(bytes(100), line.now)
    while line.left.room:
        line.left.write(bytes(line.left.room), line.now)
    for size, room in ((100, 0), (CHUNK, CHUNK + 100)):
        for _ in range(5):
            line.turn()
        assert len(line.right.take()) == size
        line.right.handed_on(size)
        for _ in range(5):
            line.turn()
        assert line.left.room == room


def test_other_end_that_is_silent_for_too_long_has_failed():
    line = Line(loss=1.0)
    line.left.write(b"data", line.now)
    line.turn(GIVE_UP - 0.5)
    assert not line.left.failed
    line.turn(1.0)
    assert line.left.failed


def test_reset_ends_a_connection():
    line = Line()
    line.left.receive("reset", 0, 0, b"", line.now)
    assert line.left.failed


@pytest.mark.parametrize(
    "message",
    [
        ("ack", 5, 0, b""), ("ack", 0, 1, b""), ("ack", 0, -1, b""), ("data", 0, 0, b""), ("end", 0, 0, b"x"),
        ("data", 0, 0, bytes(CHUNK + 1)), ("hello", 0, 0, b""),
    ],
)  # fmt: skip
def test_messages_that_cannot_be_are_errors(message):
    with pytest.raises(ValueError, match=r"than were sent|a chunk of data|no kind"):
        Line().left.receive(*message, 100.0)


def test_more_bytes_than_there_is_room_for_are_an_error():
    line = Line()
    for place in range(0, WINDOW, CHUNK):
        line.left.receive("data", place, 0, bytes(CHUNK), line.now)
    with pytest.raises(ValueError, match="room"):
        line.left.receive("data", WINDOW, 0, b"x", line.now)
