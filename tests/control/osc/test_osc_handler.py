"""Tests of OSC queries: current values, subscriptions, scheduled values and address patterns."""

import struct
import time

import pytest
from pythonosc.osc_bundle_builder import OscBundleBuilder
from pythonosc.osc_packet import OscPacket

from live.base.event_queue import EventQueue, PriorityQueue
from live.control.events import events
from live.control.osc.osc_handler import (
    LANE_TIMEOUT,
    MAX_ANSWERS,
    MAX_LANES,
    MAX_LANES_PER_HOST,
    PATTERNS_PER_SECOND,
    OscHandler,
)
from live.control.osc.osc_scheduler import MAX_DELAY, MAX_ITEMS, TimedQueue
from live.control.osc.osc_subscriptions import ECHO_DELAY, UPDATE_INTERVAL, Subscribers
from live.control.osc.osc_subscriptions import MAX_SUBSCRIBERS as MOST_SUBSCRIBERS
from live.control.registry.registry import READABLE, REGISTRY, Values
from tests.control.osc.osc_stage import STAMP, message, wait_until

ME, YOU, FAR = ("127.0.0.1", 5000), ("192.168.1.7", 6000), ("8.8.8.8", 7000)
LIGHT, HAZE, LARGER = "/dance/light/key", "/dance/light/haze", "/dance/motion/larger"


def decode_messages(datagrams):
    """The messages in datagrams, as decoded by python-osc."""
    return [(m.message.address, *m.message.params) for d in datagrams for m in OscPacket(d).messages]


def near(rows):
    return [tuple(pytest.approx(value, abs=1e-6) if type(value) is float else value for value in row) for row in rows]


class HandlerStage:
    """An OscHandler without a socket."""

    def __init__(self, **options):
        self.lane = PriorityQueue()
        self.door = OscHandler(self.lane, **options)
        self.door.values.update({LIGHT: (("", (1.5,)),), HAZE: (("", (0.25,)),), "/dance/hold": (("", (False,)),)})
        self.door.values.update({LARGER: (("ember", (0.25,)), ("tide", (-0.5,)))})
        self.door.values.update({"/dance/status/measure": (("", (3,)),)})

    def ask(self, address, *values, of=ME, at=0.0):
        return decode_messages(self.door.handle(memoryview(message(address, *values).dgram), of, at))

    def events(self):
        found = []
        while (event := self.lane.pop()) is not None:
            found.append(event)
        return found

    def turn(self, now):
        sent = []
        self.door.subscribers.send_due(now, lambda datagram, where: sent.append((where, datagram)))
        return {where: decode_messages([d for to, d in sent if to == where]) for where, _ in sent}

    @property
    def reasons(self):
        return self.door.rejected.as_dict()


def test_message_without_values_is_a_query():
    handler_stage = HandlerStage()
    assert handler_stage.ask(LIGHT) == [(LIGHT, 1.5)]
    assert handler_stage.ask("/dance/hold") == [("/dance/hold", False)]
    assert handler_stage.ask("/dance/status/measure") == [("/dance/status/measure", 3)]
    assert handler_stage.ask(LARGER) == [(LARGER, 0.25, "ember"), (LARGER, -0.5, "tide")]
    assert handler_stage.ask(LIGHT, None) == [(LIGHT, 1.5)]
    assert handler_stage.events() == []
    assert handler_stage.reasons == {}


def test_get_answers_patterns_and_reports_missing_values():
    handler_stage = HandlerStage()
    assert handler_stage.ask("/dance/get", LIGHT) == [(LIGHT, 1.5)]
    assert handler_stage.ask("/dance/get", "/dance/light/{key,haze}") == near([(LIGHT, 1.5), (HAZE, 0.25)])
    assert handler_stage.ask("/dance/get", "/dance/attract") == [("/dance/no_value", "/dance/attract")]
    assert handler_stage.ask("/dance/get", "/dance/clock/hold") == [("/dance/no_value", "/dance/clock/hold")]
    assert handler_stage.ask("/dance/get", "/nothing") == []
    assert handler_stage.ask("/dance/get", "/dance/[") == []
    assert handler_stage.reasons == {"unknown address": 1, "unusable pattern": 1}


def test_command_without_arguments_is_still_executed():
    handler_stage = HandlerStage()
    assert handler_stage.ask("/dance/clock/hold") == []
    assert [type(event) for event in handler_stage.events()] == [events.HoldTempo]


def test_remote_sender_gets_no_amplified_answers():
    handler_stage = HandlerStage()
    assert handler_stage.ask(LIGHT, of=FAR) == []
    assert handler_stage.ask("/dance/ping", of=FAR) == [("/dance/pong",)]
    handler_stage.ask("/dance/subscribe", of=FAR)
    assert handler_stage.reasons == {"sender not allowed": 1}
    assert handler_stage.turn(1.0) == {}
    everything = dict.fromkeys(READABLE, (("", (1.0,)),))
    handler_stage.door.values.update(everything)
    assert len(handler_stage.ask("/dance/get", "/dance/*/*")) == MAX_ANSWERS


def test_pattern_sets_values_but_triggers_no_commands():
    handler_stage = HandlerStage()
    handler_stage.ask("/dance/light/{key,rim}", 0.5)
    found = handler_stage.events()
    assert [(event.address, event.value) for event in found] == [
        ("/dance/light/key", (0.5,)),
        ("/dance/light/rim", (0.5,)),
    ]
    assert handler_stage.ask("/dance/*") == [("/dance/hold", False)]
    handler_stage.ask("/dance/p*c")
    assert handler_stage.events() == []
    assert handler_stage.reasons == {"unknown address": 1}
    handler_stage.ask("/dance/light/*", 0.25)  # colours take three numbers: they are not meant
    numbers = [c for c in REGISTRY if c.address.startswith("/dance/light/") and c.address.count("/") == 3]
    assert len(handler_stage.events()) == sum(c.value == 1 for c in numbers)


def test_new_pattern_lookups_are_rate_limited():
    handler_stage = HandlerStage()
    for number in range(3 * PATTERNS_PER_SECOND):
        handler_stage.ask(f"/dance/light/k*{number}", 1.0)
    assert handler_stage.reasons == {
        "unknown address": PATTERNS_PER_SECOND,
        "unusable pattern": 2 * PATTERNS_PER_SECOND,
    }
    for _ in range(5):
        handler_stage.ask("/dance/light/k*0", 1.0)  # remembered
    assert handler_stage.reasons["unusable pattern"] == 2 * PATTERNS_PER_SECOND
    handler_stage.ask("/dance/light/k*", 1.0, at=1.0)
    assert len(handler_stage.events()) == 1


def test_subscriber_gets_current_values_then_changes():
    handler_stage = HandlerStage()
    assert handler_stage.ask("/dance/subscribe", "/dance/light", 10.0) == []
    assert handler_stage.turn(0.0) == {ME: near([(LIGHT, 1.5), (HAZE, 0.25)])}
    for at, value in ((1.0, 0.5), (1.01, 0.75), (1.02, 0.75)):
        handler_stage.door.values.update({LIGHT: (("", (value,)),)})
        handler_stage.door.subscribers.mark_changed([LIGHT, LARGER], at)
    assert handler_stage.turn(1.02) == {ME: [(LIGHT, 0.75)]}
    handler_stage.door.subscribers.mark_changed([LIGHT], 1.1)
    assert handler_stage.turn(1.2) == {}
    handler_stage.door.values.update({LIGHT: (("", (0.5,)),)})
    handler_stage.door.subscribers.mark_changed([LIGHT], 11.0)
    assert handler_stage.turn(11.0) == {}  # ten seconds are over
    assert handler_stage.door.subscribers.active == 0


def test_overlapping_subscriptions_send_each_value_once():
    handler_stage = HandlerStage()
    handler_stage.ask("/dance/subscribe", LIGHT, 10.0)
    handler_stage.ask("/dance/subscribe", "/dance/light/", 20.0)
    handler_stage.ask("/dance/subscribe", "/dance/status", 10.0)
    assert handler_stage.turn(0.0) == {ME: near([(LIGHT, 1.5), (HAZE, 0.25), ("/dance/status/measure", 3)])}
    handler_stage.door.subscribers.send_due(15.0, lambda *_: None)
    handler_stage.door.values.update({HAZE: (("", (0.5,)),), "/dance/status/measure": (("", (4,)),)})
    handler_stage.door.subscribers.mark_changed([HAZE, "/dance/status/measure"], 15.0)
    assert handler_stage.turn(15.1) == {ME: [(HAZE, 0.5)]}


def test_subscription_updates_are_rate_limited():
    handler_stage = HandlerStage()
    handler_stage.ask("/dance/subscribe", LIGHT)
    sent = 0
    for tick in range(1000):
        handler_stage.door.values.update({LIGHT: (("", (tick / 1000,)),)})
        handler_stage.door.subscribers.mark_changed([LIGHT], tick / 1000)
        sent += len(handler_stage.turn(tick / 1000))
    assert 0.9 / UPDATE_INTERVAL < sent <= 1.0 / UPDATE_INTERVAL + 1


def test_value_is_sent_to_subscribers_except_its_sender():
    handler_stage = HandlerStage()
    for who in (ME, YOU):
        handler_stage.ask("/dance/subscribe", "/dance/light", of=who)
    handler_stage.turn(0.0)
    handler_stage.ask(LIGHT, 0.5, at=1.0)
    for at, value in ((1.05, 1.0), (1.1, 0.5)):  # softly
        handler_stage.door.values.update({LIGHT: (("", (value,)),)})
        handler_stage.door.subscribers.mark_changed([LIGHT], at)
        assert handler_stage.turn(at) == {YOU: [(LIGHT, value)]}
    assert handler_stage.turn(1.0 + 2.0 * ECHO_DELAY) == {}
    handler_stage.door.values.update({LIGHT: (("", (0.25,)),)})  # somebody else, then back to what I said
    handler_stage.door.subscribers.mark_changed([LIGHT], 4.0)
    assert handler_stage.turn(4.0) == {ME: [(LIGHT, 0.25)], YOU: [(LIGHT, 0.25)]}
    handler_stage.door.values.update({LIGHT: (("", (0.5,)),)})
    handler_stage.door.subscribers.mark_changed([LIGHT], 5.0)
    assert handler_stage.turn(5.0) == {ME: [(LIGHT, 0.5)], YOU: [(LIGHT, 0.5)]}


def test_sender_of_unapplied_value_gets_actual_value():
    handler_stage = HandlerStage()
    handler_stage.ask("/dance/subscribe", LIGHT)
    handler_stage.turn(0.0)
    handler_stage.ask(LIGHT, 0.5, at=1.0)
    assert handler_stage.turn(1.0 + ECHO_DELAY / 2) == {}
    assert handler_stage.turn(1.0 + ECHO_DELAY) == {ME: [(LIGHT, 1.5)]}


def test_subscriber_can_use_another_port_and_unsubscribe():
    handler_stage = HandlerStage()
    handler_stage.ask("/dance/subscribe", LIGHT, 60.0, 9001)
    assert set(handler_stage.turn(0.0)) == {(ME[0], 9001)}
    handler_stage.ask(LIGHT, 0.5, at=1.0)
    handler_stage.door.values.update({LIGHT: (("", (0.5,)),)})
    handler_stage.door.subscribers.mark_changed([LIGHT], 1.1)
    assert handler_stage.turn(1.1) == {}
    assert handler_stage.turn(9.0) == {}
    handler_stage.ask("/dance/unsubscribe", 9001)
    assert handler_stage.door.subscribers.active == 0


def test_subscriber_limit_excludes_renewals():
    subscribers = Subscribers(Values())
    for number in range(MOST_SUBSCRIBERS):
        assert subscribers.add(("10.0.0.1", number), ("10.0.0.1", number), "/dance", 10.0, 0.0)
    assert not subscribers.add(("10.0.0.2", 1), ("10.0.0.2", 1), "/dance", 10.0, 0.0)
    assert subscribers.add(("10.0.0.1", 3), ("10.0.0.1", 3), "/dance", 20.0, 5.0)
    assert subscribers.add(("10.0.0.2", 1), ("10.0.0.2", 1), "/dance", 10.0, 11.0)
    assert (subscribers.active, subscribers.refused) == (2, 1)


def delayed_bundle(ahead, *messages):
    bundle = OscBundleBuilder(time.time() + ahead)
    for each in messages:
        bundle.add_content(each)
    return bundle.build().dgram


def test_future_bundle_waits_without_delaying_others(stage):
    later = delayed_bundle(1.0, message("/dance/clock/one"), message("/dance/spread"))
    stage.send(later, delayed_bundle(0.5, message("/dance/clear")), message("/dance/clock/tap").dgram)
    assert stage.events() == [events.Tap(**STAMP)]
    assert stage.osc.status()["waiting"] == 3
    stage.clock.set(7.25 + 0.9)
    wait_until(lambda: stage.osc.status()["waiting"] == 2)
    (cleared,) = stage.events()
    assert isinstance(cleared, events.Clear)
    assert cleared.time == pytest.approx(7.75, abs=0.2)
    stage.clock.set(9.0)
    wait_until(lambda: stage.osc.status()["waiting"] == 0)
    assert [type(event) for event in stage.events()] == [events.One, events.PlaceElement]
    assert stage.osc.status()["waited"] == 3
    assert stage.osc.handler.future_timetags == 0


def test_bundle_beyond_horizon_or_queue_acts_immediately():
    later = TimedQueue()
    assert not later.put(MAX_DELAY + 0.01, 0.0, "far")
    assert all(later.put(1.0 - number / MAX_ITEMS, 0.0, number) for number in range(MAX_ITEMS))
    assert not later.put(1.0, 0.0, "one too many")
    assert [item for _, item in later.pop_due(2.0)] == list(range(MAX_ITEMS - 1, -1, -1))
    handler_stage = HandlerStage(wall_clock=lambda: 1e9)
    tag = struct.pack(">Q", int((1e9 + 3600.0 + 2_208_988_800) * 2**32))
    tap = message("/dance/clock/tap").dgram
    list(handler_stage.door.handle(memoryview(b"#bundle\0" + tag + struct.pack(">i", len(tap)) + tap), ME, 0.0))
    assert len(handler_stage.events()) == handler_stage.door.future_timetags == 1


def test_last_of_several_queued_values_is_kept():
    handler_stage = HandlerStage()
    for value in (0.1, 0.2, 0.3):
        handler_stage.ask(LIGHT, value)
        handler_stage.ask(LARGER, value, "ember")
        handler_stage.ask("/dance/attract", value, 0.0)
    found = handler_stage.events()
    assert [round(e.points[0][0], 3) for e in found if isinstance(e, events.PlaceElement)] == [0.1, 0.2, 0.3]
    assert len(found) == 9  # what happens between two values keeps them apart
    for value in (0.1, 0.2, 0.3):
        handler_stage.ask(LIGHT, value)
        handler_stage.ask(LARGER, value, "ember")
    assert [round(e.value[0], 3) for e in handler_stage.events()] == [0.3, 0.3]
    for whom in ("*", "ember", "*"):
        handler_stage.ask(LARGER, 0.25, whom)
    assert [event.group for event in handler_stage.events()] == ["*", "ember", "*"]


def test_musician_port_accepts_only_musician_controls():
    handler_stage = HandlerStage(role="musician")
    handler_stage.ask("/dance/clock/tap")
    handler_stage.ask("/dance/panic")
    handler_stage.ask(LIGHT, 0.5)
    handler_stage.ask("/dance/pass/own/amount", 0.5)
    assert handler_stage.ask(LIGHT) == [(LIGHT, 1.5)]
    (tap,) = handler_stage.events()
    assert tap.source == "osc musician"
    assert handler_stage.reasons == {"not for this port's role": 3}


def test_each_sender_has_its_own_lane():
    inbox = EventQueue()
    door = OscHandler(inbox.add_queue(), make_lane=inbox.add_queue)
    for number in range(100):
        list(door.handle(memoryview(message("/dance/attract", float(number), 0.0).dgram), ME, 0.0))
    list(door.handle(memoryview(message("/dance/clock/tap").dgram), YOU, 0.0))
    assert [type(event) for event in inbox.drain(3)].count(events.Tap) == 1
    for number in range(3 * MAX_LANES):  # more senders than lanes: whoever has nothing waiting gives his up
        list(door.handle(memoryview(message("/dance/clock/tap").dgram), ("10.0.0.1", number), 0.0))
    assert len(inbox.drain()) == 98 + 3 * MAX_LANES
    assert inbox.dropped == 0


def test_host_with_many_ports_gets_few_lanes():
    made = []
    inbox = EventQueue()
    door = OscHandler(inbox.add_queue(), make_lane=lambda: made.append(inbox.add_queue()) or made[-1])
    tap = memoryview(message("/dance/clock/tap").dgram)
    for second in range(40):
        list(door.handle(tap, ME, float(second)))
        own = made[0]
        assert len(own) == 1  # the operator's lane stays the operator's
        for number in range(100):
            list(door.handle(tap, ("10.0.0.66", 100 * second + number), second + 0.5))
        inbox.drain()
    assert len(made) == 1 + MAX_LANES_PER_HOST
    for number in range(3 * MAX_LANES):
        list(door.handle(tap, (f"10.0.1.{number}", 9), 40.0))
    assert len(made) == MAX_LANES
    list(door.handle(tap, ("10.0.2.1", 9), 41.0 + LANE_TIMEOUT))  # whoever has long said nothing gives his up
    assert len(made) == MAX_LANES
    assert ("10.0.2.1", 9) in door._lanes
