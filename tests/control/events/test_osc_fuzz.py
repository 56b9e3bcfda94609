"""Mutation fuzzing from datagram through handler to registry: no exceptions, finite events, counted refusals, no
memory growth.
"""

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
    """One message for each control, with valid values."""
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


def mutate(packet, chance):
    """A packet with some bytes changed, duplicated, removed or put into a bundle."""
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
    return bytes(data[:18_000])


@pytest.fixture
def handler_setup():
    inbox = EventQueue()
    return inbox, OscHandler(inbox.add_queue(), wall_clock=lambda: 1_800_000_000.0)


def send_packets(inbox, door, packets):
    """Sends packets; returns the events that reach the show."""
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
def test_packets_are_accepted_or_counted_and_events_are_finite(handler_setup, seed):
    inbox, door = handler_setup
    chance = np.random.default_rng(seed)
    good = list(good_packets(chance))
    bad = [mutate(packet, chance) for _ in range(ROUNDS) for packet in good]
    events = send_packets(inbox, door, bad)
    assert door.rejected.total > len(bad) // 4, "most mutations are refused"
    assert len(events) > 20, "and some are taken, so that values are looked at, too"
    for event in events:
        assert isinstance(event, ControlEvent)
        assert is_finite(event)
    send_packets(inbox, door, good)
    assert door.accepted > len(good) // 2, "it still hears what is right"


def test_refused_packets_leave_no_memory(handler_setup):
    inbox, door = handler_setup
    chance = np.random.default_rng(3)
    bad = [mutate(packet, chance) for packet in good_packets(chance)]
    send_packets(inbox, door, bad * 2)
    tracemalloc.start()
    try:
        send_packets(inbox, door, bad)
        first = tracemalloc.get_traced_memory()[0]
        for _ in range(4):
            send_packets(inbox, door, [mutate(packet, chance) for packet in bad])
        grown = tracemalloc.get_traced_memory()[0] - first
    finally:
        tracemalloc.stop()
    assert grown < 200_000
