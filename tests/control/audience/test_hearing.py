"""Tests of what phones are told: whether they are heard, how a vote stands, and what the invitation lets in."""

import asyncio
from unittest.mock import patch

import aiohttp
import numpy as np
import pytest

from live.control.audience.admission import BEHIND_NAT, OWN_WIFI, Admission
from live.control.audience.join_tickets import INVITED_BURST, INVITED_RATE, JoinTickets
from live.control.audience.participant_state import Hearing, Voices
from live.control.audience.phone_protocol import ATTRACT
from live.control.audience.phone_registry import Phones, invitation_key, is_invitation, ticket_key
from live.control.audience.rate_limit import RefusalReason
from live.control.audience.session_state import Rules
from tests.control.audience.made_gateway import SECRET, FakePhone, current_key, open_gateway, until

REGIONS = {"regions": ("left", "right"), "weights": (1.0, 1.0)}


def run(test, **plan):
    """Phones that do not listen for a while answer no pings: on a loaded machine that would end them."""

    async def all_of_it():
        async with open_gateway(**plan) as (gateway, show, address), aiohttp.ClientSession() as session:
            await test(gateway, show, address, session)

    with patch("live.control.web.web_server.HEARTBEAT", 120.0):
        asyncio.run(asyncio.wait_for(all_of_it(), 60.0))


async def hear_until(phone, hearing):
    while phone.said.get("h") != hearing:
        await phone.hear()


def test_each_voice_has_an_honest_state_and_banned_ones_are_told_nothing():
    voices = Voices(8)
    rows = [voices.add(number, region, allowed=True) for number, region in ((1, 0), (2, 1), (3, 0), (4, 0), (5, 1))]
    voices.update_rules((1.0, 0.0), (3,), (6.0, 4.0))
    for row in rows[:4]:
        voices.mode[row], voices.touching[row], voices.message_time[row] = ATTRACT, True, 10.0
    voices.share[rows[3]] = 0.0  # of a crowded group

    def states(now=10.1, turn=-1, answers=True):
        return [Hearing(state).name for state in voices.hearing(now, [rows[0]], turn=turn, answers=answers)[rows]]

    assert states() == ["SEEN", "NO_VOICE", "HEARD", "NO_VOICE", "SILENT"]
    assert states(turn=0) == ["SEEN", "WAITS", "HEARD", "NO_VOICE", "SILENT"]
    assert states(answers=False) == ["NO_VOICE"] * 4 + ["SILENT"]
    assert states(now=16.0) == ["SILENT"] * 5
    assert np.all(voices.hearing(10.1, [], turn=-1, answers=True)[len(rows) :] == Hearing.SILENT)


@pytest.mark.long
def test_phone_learns_that_it_is_heard_waits_and_is_silent_again():
    async def test(_gateway, show, address, session):
        show.tell(Rules(order=1, **REGIONS))
        one, other = [await FakePhone(session, address).join(current_key(show), region=region) for region in (0, 1)]
        await one.touch(1, 0.2, 0.5)
        await other.touch(1, 0.8, 0.5)
        await hear_until(one, Hearing.SEEN)
        await hear_until(other, Hearing.SEEN)
        rules = Rules(order=2, regions=REGIONS["regions"], weights=(1.0, 0.0), turn=(0, 0.0, 1e6))
        show.tell(rules)
        await other.touch(1, 0.8, 0.5)
        await hear_until(other, Hearing.WAITS)
        await other.touch(0, 0.0, 0.0)
        await hear_until(other, Hearing.SILENT)
        assert one.said["h"] == Hearing.SEEN  # nothing has changed for it
        show.tell(rules)  # a show that is quiet for 5 s does not answer, and a loaded machine takes that long
        again = await FakePhone(session, address).join(token=one.token)
        await again.touch(1, 0.2, 0.5)
        await hear_until(again, Hearing.SEEN)  # a new connection is told again
        show.tell(Rules(order=3, open=False))
        await hear_until(again, Hearing.SILENT)

    run(test)


def test_phone_of_a_show_that_does_not_answer_is_not_heard():
    async def test(gateway, show, address, session):
        phone = await FakePhone(session, address).join(current_key(show))
        await phone.touch(1, 0.2, 0.5)
        await hear_until(phone, Hearing.SEEN)
        gateway.session.heard_show_at -= 100.0
        await phone.touch(1, 0.2, 0.5)
        await hear_until(phone, Hearing.NO_VOICE)

    run(test)


def test_tally_reaches_all_phones_and_those_that_join_during_the_vote():
    async def test(gateway, show, address, session):
        phones = [await FakePhone(session, address).join(current_key(show), region=k) for k in range(2)]
        show.tell(Rules(order=1, **REGIONS, vote=(7, "step", ("sway", "spin"), 64.0)))
        await until(lambda: gateway.session.rules.vote)
        for phone in phones:
            await phone.ws.send_bytes(bytes((3, 7, 1)))
        for phone in phones:
            while phone.said.get("n") != [7, 0, 200]:
                await phone.hear()
        late = await FakePhone(session, address).join(current_key(show))
        while late.said.get("n") != [7, 0, 200]:
            await late.hear()
        show.tell(Rules(order=2, **REGIONS, won=(7, "spin")))
        while phones[0].said["s"]["won"] != [7, "spin"]:
            await phones[0].hear()
        await until(lambda: gateway.session.tally == ())

    run(test)


def test_invitation_lets_in_while_the_show_runs_until_it_is_renewed():
    async def test(gateway, show, address, session):
        show.tell(Rules(order=1, **REGIONS, invitation=3))
        await until(lambda: gateway.session.rules.invitation == 3)
        phone = await FakePhone(session, address).join(invitation_key(SECRET, 3))
        assert phone.number == 1
        again = await FakePhone(session, address).join(token=phone.token)
        assert again.number == phone.number
        show.tell(Rules(order=2, **REGIONS, invitation=4))
        await until(lambda: gateway.session.rules.invitation == 4)
        for key in (invitation_key(SECRET, 3), invitation_key(b"x" * 32, 4), "i.", "i." + ticket_key(SECRET, 0)):
            assert (await FakePhone(session, address).join(key)).no == "link"
        assert gateway.session.refused[RefusalReason.LINK] == 4
        assert (await FakePhone(session, address).join(token=phone.token)).number == phone.number  # who is in stays
        assert (await FakePhone(session, address).join(invitation_key(SECRET, 4))).number > phone.number
        while (await again.ws.receive(timeout=20.0)).type is aiohttp.WSMsgType.TEXT:
            pass

    run(test, per_address=9)


def test_invitation_never_expires_but_admits_a_team_and_no_crowd():
    tickets = JoinTickets(SECRET, 30.0, 120.0, 5)
    admission = Admission(Phones(4000, 1), tickets, BEHIND_NAT, 4000, SECRET)
    key, day = invitation_key(SECRET, 1), 86_400.0
    answers = [admission.admit_new(key, "", 1, day) for _ in range(round(INVITED_BURST) + 20)]
    assert [answer.why for answer in answers] == [None] * round(INVITED_BURST) + [RefusalReason.JOINS] * 20
    assert min(answer.wait for answer in answers[-20:]) >= 10.0
    assert {answer.ticket for answer in answers[: round(INVITED_BURST)]} == {tickets.newest(day)}
    hour = sum(admission.admit_new(key, "", 1, day + second).why is None for second in range(3600))
    assert hour <= 3600 * INVITED_RATE + 1
    assert admission.admit_new(ticket_key(SECRET, tickets.newest(day + 3600.0)), "", 1, day + 3600.0).why is None
    tickets.set_invitation(2)
    assert admission.admit_new(key, "", 1, day + 4000.0).why is RefusalReason.LINK
    assert admission.admit_new(invitation_key(SECRET, 2), "", 1, day + 4000.0).why is None
    assert not is_invitation(SECRET, "i.\udcff", 1)


def test_invitation_makes_a_crowd_on_own_wifi_as_codes_do():
    admission = Admission(Phones(4000, 1), JoinTickets(SECRET, 30.0, 120.0, 5), OWN_WIFI, 9, SECRET)
    answers = [admission.admit_new(invitation_key(SECRET, 1), "", 7, 50.0).why for _ in range(6)]
    assert answers == [None] * 4 + [RefusalReason.ADDRESS] * 2
    assert admission.crowded == 1
