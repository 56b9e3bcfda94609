"""Tests of OSC input: timed events in order, answers to pings, and counted losses."""

import socket
import struct
import sys
import threading
import time

import pytest
from pythonosc.osc_bundle_builder import OscBundleBuilder
from pythonosc.osc_message import OscMessage
from pythonosc.udp_client import SimpleUDPClient

from live.clock.time_source import ManualClock
from live.control.events import events
from tests.control.osc.osc_stage import DEADLINE_S, PING, STAMP, TAP, Stage, message, wait_until


def test_controls_become_timed_events_in_order(stage):
    stage.send(message("/dance/attract", 1.5, -2.0).dgram, message("/dance/step", "samba", 8).dgram, TAP)
    assert stage.events() == [
        events.PlaceElement(kind="attract", points=((1.5, -2.0),), **STAMP),
        events.CallStep(name="samba", measures=8.0, **STAMP),
        events.Tap(**STAMP),
    ]
    assert (stage.osc.received, stage.osc.handler.accepted, stage.osc.rejected.total) == (3, 3, 0)


def test_each_event_has_its_arrival_time(stage):
    stage.send(TAP)
    stage.clock.set(9.5)
    stage.send(TAP)
    assert [event.time for event in stage.events()] == [7.25, 9.5]


def test_messages_from_python_osc_become_events(stage):
    client = SimpleUDPClient("127.0.0.1", stage.osc.port)
    client.send_message("/dance/blackout", True)
    client.send_message("/dance/clock/tempo", 96)
    wait_until(lambda: stage.osc.received == 2)
    client._sock.close()
    assert stage.events() == [events.Blackout(on=True, **STAMP), events.SetTempo(tempo=96.0, **STAMP)]


def test_past_time_tags_are_not_counted_as_future(stage):
    for tag in (1, int((time.time() - 5.0 + 2_208_988_800) * 2**32)):
        stage.send(b"#bundle\0" + struct.pack(">Qi", tag, len(TAP)) + TAP)
    assert stage.osc.handler.future_timetags == 0
    assert len(stage.events()) == 2


def test_time_tag_of_next_ntp_era_is_future(stage):
    after_2036 = 5 << 32  # the seconds begin again at 0 on 7 February 2036
    stage.send(b"#bundle\0" + struct.pack(">Qi", after_2036, len(TAP)) + TAP)
    assert stage.osc.handler.future_timetags == 1
    assert stage.events() == [events.Tap(**STAMP)]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux counts the datagrams that a socket dropped")
def test_dropped_datagram_count_remains_after_stop():
    class Slow(ManualClock):
        def now(self):
            gate.wait(DEADLINE_S)
            return super().now()

    gate = threading.Event()
    with Stage() as stage:
        stage.osc._clock = Slow()
        stage.osc._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        for _ in range(200):  # the thread stands at the gate, so that the small buffer must overflow
            stage.sender.sendto(TAP, ("127.0.0.1", stage.osc.port))
        gate.set()
        wait_until(lambda: stage.osc.received + stage.osc.lost >= 200)
        lost = stage.osc.lost
    assert stage.osc.lost == lost == 200 - stage.osc.received > 0


def test_full_queue_drops_and_counts_oldest_events():
    with Stage(capacity=10) as stage:
        stage.send(*[message("/dance/attract", float(x), 0.0).dgram for x in range(25)])
        assert [event.points[0][0] for event in stage.events()] == list(range(15, 25))
        assert stage.inbox.dropped == 15
        assert stage.osc.handler.accepted == 25


def test_ping_answer_is_not_larger_than_ping(stage):
    stage.send(PING)
    answer, sender = stage.sender.recvfrom(2048)
    assert OscMessage(answer).address == "/dance/pong"
    assert len(answer) <= len(PING)
    assert sender[1] == stage.osc.port
    assert stage.events() == []


def test_datagram_of_many_pings_gets_one_answer(stage):
    bundle = OscBundleBuilder(0)
    for _ in range(60):
        bundle.add_content(message("/dance/ping"))
    stage.send(bundle.build().dgram)
    stage.sender.recvfrom(2048)
    stage.sender.setblocking(False)
    with pytest.raises(BlockingIOError):  # the answer to the whole datagram was sent before it was counted
        stage.sender.recvfrom(2048)
    assert stage.osc.handler.accepted == 60
