"""What is asked over OSC: present values, subscriptions, values that come later, several at once by a pattern."""

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


def told(datagrams):
    """The messages in datagrams, as python-osc reads them."""
    return [(m.message.address, *m.message.params) for d in datagrams for m in OscPacket(d).messages]


def near(rows):
    return [tuple(pytest.approx(value, abs=1e-6) if type(value) is float else value for value in row) for row in rows]


class Asked:
    """A door without a socket."""

    def __init__(self, **options):
        self.lane = PriorityQueue()
        self.door = OscHandler(self.lane, **options)
        self.door.values.update({LIGHT: (("", (1.5,)),), HAZE: (("", (0.25,)),), "/dance/hold": (("", (False,)),)})
        self.door.values.update({LARGER: (("ember", (0.25,)), ("tide", (-0.5,)))})
        self.door.values.update({"/dance/status/measure": (("", (3,)),)})

    def ask(self, address, *values, of=ME, at=0.0):
        return told(self.door.handle(memoryview(message(address, *values).dgram), of, at))

    def events(self):
        found = []
        while (event := self.lane.pop()) is not None:
            found.append(event)
        return found

    def turn(self, now):
        sent = []
        self.door.subscribers.send_due(now, lambda datagram, where: sent.append((where, datagram)))
        return {where: told([d for to, d in sent if to == where]) for where, _ in sent}

    @property
    def reasons(self):
        return self.door.rejected.as_dict()


def test_a_message_without_values_asks_and_changes_nothing():
    asked = Asked()
    assert asked.ask(LIGHT) == [(LIGHT, 1.5)]
    assert asked.ask("/dance/hold") == [("/dance/hold", False)]
    assert asked.ask("/dance/status/measure") == [("/dance/status/measure", 3)]
    assert asked.ask(LARGER) == [(LARGER, 0.25, "ember"), (LARGER, -0.5, "tide")]
    assert asked.ask(LIGHT, None) == [(LIGHT, 1.5)]
    assert asked.events() == []
    assert asked.reasons == {}


def test_get_answers_for_one_or_many_and_says_what_has_no_value():
    asked = Asked()
    assert asked.ask("/dance/get", LIGHT) == [(LIGHT, 1.5)]
    assert asked.ask("/dance/get", "/dance/light/{key,haze}") == near([(LIGHT, 1.5), (HAZE, 0.25)])
    assert asked.ask("/dance/get", "/dance/attract") == [("/dance/no_value", "/dance/attract")]
    assert asked.ask("/dance/get", "/dance/clock/hold") == [("/dance/no_value", "/dance/clock/hold")]
    assert asked.ask("/dance/get", "/nothing") == []
    assert asked.ask("/dance/get", "/dance/[") == []
    assert asked.reasons == {"unknown address": 1, "unusable pattern": 1}


def test_what_sets_without_a_value_still_sets():
    asked = Asked()
    assert asked.ask("/dance/clock/hold") == []
    assert [type(event) for event in asked.events()] == [events.HoldTempo]


def test_nobody_far_away_is_sent_more_than_he_sent():
    asked = Asked()
    assert asked.ask(LIGHT, of=FAR) == []
    assert asked.ask("/dance/ping", of=FAR) == [("/dance/pong",)]
    asked.ask("/dance/subscribe", of=FAR)
    assert asked.reasons == {"sender not allowed": 1}
    assert asked.turn(1.0) == {}
    everything = dict.fromkeys(READABLE, (("", (1.0,)),))
    asked.door.values.update(everything)
    assert len(asked.ask("/dance/get", "/dance/*/*")) == MAX_ANSWERS


def test_a_pattern_sets_values_and_never_what_happens_once():
    asked = Asked()
    asked.ask("/dance/light/{key,rim}", 0.5)
    found = asked.events()
    assert [(event.parameter, event.x) for event in found] == [("/dance/light/key", 0.5), ("/dance/light/rim", 0.5)]
    assert asked.ask("/dance/*") == [("/dance/hold", False)]
    asked.ask("/dance/p*c")
    assert asked.events() == []
    assert asked.reasons == {"unknown address": 1}
    asked.ask("/dance/light/*", 0.25)  # colours take three numbers: they are not meant
    numbers = [c for c in REGISTRY if c.address.startswith("/dance/light/") and c.address.count("/") == 3]
    assert len(asked.events()) == sum(c.value == 1 for c in numbers)


def test_new_patterns_are_looked_up_so_many_times_a_second():
    asked = Asked()
    for number in range(3 * PATTERNS_PER_SECOND):
        asked.ask(f"/dance/light/k*{number}", 1.0)
    assert asked.reasons == {"unknown address": PATTERNS_PER_SECOND, "unusable pattern": 2 * PATTERNS_PER_SECOND}
    for _ in range(5):
        asked.ask("/dance/light/k*0", 1.0)  # remembered
    assert asked.reasons["unusable pattern"] == 2 * PATTERNS_PER_SECOND
    asked.ask("/dance/light/k*", 1.0, at=1.0)
    assert len(asked.events()) == 1


def test_a_subscriber_gets_all_that_is_and_then_what_changes_once():
    asked = Asked()
    assert asked.ask("/dance/subscribe", "/dance/light", 10.0) == []
    assert asked.turn(0.0) == {ME: near([(LIGHT, 1.5), (HAZE, 0.25)])}
    for at, value in ((1.0, 0.5), (1.01, 0.75), (1.02, 0.75)):
        asked.door.values.update({LIGHT: (("", (value,)),)})
        asked.door.subscribers.mark_changed([LIGHT, LARGER], at)
    assert asked.turn(1.02) == {ME: [(LIGHT, 0.75)]}
    asked.door.subscribers.mark_changed([LIGHT], 1.1)
    assert asked.turn(1.2) == {}
    asked.door.values.update({LIGHT: (("", (0.5,)),)})
    asked.door.subscribers.mark_changed([LIGHT], 11.0)
    assert asked.turn(11.0) == {}  # ten seconds are over
    assert asked.door.subscribers.active == 0


def test_one_may_subscribe_to_several_parts_and_is_told_each_value_once():
    asked = Asked()
    asked.ask("/dance/subscribe", LIGHT, 10.0)
    asked.ask("/dance/subscribe", "/dance/light/", 20.0)
    asked.ask("/dance/subscribe", "/dance/status", 10.0)
    assert asked.turn(0.0) == {ME: near([(LIGHT, 1.5), (HAZE, 0.25), ("/dance/status/measure", 3)])}
    asked.door.subscribers.send_due(15.0, lambda *_: None)
    asked.door.values.update({HAZE: (("", (0.5,)),), "/dance/status/measure": (("", (4,)),)})
    asked.door.subscribers.mark_changed([HAZE, "/dance/status/measure"], 15.0)
    assert asked.turn(15.1) == {ME: [(HAZE, 0.5)]}


def test_a_subscriber_is_told_at_most_so_often():
    asked = Asked()
    asked.ask("/dance/subscribe", LIGHT)
    sent = 0
    for tick in range(1000):
        asked.door.values.update({LIGHT: (("", (tick / 1000,)),)})
        asked.door.subscribers.mark_changed([LIGHT], tick / 1000)
        sent += len(asked.turn(tick / 1000))
    assert 0.9 / UPDATE_INTERVAL < sent <= 1.0 / UPDATE_INTERVAL + 1


def test_who_sets_a_value_is_not_told_it_but_others_are():
    asked = Asked()
    for who in (ME, YOU):
        asked.ask("/dance/subscribe", "/dance/light", of=who)
    asked.turn(0.0)
    asked.ask(LIGHT, 0.5, at=1.0)
    for at, value in ((1.05, 1.0), (1.1, 0.5)):  # softly
        asked.door.values.update({LIGHT: (("", (value,)),)})
        asked.door.subscribers.mark_changed([LIGHT], at)
        assert asked.turn(at) == {YOU: [(LIGHT, value)]}
    assert asked.turn(1.0 + 2.0 * ECHO_DELAY) == {}
    asked.door.values.update({LIGHT: (("", (0.25,)),)})  # somebody else, then back to what I said
    asked.door.subscribers.mark_changed([LIGHT], 4.0)
    assert asked.turn(4.0) == {ME: [(LIGHT, 0.25)], YOU: [(LIGHT, 0.25)]}
    asked.door.values.update({LIGHT: (("", (0.5,)),)})
    asked.door.subscribers.mark_changed([LIGHT], 5.0)
    assert asked.turn(5.0) == {ME: [(LIGHT, 0.5)], YOU: [(LIGHT, 0.5)]}


def test_who_sets_what_does_not_come_is_told_what_is():
    asked = Asked()
    asked.ask("/dance/subscribe", LIGHT)
    asked.turn(0.0)
    asked.ask(LIGHT, 0.5, at=1.0)
    assert asked.turn(1.0 + ECHO_DELAY / 2) == {}
    assert asked.turn(1.0 + ECHO_DELAY) == {ME: [(LIGHT, 1.5)]}


def test_one_may_hear_at_another_port_and_leave():
    asked = Asked()
    asked.ask("/dance/subscribe", LIGHT, 60.0, 9001)
    assert set(asked.turn(0.0)) == {(ME[0], 9001)}
    asked.ask(LIGHT, 0.5, at=1.0)
    asked.door.values.update({LIGHT: (("", (0.5,)),)})
    asked.door.subscribers.mark_changed([LIGHT], 1.1)
    assert asked.turn(1.1) == {}
    assert asked.turn(9.0) == {}
    asked.ask("/dance/unsubscribe", 9001)
    assert asked.door.subscribers.active == 0


def test_there_is_room_for_so_many_and_renewing_needs_none():
    subscribers = Subscribers(Values())
    for number in range(MOST_SUBSCRIBERS):
        assert subscribers.add(("10.0.0.1", number), ("10.0.0.1", number), "/dance", 10.0, 0.0)
    assert not subscribers.add(("10.0.0.2", 1), ("10.0.0.2", 1), "/dance", 10.0, 0.0)
    assert subscribers.add(("10.0.0.1", 3), ("10.0.0.1", 3), "/dance", 20.0, 5.0)
    assert subscribers.add(("10.0.0.2", 1), ("10.0.0.2", 1), "/dance", 10.0, 11.0)
    assert (subscribers.active, subscribers.refused) == (2, 1)


def in_a_bundle(ahead, *messages):
    bundle = OscBundleBuilder(time.time() + ahead)
    for each in messages:
        bundle.add_content(each)
    return bundle.build().dgram


def test_a_bundle_waits_for_its_time_and_others_do_not_wait_for_it(stage):
    later = in_a_bundle(1.0, message("/dance/clock/one"), message("/dance/spread"))
    stage.send(later, in_a_bundle(0.5, message("/dance/clear")), message("/dance/clock/tap").dgram)
    assert stage.events() == [events.Tap(**STAMP)]
    assert stage.osc.status()["waiting"] == 3
    stage.clock.set(7.25 + 0.9)
    wait_until(lambda: stage.osc.status()["waiting"] == 2)
    (cleared,) = stage.events()
    assert isinstance(cleared, events.Clear)
    assert cleared.time == pytest.approx(7.75, abs=0.2)
    stage.clock.set(9.0)
    wait_until(lambda: stage.osc.status()["waiting"] == 0)
    assert [type(event) for event in stage.events()] == [events.One, events.Spread]
    assert stage.osc.status()["waited"] == 3
    assert stage.osc.future_timetags == 0


def test_what_lies_beyond_the_horizon_or_the_queue_acts_at_once():
    later = TimedQueue()
    assert not later.put(MAX_DELAY + 0.01, 0.0, "far")
    assert all(later.put(1.0 - number / MAX_ITEMS, 0.0, number) for number in range(MAX_ITEMS))
    assert not later.put(1.0, 0.0, "one too many")
    assert [item for _, item in later.pop_due(2.0)] == list(range(MAX_ITEMS - 1, -1, -1))
    asked = Asked(wall_clock=lambda: 1e9)
    tag = struct.pack(">Q", int((1e9 + 3600.0 + 2_208_988_800) * 2**32))
    tap = message("/dance/clock/tap").dgram
    list(asked.door.handle(memoryview(b"#bundle\0" + tag + struct.pack(">i", len(tap)) + tap), ME, 0.0))
    assert len(asked.events()) == asked.door.future_timetags == 1


def test_of_values_nobody_has_taken_the_last_counts():
    asked = Asked()
    for value in (0.1, 0.2, 0.3):
        asked.ask(LIGHT, value)
        asked.ask(LARGER, value, "ember")
        asked.ask("/dance/attract", value, 0.0)
    found = asked.events()
    assert [round(e.x, 3) for e in found if isinstance(e, events.Attract)] == [0.1, 0.2, 0.3]
    assert len(found) == 9  # what happens between two values keeps them apart
    for value in (0.1, 0.2, 0.3):
        asked.ask(LIGHT, value)
        asked.ask(LARGER, value, "ember")
    assert [round(getattr(e, "x", 0.0) or e.value, 3) for e in asked.events()] == [0.3, 0.3]
    for whom in ("*", "ember", "*"):
        asked.ask(LARGER, 0.25, whom)
    assert [event.group for event in asked.events()] == ["*", "ember", "*"]


def test_a_musicians_port_takes_what_musicians_may():
    asked = Asked(role="musician")
    asked.ask("/dance/clock/tap")
    asked.ask("/dance/panic")
    asked.ask(LIGHT, 0.5)
    asked.ask("/dance/pass/own/amount", 0.5)
    assert asked.ask(LIGHT) == [(LIGHT, 1.5)]
    (tap,) = asked.events()
    assert tap.source == "osc musician"
    assert asked.reasons == {"not for this port's role": 3}


def test_each_sender_has_a_lane_of_its_own():
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


def test_who_sends_from_ever_new_ports_gets_few_lanes_and_takes_nobody_s():
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
