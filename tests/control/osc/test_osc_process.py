"""Tests of the OSC process: events forwarded to the show, flow control, and restart after a kill."""

import socket
import threading

from live.base.event_queue import EventQueue
from live.base.processing_budget import BURST, FLOODED_PER_SECOND, PER_SECOND
from live.clock.time_source import SystemClock
from live.control.events import events
from live.control.message_codec import decode_packet
from live.control.osc.osc_process import (
    CONFIRM_TIMEOUT,
    MAX_EVENTS,
    MAX_UNCONFIRMED,
    PACKET_INTERVAL,
    EventForwarder,
    OscRemote,
)
from tests.control.osc.osc_stage import message
from tests.control.waiting import wait_for


class ForwarderDriver:
    def __init__(self):
        self.time, self.packets, self.full, self.inbox = 0.0, [], False, EventQueue()
        self.lane = self.inbox.add_queue()
        self.forward = EventForwarder(self.send, self.inbox, lambda: self.time)

    def send(self, packet):
        if self.full:
            raise BlockingIOError
        self.packets.append([event for _, event in decode_packet(packet)])

    def flood(self, seconds, *, takes=True, every=20):
        """Queues sixty values every `every` milliseconds; returns the events that were sent."""
        before = len(self.packets)
        for step in range(round(seconds * 1000)):
            self.time += 0.001
            for number in range(60 if step % every == 0 else 0):
                self.lane.put(events.Tap(time=self.time, source=str(number)), number)
            self.forward.send_due()
            if takes:
                self.forward.confirmed = len(self.packets)
        return [event for packet in self.packets[before:] for event in packet]


def test_event_rate_is_limited_and_events_are_recent():
    sent = ForwarderDriver()
    told = sent.flood(4.0)
    assert len(told) <= BURST + PER_SECOND * 4.0 + MAX_EVENTS
    assert len(told) >= PER_SECOND * 3.0
    assert all(len(packet) <= MAX_EVENTS for packet in sent.packets)
    assert len(sent.packets) <= 4.0 / PACKET_INTERVAL + 1
    assert sent.time - told[-1].time < 2 * 60 / PER_SECOND


def test_flood_lowers_rate_and_serves_keys_in_turn():
    sent = ForwarderDriver()
    sent.flood(1.0, every=1)
    told = sent.flood(4.0, every=1)
    assert FLOODED_PER_SECOND * 3.5 <= len(told) <= FLOODED_PER_SECOND * 4.5
    counts = [sum(event.source == str(number) for event in told) for number in range(60)]
    assert max(counts) - min(counts) <= 1
    sent.flood(1.0)
    assert len(sent.flood(2.0)) >= PER_SECOND * 1.5  # it is over


def test_quiet_lane_is_in_next_packet_despite_floods():
    sent = ForwarderDriver()
    lanes, quiet = [sent.inbox.add_queue() for _ in range(40)], sent.inbox.add_queue()
    late = {}
    for step in range(4000):
        sent.time += 0.001
        for number, lane in enumerate(lanes):
            lane.put(events.Tap(time=sent.time, source=str(number)), number)
        if step % 500 == 7:
            quiet.put(events.One(time=sent.time, source="operator"))
        sent.forward.send_due()
        sent.forward.confirmed = len(sent.packets)
        for event in sent.packets[-1] if sent.packets else []:
            if isinstance(event, events.One):
                late.setdefault(event.time, sent.time - event.time)
    assert len(late) == 8
    assert max(late.values()) <= PACKET_INTERVAL + 0.0015


def test_delayed_lane_catches_up_during_flood():
    """After a stall of one second, the operator's waiting events are forwarded within half a second."""
    sent = ForwarderDriver()
    sent.flood(1.0, every=1)
    operator = sent.inbox.add_queue()
    for number in range(50):
        operator.put(events.One(time=sent.time, source=str(number)))
    told = sent.flood(0.5, every=1)
    assert sum(isinstance(event, events.One) for event in told) == 50
    assert sum(isinstance(event, events.Tap) for event in told) >= 5  # and the other one, too


def test_unconfirmed_packets_pause_sending_until_confirmed():
    sent = ForwarderDriver()
    sent.flood(0.9 * CONFIRM_TIMEOUT, takes=False)
    assert len(sent.packets) == MAX_UNCONFIRMED
    sent.full = True
    sent.flood(2.0)
    sent.full = False
    assert sent.inbox.dropped == 0
    assert sent.flood(0.5)[-1].time > sent.time - 1.0


def test_single_event_is_sent_immediately():
    sent = ForwarderDriver()
    assert sent.forward.send_due() is None
    sent.time = 5.0
    sent.lane.put(events.Tap(time=5.0, source="osc"))
    assert sent.forward.send_due() is None
    assert [[event.time for event in packet] for packet in sent.packets] == [[5.0]]


def test_show_continues_after_osc_process_is_killed():
    inbox = EventQueue()
    remote = OscRemote("127.0.0.1", 0, inbox.add_queue(), SystemClock())
    remote.publish({"/dance/clock/tempo": (("", (96.0,)),)})
    remote.start()
    pause = threading.Event()

    def turn():
        remote.frame()
        pause.wait(0.005)

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.setblocking(False)

        def send(address, *values):
            sock.sendto(message(address, *values).dgram, ("127.0.0.1", remote.port))

        def answered():
            turn()
            send("/dance/clock/tempo")
            try:
                return b"/dance/clock/tempo" in sock.recv(2000)
            except BlockingIOError:
                return False

        try:
            send("/dance/clock/tap")
            assert wait_for(lambda: turn() or len(inbox) == 1, 20.0)
            assert isinstance(inbox.drain()[0], events.Tap)
            assert wait_for(answered, 10.0)
            send("/dance/clock/tempo", "x")
            assert wait_for(lambda: turn() or "wrong type" in remote.refused(), 10.0)
            assert "write the number" in remote.refusal() or "text" in remote.refusal()
            remote._helper._process.kill()
            remote._helper._process.wait()
            remote._helper._started_at -= 10.0
            send("/dance/clock/one")  # nobody is there: it waits in the socket
            assert wait_for(lambda: turn() or any(isinstance(e, events.One) for e in inbox.drain()), 20.0)
            assert remote.status()["restarts"] == 1
            assert wait_for(answered, 10.0)
        finally:
            remote.stop()
    assert remote.lost == 0
