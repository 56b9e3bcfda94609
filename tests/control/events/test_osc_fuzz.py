"""Mutation fuzzing of the whole way in: datagram, door, registry. Whatever comes, nothing is raised, everything is
counted, what reaches the show is finite, and nothing is kept."""

import tracemalloc

import numpy as np
import pytest

from live.base.event_queue import EventQueue
from live.control.events.event_json import is_finite
from live.control.events.events import ControlEvent
from live.control.osc.osc_codec import encode
from live.control.osc.osc_handler import OscHandler
from live.control.registry.registry import REGISTRY

ROUNDS = 6
FROM = ("127.0.0.1", 9999)


def good_packets(chance):
    """One message for each control, with values that it takes."""
    for control in REGISTRY:
        values = []
        for argument in control.arguments:
            if argument.type == "float":
                values.append(float(chance.uniform(argument.minimum, argument.maximum)))
            elif argument.type == "bool":
                values.append(int(chance.integers(2)))
            else:
                values.append("1 2" if argument.name == "points" else "name")
        yield encode(control.address, tuple(values[: int(chance.integers(0, len(values) + 1))] if values else ()))


def mutated(packet, chance):
    """A packet with a few bytes changed, doubled, cut out or put into a bundle."""
    data = bytearray(packet)
    for _ in range(int(chance.integers(1, 5))):
        at = int(chance.integers(len(data) or 1))
        match int(chance.integers(6)):
            case 0 if data:
                data[at] ^= 1 << int(chance.integers(8))
            case 1 if data:
                data[at] = int(chance.choice([0, 0x2C, 0x2F, 0x2A, 0x7F, 0x80, 0xFF]))
            case 2:
                data[at:at] = chance.bytes(int(chance.integers(1, 9)))
            case 3:
                del data[at : at + int(chance.integers(1, 9))]
            case 4:
                data[at:at] = data[max(at - 12, 0) : at]
            case _:
                size = len(data) if chance.random() < 0.7 else int(chance.integers(2**31))
                tag = chance.bytes(8) if chance.random() < 0.5 else bytes(7) + b"\1"
                data = bytearray(b"#bundle\0" + tag + size.to_bytes(4, "big")) + data
    return bytes(data[:9000])


@pytest.fixture
def way():
    inbox = EventQueue()
    return inbox, OscHandler(inbox.add_queue(), wall_clock=lambda: 1_800_000_000.0)


def drive(inbox, door, packets):
    """Send them; what reached the show."""
    reached = []
    for number, packet in enumerate(packets):
        before = door.accepted + door.rejected.total + len(door.schedule)
        answers = list(door.handle(memoryview(packet), FROM, number * 1e-3))
        assert all(len(answer) % 4 == 0 for answer in answers)
        door.handle_due(number * 1e-3)
        assert door.accepted + door.rejected.total + len(door.schedule) >= before
        reached += inbox.drain()
    return reached


@pytest.mark.parametrize("seed", [1, 2])
def test_whatever_comes_is_taken_or_counted_and_what_is_taken_is_finite(way, seed):
    inbox, door = way
    chance = np.random.default_rng(seed)
    good = list(good_packets(chance))
    bad = [mutated(packet, chance) for _ in range(ROUNDS) for packet in good]
    events = drive(inbox, door, bad)
    assert door.rejected.total > len(bad) // 4, "most mutations are refused"
    assert len(events) > 20, "and some are taken, so that values are looked at, too"
    for event in events:
        assert isinstance(event, ControlEvent)
        assert is_finite(event)
    drive(inbox, door, good)
    assert door.accepted > len(good) // 2, "it still hears what is right"


def test_no_memory_is_kept_of_what_was_refused(way):
    inbox, door = way
    chance = np.random.default_rng(3)
    bad = [mutated(packet, chance) for packet in good_packets(chance)]
    drive(inbox, door, bad * 2)
    tracemalloc.start()
    try:
        drive(inbox, door, bad)
        first = tracemalloc.get_traced_memory()[0]
        for _ in range(4):
            drive(inbox, door, [mutated(packet, chance) for packet in bad])
        grown = tracemalloc.get_traced_memory()[0] - first
    finally:
        tracemalloc.stop()
    assert grown < 200_000
