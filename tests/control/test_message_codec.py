"""Tests of packets between the project's processes: round trip, and no calls from forged bytes."""

import pickle
import time

import numpy as np
import pytest

from live.control.audience.session_state import BeatClock, Rules
from live.control.events import events
from live.control.events.event_json import register_events
from live.control.message_codec import PacketError, decode_packet, encode_packet

register_events()

RULES = Rules(
    order=3, half=(5.0, 3.0), regions=("left", "right"), weights=(1.0, 0.5), banned=(4, 9), turn=(1, 8.0, 16.0),
    vote=(2, "scene", ("low", "high"), 32.0), won=(1, "low"),
)  # fmt: skip


@pytest.mark.parametrize(
    "value",
    [
        {"udp": 7, "nice": 0, "origin": 12.5, "targets": (("127.0.0.1", 9000),), "secret": b"s" * 32},
        ("positions", b"\x00\x01" * 40),
        (
            (("/dance/attract", 1), events.PlaceElement(time=1.5, source="osc", kind="attract", points=((1.0, 0.0),))),
            (None, events.Tap(time=1.0, source="key")),
        ),
        RULES,
        BeatClock(1.0, 2.0, 90.0, 3, 1.5),
        7,
        {"/dance/a": (("", (1.0, 2)), ("ember", (True, "x")))},
    ],
)
def test_packets_round_trip_unchanged(value):
    assert decode_packet(encode_packet(value)) == value


def test_numpy_scalars_become_plain_numbers():
    assert decode_packet(encode_packet({"a": np.float32(0.5), "b": np.int64(3), "c": np.bool_(True)})) == {
        "a": 0.5,
        "b": 3,
        "c": True,
    }


def test_unregistered_types_are_refused():
    with pytest.raises(PacketError, match="complex"):
        encode_packet({"a": 1j})
    with pytest.raises(PacketError, match="object"):
        encode_packet(object())


def _pack_named(name, *values):
    import msgpack

    return msgpack.packb(msgpack.ExtType(1, msgpack.packb([name, *values])))


ran = []


class PickledCall:
    def __reduce__(self):
        return ran.append, ("called",)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xc1",
        pickle.dumps(PickledCall()),
        b"\xdd\xff\xff\xff\xff",
        b"\x91" * 2000,
        _pack_named("os.system", "true"),
        _pack_named("PlaceElement", 1.0, 2.0),
        _pack_named("Tap", "now", "key"),
        _pack_named("Tap", float("nan"), "key"),
        _pack_named("Tap", 1.0, "key", 1, 2, 3, 4, 5),
        _pack_named("rules", "many"),
        _pack_named("beat", 1.0),
        _pack_named(["rules"]),
        _pack_named("rules", *[0] * 40),
        b"\xc7\x01\x07\x00",
    ],
)
def test_forged_bytes_are_refused_without_calls(data):
    with pytest.raises(PacketError):
        decode_packet(data)
    assert ran == []


def test_damaged_packets_cause_no_calls():
    chance = np.random.default_rng(4)
    whole = encode_packet(
        (
            ("a", events.PlaceElement(time=1.5, source="osc", kind="attract", points=((1.0, 0.0),))),
            RULES,
            {"a": (1.0, "b")},
        )
    )
    for _ in range(5000):
        data = bytearray(whole)
        for place in chance.integers(len(data), size=int(chance.integers(1, 5))):
            data[place] = chance.integers(256)
        try:
            decode_packet(bytes(data))
        except PacketError:
            continue
    assert ran == []


def test_event_packet_takes_under_six_times_pickle():
    """Both are timed in one run; a packet has 32 events, with at most two packets per tick."""
    many = [
        ((f"/dance/{n}", n), events.PlaceElement(time=1.5 + n, source="osc", kind="attract", points=((0.1 * n, 1.0),)))
        for n in range(32)
    ]

    def fastest(write, read):
        spent = []
        for _ in range(30):
            begin = time.perf_counter()
            read(write(many))
            spent.append(time.perf_counter() - begin)
        return min(spent)

    assert fastest(encode_packet, decode_packet) < 6.0 * fastest(pickle.dumps, pickle.loads)
