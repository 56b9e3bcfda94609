"""Tests of datagram batches: read with one call, plain values replaced by later ones, invalid senders limited."""

import socket
import struct

import pytest

from live.control.events import events
from live.control.osc.osc_prefilter import FLOOD_WINDOW, MAX_INVALID_SURPLUS, OscPrefilter
from live.control.osc.udp_batch import BATCH_SIZE, DatagramReader
from live.control.registry.registry import REGISTRY
from live.control.registry.rejections import Reason, Tally
from tests.control.osc.osc_stage import STAMP, TAP, message, wait_until

ME, YOU = ("127.0.0.1", 1), ("127.0.0.1", 2)


def light(value):
    return message("/dance/light/key", value).dgram


class PrefilterRecorder:
    def __init__(self):
        self.on, self.tally = [], Tally()
        self.sieve = OscPrefilter(REGISTRY, self.take, self.tally)

    def take(self, data, sender):
        self.on.append((data, sender))
        return not data.startswith(b"/bad")

    def together(self, *datagrams, now=0.0):
        self.on.clear()
        self.sieve.process([each if isinstance(each, tuple) else (each, ME) for each in datagrams], now)
        return [data for data, _ in self.on]


def test_last_value_of_batch_is_kept_in_order():
    sieved = PrefilterRecorder()
    assert sieved.together(light(0.1), light(0.2), light(0.3)) == [light(0.3)]
    assert sieved.sieve.replaced == 2
    assert sieved.together(light(0.1), TAP, light(0.2), light(0.3), TAP) == [light(0.1), TAP, light(0.3), TAP]
    whole = message("/dance/light/key", 1).dgram  # another type is another header: both go on
    assert sieved.together(light(0.1), whole, light(0.2)) == [light(0.2), whole]
    asks = message("/dance/light/key").dgram
    for other in (asks, message("/dance/motion/larger", 0.1, "ember").dgram, message("/dance/attract", 1.0, 2.0).dgram):
        assert sieved.together(other, other) == [other, other]


def test_non_osc_datagrams_are_counted_without_decoding():
    sieved = PrefilterRecorder()
    assert sieved.together(b"", b"x" * 20_000, b"abc", b"\xff" * 40, TAP) == [TAP]
    assert sieved.tally.as_dict() == {str(Reason.PACKET_SIZE): 2, str(Reason.ALIGNMENT): 1, str(Reason.ADDRESS): 1}
    for odd in (b"/\0\0\0", b"/a,\0", b"/,,,", b"/abc", b"#bundle\0", b"/" + b"a" * 300 + b"\0\0\0,\0\0\0"):
        assert sieved.together(odd) == [odd]


def test_sender_of_only_invalid_datagrams_is_paused():
    sieved = PrefilterRecorder()
    for rubbish in (b"\xff" * 40, b"/bad\0\0\0\0,\0\0\0"):
        now = 10.0 if rubbish[0] == 0xFF else 20.0
        sieved.together(*[rubbish] * (2 * MAX_INVALID_SURPLUS), now=now)
        assert sieved.together((TAP, ME), (TAP, YOU), now=now + 0.1) == [TAP]
        assert sieved.on[0][1] == YOU
        assert sieved.together((TAP, ME), now=now + 2 * FLOOD_WINDOW) == [TAP]
    assert sieved.tally.as_dict()[str(Reason.FLOOD)] == 2 * (MAX_INVALID_SURPLUS + 1)
    for _ in range(MAX_INVALID_SURPLUS):  # a surface of which a button is mapped wrongly is heard all the same
        assert len(sieved.together(b"/bad\0\0\0\0,\0\0\0", TAP, now=30.0)) == 2


@pytest.mark.parametrize(("family", "host"), [(socket.AF_INET, "127.0.0.1"), (socket.AF_INET6, "::1")])
def test_batch_read_matches_recvfrom(family, host):
    with socket.socket(family, socket.SOCK_DGRAM) as into, socket.socket(family, socket.SOCK_DGRAM) as out:
        try:
            into.bind((host, 0))
        except OSError:
            pytest.skip(f"no {host} here")
        into.setblocking(False)
        out.bind((host, 0))
        datagrams = DatagramReader(into, 64)
        assert datagrams.read() == []
        sent = [b"", b"a", b"b" * 64, *[struct.pack(">I", number) for number in range(2 * BATCH_SIZE)]]
        found = []
        for start in range(0, len(sent), 100):  # no more than the smallest buffer takes
            for each in sent[start : start + 100]:
                out.sendto(each, into.getsockname())
            while rows := datagrams.read():
                found += rows
        out.sendto(b"c" * 100, into.getsockname())
        found += datagrams.read()
        assert [data for data, _ in found] == [*sent, b"c" * 65]
        assert {sender for _, sender in found} == {out.getsockname()}
        out.sendto(b"x", into.getsockname())
        assert datagrams.read() == [(b"x", out.getsockname())]


def test_value_flood_ends_with_last_value(stage):
    stage.send(*[light(number / 1000) for number in range(1000)])
    found = []
    wait_until(lambda: found.extend(stage.events()) or found[-1].value[0] > 0.998)
    assert found[-1] == events.SetParameter(address="/dance/light/key", value=(pytest.approx(0.999),), **STAMP)
    facts = stage.osc.status()
    assert stage.osc.handler.accepted + facts["replaced"] >= 1000
