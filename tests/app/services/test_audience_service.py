"""The audience beside a show: phones that play through a real gateway process, and its sudden death."""

import asyncio
import os
import signal

import aiohttp
import numpy as np
import pytest

from live.app.launch_options import LaunchOptions
from live.app.option_values import expand_optional_values, parse_audience_address, parse_audience_link
from live.app.services.audience_service import AudienceService, beat_of, rules_of
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.time_source import SystemClock
from live.control.audience.stage_lights import GATHER, STAGE
from live.control.events import events
from live.show.engine import Engine
from live.show.view.status import Status
from tests.control.audience.made_gateway import FakePhone, until
from tests.control.audience.test_stage_lights import parse
from tests.show.made_show import made_show

REGIONS = '[audience]\nregions = ["stalls", "balcony"]\nvote_measures = 1\n'


class Stage:
    """A show with its audience that runs at 60 frames a second beside the steps of a test."""

    def __init__(self, **wished):
        self.show, self.clock, self.inbox = made_show(REGIONS), SystemClock(), EventQueue()
        self.status = Status(self.show, rejected=dict, memory=lambda: 1.0)
        self.engine = Engine(self.show, clock=self.clock, inbox=self.inbox, status=self.status)
        options = LaunchOptions(audience=("127.0.0.1", 0), audience_secret=b"s" * 32, **wished)
        self.part = AudienceService(options, self.show, self.inbox.add_queue(), self.clock)

    def say(self, kind, **values):
        self.inbox.put(kind(time=self.clock.now(), source="osc", **values))

    async def frames(self):
        while True:
            self.part.before_frame()
            self.engine.frame(lambda view: None)
            self.part.frame()
            await asyncio.sleep(1 / 60)

    async def play(self, test):
        self.part.start()
        running = asyncio.create_task(self.frames())
        try:
            await until(lambda: self.part.link)
            async with aiohttp.ClientSession() as session:
                await test(session)
        finally:
            running.cancel()
            self.part.stop()


@pytest.mark.long
def test_phones_move_dancers_and_resume_after_gateway_is_killed():
    stage = Stage()

    async def test(session):
        part, show = stage.part, stage.show
        key = part.link.partition("#")[2]
        phone = await FakePhone(session, part.address).join(key, region=1)
        await phone.touch(1, 1.0, 0.5)
        await until(lambda: any(e.source == "audience 1" and e.x == 6.0 for e in show.motion.elements.in_force))
        await until(lambda: show.audience.facts()["lights"] == [[phone.number, 6.0, 0.0]])
        assert stage.status.snapshot(1.0)["phones"] == 1
        await until(lambda: stage.clock.now() > 2.2)  # a process that dies at once is not started again at once
        frames, died = stage.status.frames, stage.clock.now()
        os.kill(part.pid, signal.SIGKILL)
        again = None
        while again is None:
            assert stage.clock.now() - died < 12.0  # 3 s of an idle machine
            try:
                again = await FakePhone(session, part.address).join(token=phone.token, region=1)
            except (aiohttp.ClientError, OSError):
                await asyncio.sleep(0.05)
        assert again.number == phone.number  # so it has its colour
        assert again.said["w"][4] == 1  # and its region
        assert stage.status.frames > frames + 10
        assert part.status()["restarts"] == 1
        await again.touch(1, 0.0, 0.5)
        await until(lambda: any(e.source == "audience 1" and e.x == -6.0 for e in show.motion.elements.in_force))
        stranger = await FakePhone(session, part.address).join(part.link.partition("#")[2])
        assert stranger.number > phone.number  # nobody gets a number that somebody has
        stage.say(events.OpenAudience, on=False)
        await until(lambda: not any(e.source == "audience 1" for e in show.motion.elements.in_force))
        while again.said.get("s", {"open": True})["open"]:
            await again.hear()

    asyncio.run(asyncio.wait_for(stage.play(test), 120.0))
    assert stage.show.refusals.count == 0


@pytest.mark.long
def test_phones_see_dancers_and_elements_of_show():
    stage = Stage()

    async def test(session):
        part, show = stage.part, stage.show
        assert part.invitation_link.startswith(part.address + "/#i.")
        phone = await FakePhone(session, part.address).join(part.invitation_link.partition("#")[2])
        place = {"kind": "attract", "points": ((3.0, -2.0),), "measures": 64.0}
        stage.inbox.put(events.PlaceElement(time=stage.clock.now(), source="osc", **place))
        shown = None
        while shown is None:
            message = await phone.hear()
            if message.type is aiohttp.WSMsgType.BINARY and message.data[0] == STAGE and message.data[3]:
                shown = parse(message.data)
        rows, [(shape, _, _, points)] = shown
        assert rows[:, 2].tolist() == [1] * 5 + [2] * 4
        assert np.abs(rows[:, :2] - show.dancers.drawn_hips).max() < 1.0  # they have danced on meanwhile
        assert shape == GATHER
        np.testing.assert_allclose(points, [(3.0, -2.0)], atol=0.05)
        while len(phone.said.get("g", ())) != 2:
            await phone.hear()

    asyncio.run(asyncio.wait_for(stage.play(test), 60.0))


def test_invitation_is_printed_works_and_is_renewed_by_operator(monkeypatch):
    notes, stage = [], Stage()
    monkeypatch.setattr(AudienceService, "_print_note", staticmethod(lambda words, _style: notes.append(words)))

    async def test(session):
        part = stage.part
        first = part.invitation_link
        assert notes == [f"note: audience: {first}, on this machine only"]
        assert (await FakePhone(session, part.address).join(first.partition("#")[2])).number
        stage.say(events.RenewInvitation)
        await until(lambda: len(notes) == 2)
        assert notes[1] == f"note: audience: {part.invitation_link}, on this machine only"
        assert part.invitation_link != first
        stranger = FakePhone(session, part.address)
        while (await stranger.join(first.partition("#")[2])).no != "link":  # until the gateway has been told
            await asyncio.sleep(0.01)
        assert (await FakePhone(session, part.address).join(part.invitation_link.partition("#")[2])).number

    asyncio.run(asyncio.wait_for(stage.play(test), 60.0))


def test_gateway_receives_rules_and_beat_of_show():
    show = made_show(REGIONS)
    for tick in range(1, 200):
        show.tick(tick / 64)
    show.apply(events.GiveTurn(time=1.0, source="osc", name="balcony", measures=2.0))
    show.apply(events.AskVote(time=1.0, source="osc", what="step", first="sway", second="spin"))
    rules, line = rules_of(show), show.span.end
    assert rules.turn == (1, line, line + 8.0)
    assert rules.vote == (1, "step", ("sway", "spin"), line + 4.0)
    assert rules.half == (6.0, 4.0)
    beat = beat_of(show)
    assert beat.beat_at(show.time) == show.timeline.beat_at(show.time)
    assert (line - beat.line) % 4 == 0


def test_audience_addresses_are_parsed_and_shown_and_busy_port_is_refused():
    assert parse_audience_address("8021") == ("127.0.0.1", 8021)
    assert parse_audience_address("0.0.0.0:80") == ("0.0.0.0", 80)
    assert parse_audience_address("[::1]:80") == ("::1", 80)
    for text in ("", "x", "1:2:3", "host:", "host:99999", "a b:80"):
        with pytest.raises(PersonError):
            parse_audience_address(text)
    assert parse_audience_link("https://play.example") == "https://play.example"
    for text in ("play.example", "ftp://x", "http://x/path", "http://x y"):
        with pytest.raises(PersonError):
            parse_audience_link(text)
    assert expand_optional_values(["play", "--audience"]) == ["play", "--audience", "127.0.0.1:8020"]
    assert expand_optional_values(["--audience", "a.toml"]) == ["--audience", "127.0.0.1:8020", "a.toml"]
    assert expand_optional_values(["--audience", "8021", "x"]) == ["--audience", "8021", "x"]
    made = made_show(), EventQueue().add_queue(), SystemClock()
    public = AudienceService(LaunchOptions(audience=("0.0.0.0", 8020), audience_secret=b"x"), *made)
    assert public.is_public
    assert public.address.startswith("http://")
    assert ":8020" in public.address
    named = AudienceService(LaunchOptions(audience=("0.0.0.0", 8020), audience_link="http://stage.local/"), *made)
    assert named.address == "http://stage.local"
    first = AudienceService(LaunchOptions(audience=("127.0.0.1", 0), audience_secret=b"x"), *made)
    first.start()
    try:
        with pytest.raises(PersonError, match="choose another port"):
            AudienceService(LaunchOptions(audience=("127.0.0.1", first.port), audience_secret=b"x"), *made).start()
    finally:
        first.stop()
