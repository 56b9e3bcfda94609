"""Tests of the gateway with aiohttp phones: join, touch, vote, resume, limits, rules and reported events."""

import asyncio
import json
import struct

import aiohttp
import pytest

from live.control.audience.phone_registry import ticket_key
from live.control.audience.rate_limit import RefusalReason
from live.control.audience.session_state import BeatClock, Rules
from tests.control.audience.made_gateway import SECRET, FakePhone, current_key, open_gateway, until

RULES = Rules(regions=("left", "right"), weights=(1.0, 1.0))


def run(test, **plan):
    async def all_of_it():
        async with open_gateway(**plan) as (gateway, show, address), aiohttp.ClientSession() as session:
            await test(gateway, show, address, session)

    asyncio.run(asyncio.wait_for(all_of_it(), 60.0))


def last_event(show, what):
    """The last event of the show for which `what` is true of its fields."""
    names = ("at", "phones", "order", "share", "places", "lights", "votes", "shaken")
    rows = [dict(zip(names, packet[1:], strict=True)) for packet in show.look().heard]
    return next((row for row in reversed(rows) if what(row)), None)


def test_page_is_localized_small_and_self_contained():
    async def test(_gateway, _show, address, session):
        async with session.get(address, headers={"Accept-Language": "pt-PT,pt;q=0.9,en;q=0.8"}) as answer:
            body = await answer.read()
            assert b'<html lang="pt"' in body
            assert len(body) < 50_000
            for elsewhere in (b"http://", b"https://", b"src=", b"@import", b"url("):
                assert elsewhere not in body
            assert answer.headers["Content-Security-Policy"].startswith("default-src 'none'; script-src 'sha256-")
            assert "Set-Cookie" not in answer.headers
        for accepted, language in (
            ("de, en;q=0.1", "de"),
            ("ja-JP", "ja"),
            ("sv, nl;q=0.5", "en"),
            ("es;q=0.2, fr", "fr"),
        ):
            async with session.get(address, headers={"Accept-Language": accepted}) as answer:
                assert f'<html lang="{language}"'.encode() in await answer.read()
        for path, status in (("/../../etc/passwd", 404), ("/%2e%2e/x", 404), ("/ws", 404), ("/x" * 500, 404)):
            async with session.get(address + path) as answer:
                assert answer.status == status
        async with session.post(address, data=b"x" * 5000) as answer:
            assert answer.status == 404

    run(test)


def test_touch_of_joined_phone_becomes_place_and_light():
    async def test(gateway, show, address, session):
        link, code = show.code
        assert link == f"{address}/#{current_key(show)}"
        assert len(code) == len(code[0]) >= 25
        phone = await FakePhone(session, address).join(current_key(show))
        assert phone.number == 1
        await phone.touch(1, 0.75, 0.5)
        row = await until(lambda: last_event(show, lambda row: row["places"]))
        assert row["places"] == ((300, 0, 1000, 1),)
        assert (row["phones"], row["share"]) == (1, 1000)
        row = await until(lambda: last_event(show, lambda row: row["lights"]))
        assert row["lights"] == ((1, 300, 0, 618, 1),)
        while phone.said.get("h") not in (1, 2):
            await phone.hear()
        await phone.touch(2, 0.25, 1.0)
        await until(lambda: last_event(show, lambda row: row["places"] == ((-300, 400, 1000, 2),)))
        await phone.ws.close()
        await until(lambda: gateway.session.phones.by_number == {})
        await until(lambda: last_event(show, lambda row: row["phones"] == 0))

    run(test)


def test_operator_rules_apply_to_next_show_event():
    async def test(_gateway, show, address, session):
        one, other = [await FakePhone(session, address).join(current_key(show), region=region) for region in (0, 1)]
        await one.touch(1, 0.0, 0.5)
        await other.touch(1, 1.0, 0.5)
        await until(lambda: last_event(show, lambda row: len(row["places"]) == 2))
        show.tell(Rules(order=3, regions=RULES.regions, weights=(0.0, 1.0)))
        row = await until(lambda: last_event(show, lambda row: row["order"] == 3))
        assert row["places"][-1][0] == 600
        show.tell(Rules(order=4, regions=RULES.regions, weights=(1.0, 1.0), banned=(other.number,)))
        row = await until(lambda: last_event(show, lambda row: row["order"] == 4))
        assert [place[0] for place in row["places"] if place[2]] == [-600]
        await other.touch(1, 1.0, 0.5)  # she is told nothing, and heard no more
        show.tell(Rules(order=5, open=False))
        assert (await until(lambda: last_event(show, lambda row: row["order"] == 5)))["places"] == ()

    run(test)


def test_each_phone_votes_once_with_its_region_weight():
    async def test(_gateway, show, address, session):
        phones = [await FakePhone(session, address).join(current_key(show), region=k % 2) for k in range(4)]
        vote = (259, "step", ("sway", "spin"), 64.0)
        show.tell(Rules(order=1, regions=RULES.regions, weights=(1.0, 0.5), vote=vote))
        await until(lambda: last_event(show, lambda row: row["votes"] == (259, 0, 0)))
        for phone, choice in zip(phones, (0, 1, 1, 9), strict=True):
            await phone.ws.send_bytes(bytes((3, 259 % 256, choice)))
        await phones[0].ws.send_bytes(bytes((3, 7, 1)))  # a vote of long ago
        await until(lambda: last_event(show, lambda row: row["votes"] == (259, 100, 150)))
        for _ in range(3):
            await phones[0].ws.send_bytes(bytes((3, 259 % 256, 1)))  # she thinks again
        await until(lambda: last_event(show, lambda row: row["votes"] == (259, 0, 250)))
        while not phones[0].said.get("s", {}).get("vote"):
            await phones[0].hear()
        assert phones[0].said["s"]["vote"] == [259, "step", ["sway", "spin"], 64.0]

    run(test)


def test_phone_resumes_by_token_on_newest_socket():
    async def test(gateway, show, address, session):
        first = await FakePhone(session, address).join(current_key(show), region=1)
        again = await FakePhone(session, address).join(token=first.token, region=1)
        assert again.number == first.number
        await until(lambda: len(gateway.session.phones) == 1 and gateway.session.voices.count == 1)
        while (await first.ws.receive(timeout=20.0)).type is aiohttp.WSMsgType.TEXT:
            pass  # the old socket is closed
        await again.touch(1, 0.5, 0.5)
        await until(lambda: last_event(show, lambda row: row["places"]))
        stranger = await FakePhone(session, address).join(token="7.3.9.abcdefghijkl")
        assert stranger.no == "token"
        late = await FakePhone(session, address).join(ticket_key(SECRET, 0))
        assert late.no == "link"
        assert gateway.session.refused[RefusalReason.TOKEN] == gateway.session.refused[RefusalReason.LINK] == 1

    run(test)


def test_ping_returns_show_time_and_beat_changes_are_sent():
    async def test(_gateway, show, address, session):
        phone = await FakePhone(session, address).join(current_key(show))
        before = show.now()
        await phone.ws.send_bytes(struct.pack("<Bd", 2, 123.25))
        while (message := await phone.hear()).type is not aiohttp.WSMsgType.BINARY:
            pass
        verb, mine, there = struct.unpack("<Bdd", message.data)
        assert (verb, mine) == (2, 123.25)
        assert before <= there <= show.now()
        show.tell(BeatClock(time=100.0, beat=0.0, tempo=90.0, beats_per_measure=3, line=1.0))
        while phone.said.get("c", [0, 0, 0])[2] != 90.0:
            await phone.hear()
        assert phone.said["c"] == [100.0, 0.0, 90.0, 3, 1.0]

    run(test)


def test_rate_address_and_origin_limits_are_enforced():
    async def test(gateway, show, address, session):
        refused = gateway.session.refused
        phones = [await FakePhone(session, address).join(current_key(show)) for _ in range(3)]
        assert (await FakePhone(session, address).join(current_key(show))).no == "address"
        await phones[0].ws.close()
        await until(lambda: len(gateway.session.phones) == 2)
        for number in range(250):
            await phones[1].touch(1, 0.5, number / 250)
        await until(lambda: refused[RefusalReason.FAST] > 150)
        assert gateway.session.messages - refused[RefusalReason.FAST] < 60
        assert not phones[1].ws.closed
        for origin in ("http://evil.example", "null"):
            with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
                await FakePhone(session, address).join(current_key(show), origin=origin)
        for host in ("evil.example", "127.0.0.1.evil.example", "x" * 300, "localhost.evil"):
            async with session.get(address, headers={"Host": host}) as answer:
                assert answer.status == 403
        assert (refused[RefusalReason.ORIGIN], refused[RefusalReason.HOST]) == (2, 4)
        await until(lambda: show.look().facts.get("refused", {}).get(RefusalReason.HOST) == 4)
        assert "127.0.0.1" not in json.dumps(show.facts)  # nothing about anybody

    run(test, per_address=3, network="own wifi")
