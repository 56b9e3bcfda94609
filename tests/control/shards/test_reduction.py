"""Tests of several gateways in memory: they do as one would, one voice for a group on all, liars, dead gateways."""

import itertools
import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.control.audience.broadcaster import touch_seconds
from live.control.audience.session_state import Rules
from live.control.audience.voice_report import HIGHLIGHT_SECONDS, VoiceReport
from live.control.audience.voice_sketch import UNIT, VoiceSketch, grid_of
from live.control.message_codec import decode_packet, encode_packet
from live.control.shards.messages import PROTOCOL, ShardChanges, ShardHello, ShardRefused, ShardShown, pack_voices
from tests.control.shards.made_shards import Hall, touch

VOTE = (259, "step", ("sway", "spin", "glide"), 64.0)
RULES = Rules(regions=("left", "right"), weights=(1.0, 0.5), vote=VOTE)


def fill(hall, count, seed=3):
    """`count` phones that play, divided by chance among the gateways; three of each ten share an address."""
    chance = np.random.default_rng(seed)
    centre, people = ((0.3, 0.4), (0.7, 0.6)), []
    for number in range(1, count + 1):
        group = 7000 + number // 10 if number % 10 < 3 else number
        region, kind, mode = int(chance.integers(2)), int(number % 3 == 0), 1 + int(number % 5 == 0)
        place = np.clip(chance.normal(centre[kind], 0.05), 0.0, 1.0)
        choice, at = int(chance.integers(3)), int(chance.integers(1 << 20))
        one = hall.shards[at % len(hall.shards)]
        phone = hall.enter(one, number, group, region)
        touch(one, phone, mode, *place)
        one.session.handle_message(phone, bytes((3, VOTE[0] % 256, choice)), hall.time)
        people.append((one, phone))
    return people


@pytest.mark.parametrize("shards", [4, 16])
def test_gateways_together_do_as_one_gateway_would(shards):
    told = []
    for count in (1, shards):
        hall = Hall(count, RULES)
        fill(hall, 300)
        told.append(hall.step(20))
    one, many = told
    assert many.tally == one.tally
    assert sum(one.tally[1:]) > 10_000
    assert (many.phones, many.speaking, many.order) == (one.phones, one.speaking, one.order) == (300, 300, 0)
    assert many.sketch.people == one.sketch.people
    force, wanted = many.sketch.force(), one.sketch.force()
    assert len(force.places) == len(wanted.places) >= 2
    for found, place in zip(force.places, wanted.places, strict=True):
        assert math.hypot(found.x - place.x, found.z - place.z) <= 0.05
        assert found.weight == pytest.approx(place.weight, rel=0.02)
        assert found.mode == place.mode
    assert force.share == pytest.approx(wanted.share, rel=0.02)
    assert len(many.lights) == 8


def test_address_on_all_gateways_has_one_voice_and_gives_it_back():
    hall = Hall(16)
    people = [(hall.shards[k % 16], hall.enter(hall.shards[k % 16], k + 1, 100 + k)) for k in range(32)]
    griefer = [(one, hall.enter(one, 1000 + 20 * k + j, 7)) for k, one in enumerate(hall.shards) for j in range(4)]
    for one, phone in people:
        touch(one, phone, 1, 0.2, 0.5)
    for one, phone in griefer:
        touch(one, phone, 1, 0.9, 0.5)
    report = hall.step(4)
    assert report.sketch.people == pytest.approx(33 * UNIT, rel=1e-3)
    assert report.sketch.total() == pytest.approx(33 * UNIT, rel=2e-3)
    [place] = report.sketch.force().places
    assert place.x == pytest.approx(-3.6, abs=0.01)
    for one, phone in griefer[1:]:
        one.session.disconnect(phone)
    hall.step(4)
    assert hall.shards[0].session.voices.share[griefer[0][1].row] == 1.0
    assert not hall.shards[0].session.phones.elsewhere


def test_groups_of_a_killed_gateway_are_forgotten():
    """Else phones that come back at another gateway would share their voices with themselves."""
    hall = Hall(2)
    stays, dies = hall.shards
    phone = hall.enter(stays, 1, 7)
    for number in range(2, 8):
        hall.enter(dies, number, 7 + number % 3)
    hall.step(4)
    assert stays.session.voices.share[phone.row] == pytest.approx(1 / 3)
    hall.kill(dies)
    hall.step(4)
    assert stays.session.voices.share[phone.row] == 1.0
    assert not stays.session.phones.elsewhere
    for number in range(2, 8):
        hall.enter(stays, number, 7 + number % 3, fresh=False)
    hall.step(4)
    assert stays.session.voices.share[phone.row] == pytest.approx(1 / 3)


def test_crowded_address_is_crowded_on_all_gateways():
    hall = Hall(3)
    phone = hall.enter(hall.shards[2], 5, 9)
    touch(hall.shards[2], phone, 1, 0.5, 0.5)
    assert hall.step().sketch.total() > 0
    admission = hall.shards[0].session.admission
    for _ in range(5):
        admission.admit_new(hall.shards[0].session.tickets.key(hall.time), "", 9, hall.time)
    assert admission.crowded == 1
    assert hall.step(3).sketch.total() == 0
    hall.time += 100.0
    hall.shards[0].session.sweep()
    hall.step(2)
    assert hall.shards[2].session.voices.share[phone.row] == 1.0


def test_phone_is_at_one_gateway_at_a_time():
    hall = Hall(2)
    first, second = hall.shards
    old = hall.enter(first, 17, 3)
    touch(first, old, 1, 0.5, 0.5)
    hall.step(2)
    new = hall.enter(second, 17, 3, fresh=False)
    touch(second, new, 1, 0.5, 0.5)
    report = hall.step(4)
    assert old.transport.aborted
    assert not new.transport.aborted
    assert report.sketch.total() == pytest.approx(UNIT, rel=2e-3)
    assert (report.phones, len(first.session.phones), len(second.session.phones)) == (1, 0, 1)
    assert first.session.voices.count == 0


def test_ban_holds_at_all_gateways():
    hall = Hall(2)
    first, second = hall.shards
    hall.enter(first, 17, 3)
    other = hall.enter(second, 18, 4)
    touch(second, other, 1, 0.5, 0.5)
    hall.step(2)
    hall.tell(Rules(order=1, banned=(17,)))
    hall.step()
    for one in hall.shards:
        one.uplink.report_facts({**one.session.facts(), "late_ms": [0.0, 0.0], "missed_frames": 0}, hall.time)
    hall.step()
    again = hall.enter(second, 99, 3)  # the same address, another gateway, a new number
    touch(second, again, 1, 0.5, 0.5)
    report = hall.step(2)
    assert report.order == 1
    assert report.sketch.people == UNIT
    assert report.sketch.total() == pytest.approx(UNIT, rel=2e-3)
    assert [row[0] for row in hall.reduction.facts(hall.time)["bans"]] == [17]
    hall.shards.append(hall.join("late"))  # it learns of the ban before its first phone comes
    late = hall.enter(hall.shards[-1], 100, 3)
    touch(hall.shards[-1], late, 1, 0.5, 0.5)
    assert hall.step(2).sketch.people == UNIT


def test_gateway_that_lies_is_bounded_and_counted():
    hall = Hall(3, most=100)
    for k in range(60):
        one = hall.shards[k % 2]
        touch(one, hall.enter(one, k + 1, 100 + k), 1, 0.2, 0.5)
    liar = hall.shards[2].known
    grid = grid_of((6.0, 4.0))
    x, z = np.array([5.0]), np.array([0.0])
    sketch = VoiceSketch.of_voices(
        grid, x, z, np.array([60_000 * UNIT]), np.array([1], np.int8), 10**9 * UNIT, 10**9 * UNIT
    )
    hall.shards[2].killed = True  # it speaks for itself
    for _ in range(8):
        hall.reduction.handle(liar, pack_voices(VoiceReport(0, 10**9, 10**9, sketch)), hall.time)
        report = hall.step()
    assert liar.lies == 8
    assert hall.reduction.refused["gateway: claims too much"] == 8
    assert report.phones == 160
    assert report.sketch.people <= 160 * UNIT * 1.01
    assert report.sketch.total() <= 160 * UNIT * 1.01
    other = replace(sketch, people=UNIT, shaken=0)  # one phone with the weight of 60,000
    liar.peak = 0
    hall.reduction.handle(liar, pack_voices(VoiceReport(0, 1, 1, other)), hall.time)
    assert hall.step().sketch.total() <= 61 * UNIT * 1.01
    facts = {**hall.shards[0].session.facts(), "late_ms": [0.0], "missed_frames": 0, "clock_ms": 0.0, "version": "1"}
    wrong = [{"messages": 1}, *(facts | {"voices": number} for number in (math.nan, math.inf)), facts | {"held": 3}]
    hall.reduction.handle(liar, encode_packet(facts), hall.time)
    for data in (b"", b"V", b"V" + bytes(40), b"\xc1", encode_packet({"messages": "x"}), encode_packet(("bans", 3)),
                 *map(encode_packet, wrong)):  # fmt: skip
        before = liar.lies
        hall.reduction.handle(liar, data, hall.time)
        assert liar.lies == before + 1
    rows = tuple((key, 1, 1, -1.0) for key in range(500))
    assert hall.reduction.groups.update_groups(liar.name, rows, 100, 0.0) == 400


def test_lights_and_crowds_that_cannot_be_are_left_out_and_counted():
    """The show gets no number from a gateway that it could not hold."""
    hall = Hall(2)
    honest, liar = hall.shards
    phone = hall.enter(honest, 5, 9)
    touch(honest, phone, 1, 0.5, 0.5)
    hall.step(30)
    far, light = 10**15, (7, 100, -50, 300, 1)
    lights = ((1 << 63, 0, 0, 0, 1), (8, far, 0, 0, 1), (8, 0, -far, 0, 1), (8, 0, 0, 5000, 1), (8, 0, 0, 0, 9), light)
    liar.known.visible = 8
    hall.reduction.handle(liar.known, encode_packet(ShardShown(lights, ())), hall.time)
    assert liar.known.lights == (light,)
    assert liar.known.lies == 5
    for until in (math.nan, math.inf, hall.time + 1000.0):
        hall.reduction.handle(liar.known, encode_packet(ShardChanges(((9, 0, 0, until),))), hall.time)
    assert liar.known.lies == 8
    hall.step(2)
    assert honest.session.voices.share[phone.row] == 1.0


def test_force_of_a_killed_gateway_fades_without_a_jump():
    hall = Hall(4)
    people = [(hall.shards[k % 4], hall.enter(hall.shards[k % 4], k + 1, k + 1)) for k in range(100)]
    hall.tick = 4 * TICK

    def play():
        for one, phone in people[:4]:  # one finger at each: 64 % of the force
            if not one.killed:
                touch(one, phone, 1, 0.25, 0.5)
        return hall.step()

    for _ in range(5):
        before = play()
    force = before.sketch.force()
    assert force.share == pytest.approx(0.64, rel=0.01)
    dead, phones, last = hall.shards[1], [], force
    hall.kill(dead)
    for _ in range(int(6.0 / hall.tick)):
        report = play()
        force = report.sketch.force()
        assert abs(force.share - last.share) <= 0.03
        assert [round(place.x, 6) for place in force.places] == [-2.999216]
        last = force
        phones.append(report.phones)
    assert phones[0] == 100
    assert phones == sorted(phones, reverse=True)
    assert phones[-1] == 75
    assert dead.name not in hall.reduction.shards


def test_voices_of_a_gateway_that_falls_silent_fade_and_come_back():
    hall, totals = Hall(2), []
    people = [(one, hall.enter(one, k + 1, k + 1)) for k, one in enumerate(hall.shards)]
    hall.shards[1].killed = True  # its connection stands, and nothing comes
    for tick in range(int(3.5 / TICK)):
        if tick % 16 == 0:
            for one, phone in people:
                touch(one, phone, 1, 0.5, 0.5)
        hall.shards[1].killed = tick > 8
        totals.append(hall.step().sketch.total() / UNIT)
    assert totals[5] == totals[int(0.75 / TICK)] == pytest.approx(2.0, rel=2e-3)
    assert all(later <= earlier for earlier, later in itertools.pairwise(totals[5:]))
    assert totals[-1] == pytest.approx(1.0 + 0.5 ** (3.5 - 0.75 - 9 * TICK), rel=0.05)
    hall.shards[1].killed = False
    assert hall.step(2).sketch.total() == pytest.approx(2 * UNIT, rel=2e-3)


@pytest.mark.long
def test_each_voice_gets_its_light_in_turn_on_any_gateway():
    hall = Hall(3, visible=4)
    sizes, people, seen = (9, 2, 1), [], Counter()
    hall.tick = 0.1
    for one, size in zip(hall.shards, sizes, strict=True):
        for _ in range(size):
            people.append((one, hall.enter(one, len(people) + 1, len(people) + 1)))
    for step in range(int(6 * HIGHLIGHT_SECONDS / hall.tick)):
        if step % 5 == 0:
            for one, phone in people:
                touch(one, phone, 1, 0.5, 0.5)
        report = hall.step()
        assert len(report.lights) <= 4
        seen.update(light[0] for light in report.lights)
    assert set(seen) == {phone.number for _, phone in people}
    assert min(seen.values()) * hall.tick > HIGHLIGHT_SECONDS / 2


def test_numbers_are_given_once_and_after_a_restart_of_the_reducer():
    hall, taken = Hall(4), set()
    for _ in range(40):
        for one in hall.shards:
            number = one.session.phones.numbers.take()
            assert number not in taken
            taken.add(number)
        hall.step()
    highest = hall.reduction.facts(hall.time)["next"]
    assert highest <= 40 * 256
    again = Hall(0)
    answer = []
    hello = ShardHello(PROTOCOL, "1", "x", 100, highest)
    again.reduction.enter(hello, "here", answer.append, lambda: None, again.time)
    assert decode_packet(answer[-2]).first > highest


def test_gateways_that_do_not_fit_are_told_why():
    hall = Hall(0)
    for hello, why in (
        (ShardHello(PROTOCOL + 1, "9.9", "a", 10, 0), "version 9.9"),
        (ShardHello(PROTOCOL, "1", "", 10, 0), "a name"),
        (ShardHello(PROTOCOL, "1\n", "\x1b[2J", 10, 0), "a name"),
        (ShardHello(PROTOCOL, "1", "a", 0, 0), "room for phones"),
        (None, "hello"),
    ):
        answer = []
        assert hall.reduction.enter(hello, "here", answer.append, lambda: None, 0.0) is None
        told = decode_packet(answer[0])
        assert isinstance(told, ShardRefused)
        assert why in told.why
    assert hall.reduction.refused["gateway: does not fit"] == 5
    rows = hall.reduction.facts(30.0)["gateways"]
    assert [(row["name"], row["state"], row["version"], row["machine"]) for row in rows] == [
        ("", "refused", "1", "here"), (" [2J", "refused", "1 ", "here"), ("a", "refused", "1", "here"),
    ]  # fmt: skip
    hall.reduction.enter(ShardHello(PROTOCOL, "1", "a", 10, 0), "here", answer.append, lambda: None, 0.0)
    assert [row["name"] for row in hall.reduction.facts(70.0)["gateways"]] == ["a"]  # it fits; the others have gone
    one, answer = hall.join("one"), []
    hello = ShardHello(PROTOCOL, "1", one.known.name, 10, 0)
    assert hall.reduction.enter(hello, "elsewhere", answer.append, lambda: None, 0.0) is None
    assert "another machine" in decode_packet(answer[0]).why
    assert not one.link.closed


def test_gateway_starts_again_on_order_and_the_others_do_not():
    hall = Hall(2)
    hall.reduction.restart(hall.shards[1].known.name)
    hall.reduction.restart("of no gateway")
    hall.step()
    assert [one.uplink.restart_asked for one in hall.shards] == [False, True]
    assert [row["state"] for row in hall.reduction.facts(hall.time)["gateways"]] == ["serves", "serves"]
    hall.kill(hall.shards[1])
    hall.step(200)  # 3 s: the first is heard all the time
    hall.reduction.shards[hall.shards[0].known.name].heard_at -= 2.5
    assert [row["state"] for row in hall.reduction.facts(hall.time)["gateways"]] == ["silent", "gone"]


def test_rates_fall_smoothly_with_the_number_of_phones():
    assert 1.0 / touch_seconds(1) == 1.0 / touch_seconds(2000) == pytest.approx(10.0)
    assert 1.0 / touch_seconds(100_000) == pytest.approx(2.0)
    counts = np.geomspace(1, 1_000_000, 400)
    rates = np.array([1.0 / touch_seconds(count) for count in counts])
    assert np.all(np.diff(rates) <= 1e-12)
    assert np.all(np.diff(rates) >= -0.2)
    assert counts[-1] * rates[-1] > 1e6
    hall = Hall(2)
    hall.shards[0].session.phones.total_elsewhere = 99_999
    from live.control.audience.broadcaster import Broadcaster

    assert Broadcaster(hall.shards[0].session).touch_interval() == 500
