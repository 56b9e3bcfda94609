"""Tests of hostile and malformed OSC and of unlisted senders: counted, and the input continues."""

import struct
import time

from pythonosc.osc_bundle_builder import OscBundleBuilder

from live.control.events import events
from live.control.registry.registry import REGISTRY, Registry
from live.control.registry.rejections import Reason
from tests.control.osc.osc_stage import PING, STAMP, TAP, Stage, message, wait_until


def crashing_packets():
    future = OscBundleBuilder(time.time() + 3600.0)
    future.add_content(message("/dance/clock/one"))
    negative = b"#bundle\0" + struct.pack(">Q", 1) + struct.pack(">i", -4) + bytes(16)
    return future.build().dgram, negative


def test_packets_that_crash_other_receivers_are_handled(stage):
    future, negative = crashing_packets()
    stage.send(future, negative, *[TAP] * 20)
    assert stage.events() == [events.One(**STAMP)] + [events.Tap(**STAMP)] * 20
    assert stage.osc.rejected.as_dict() == {"bundle element size": 1}
    assert stage.osc.handler.future_timetags == 1


HOSTILE = [
    b"",
    b"\0",
    b"\xff" * 36,
    bytes(range(256)),
    b"x" * 20_000,
    b"/" + b"\0" * 60_000,
    b"/dance/attract\0\0,ff\0" + struct.pack(">ff", float("nan"), 0.0),
    b"/dance/attract\0\0,ff\0" + struct.pack(">ff", 0.0, float("inf")),
    message("/dance/attract", 1e30, 0.0).dgram,
    b"/dance/attract\0\0,ff\0" + struct.pack(">f", 1.0) + b"\0\0",
    b"/dance/attract\0\0,ff\0" + struct.pack(">f", 1.0),
    b"/dance/attract\0\0," + b"T" * 60_000 + b"\0\0\0",
    message("/dance/[", 1.0).dgram,
    message("/nowhere").dgram,
    message("/dance/step", "x" * 65).dgram,
    message("/dance/clear", 7.0).dgram,
    message("/dance/blackout", 7).dgram,
]


def test_hostile_datagrams_are_counted_by_reason(stage):
    stage.send(*HOSTILE)
    assert stage.events() == []
    assert stage.osc.received == len(HOSTILE) == stage.osc.rejected.total
    assert stage.osc.rejected.as_dict() == {
        "packet empty or too large": 4,
        "length not a multiple of 4": 2,
        "malformed address": 2,
        "value cut off": 1,
        "not a finite number": 2,
        "unknown address": 1,
        "extra argument": 1,
        "out of range": 2,
        "unusable name": 1,
        "unusable pattern": 1,
    }
    assert stage.osc.last_rejection.reason == Reason.OUT_OF_RANGE
    stage.send(TAP)
    assert stage.events() == [events.Tap(**STAMP)]


def test_bad_value_in_bundle_rejects_only_its_message(stage):
    bundle = OscBundleBuilder(0)
    for content in (message("/dance/spread"), message("/dance/attract", 1e30, 0.0), message("/dance/clear")):
        bundle.add_content(content)
    stage.send(bundle.build().dgram)
    assert stage.events() == [events.PlaceElement(kind="spread", **STAMP), events.Clear(**STAMP)]
    assert (stage.osc.handler.accepted, stage.osc.rejected.as_dict()) == (2, {"out of range": 1})


def test_every_datagram_of_a_flood_is_counted(stage):
    good, bad = message("/dance/attract", 1.0, 2.0).dgram, b"\xff" * 40
    for index in range(20_000):
        stage.sender.sendto(bad if index % 4 == 3 else good, ("127.0.0.1", stage.osc.port))
    wait_until(lambda: stage.osc.received + stage.osc.lost >= 20_000)
    osc = stage.osc
    assert osc.received + osc.lost == 20_000
    assert osc.handler.accepted + osc.rejected.total == osc.received
    assert len(stage.events()) + stage.inbox.dropped == osc.handler.accepted
    assert osc.rejected.total <= 5_000
    assert osc.handler.accepted <= 15_000
    stage.sent = 20_000
    stage.send(TAP)
    assert stage.events() == [events.Tap(**STAMP)]


def test_only_listed_senders_are_accepted():
    with Stage(allow=["192.0.2.0/24", "2001:db8::1"]) as closed, Stage(allow=["127.0.0.1/8"]) as open_stage:
        closed.send(TAP, PING)
        open_stage.send(TAP)
        assert closed.events() == []
        assert closed.osc.rejected.as_dict() == {"sender not allowed": 2}
        assert len(open_stage.events()) == 1


def test_internal_error_is_counted_and_next_datagram_accepted():
    class Broken(Registry):
        def resolve(self, address):
            if address == "/break":
                raise ZeroDivisionError
            return super().resolve(address)

    with Stage(registry=Broken(tuple(REGISTRY))) as stage:
        stage.send(message("/break").dgram, TAP)
        assert stage.events() == [events.Tap(**STAMP)]
        assert stage.osc.rejected.as_dict() == {"internal error": 1}


def test_prefilter_error_loses_only_its_batch(stage, monkeypatch):
    """Without the guard, the error would end the receiving thread and all further input."""
    taken, failed = stage.osc._prefilter.process, []

    def take(*found, **how):
        if found[0] and not failed:
            failed.append(True)
            raise ZeroDivisionError("a fault of this program")
        return taken(*found, **how)

    monkeypatch.setattr(stage.osc._prefilter, "process", take)
    stage.sender.sendto(TAP, ("127.0.0.1", stage.osc.port))
    wait_until(lambda: failed)
    stage.send(PING)
    wait_until(lambda: stage.osc.handler.accepted == 1)
    assert stage.osc.rejected.as_dict() == {"internal error": 1}
    assert stage.sender.recv(100).startswith(b"/dance/pong")
