"""Fair shares in each kind of network: a hall behind one address, and a laptop with forty addresses among phones."""

import asyncio
import random

import aiohttp
import numpy as np
import pytest

from live.control.audience.admission import CROWD_SECONDS, JOIN_BURST, JOIN_RATE, MAX_RESERVED_WAIT, Admission
from live.control.audience.join_tickets import JoinTickets
from live.control.audience.phone_registry import Phone, Phones
from live.control.audience.rate_limit import RefusalReason
from live.control.audience.session_state import Rules
from tests.control.audience.made_gateway import FakePhone, current_key, open_gateway, until
from tests.fixtures.mostly_long import mostly_long

SECRET = b"s" * 32


def run(test, **plan):
    async def all_of_it():
        async with open_gateway(**plan) as (gateway, show, address):
            await test(gateway, show, address)

    asyncio.run(asyncio.wait_for(all_of_it(), 120.0))


class AdmissionSimulation:
    """Phones that join through an Admission in simulated time and retry when their wait is over."""

    def __init__(self, network, most=4000, devices=4000):
        self.phones = Phones(most, 1)
        self.tickets = JoinTickets(SECRET, 30.0, 120.0, devices)
        self.admission = Admission(self.phones, self.tickets, network, 4, SECRET)
        self.joined = {}
        self.refused = []

    def play(self, arrivals, until=1e9):
        """`arrivals`: (when, name, group); each phone has the code that is valid at its arrival."""
        waiting = sorted((when, name, group, self.tickets.key(when), "") for when, name, group in arrivals)
        while waiting:
            when, name, group, key, voucher = waiting.pop(0)
            if when > until:
                continue
            answer = self.admission.admit_new(key, voucher, group, when)
            if answer.why is None:
                phone = Phone(len(self.joined) + 1, 0, group, None, None, group)
                self.phones.add(phone)
                self.joined[name] = when
            else:
                self.refused.append((name, answer))
                if answer.wait:
                    waiting.append((when + answer.wait, name, group, key, answer.voucher or voucher))
                    waiting.sort()


def test_two_hundred_phones_behind_one_address_join_with_full_voices():
    hall = AdmissionSimulation("behind nat")
    hall.play([(1000.0 + 0.001 * k, k, 7) for k in range(200)])
    assert len(hall.joined) == 200
    assert max(hall.joined.values()) - 1000.0 < 12.0
    assert max(sum(name == k for name, _ in hall.refused) for k in range(200)) <= 2  # each knows her turn at once
    assert {hall.admission.voice_share(phone, 1020.0) for phone in hall.phones.by_number.values()} == {1.0}


@pytest.mark.long
def test_join_flood_behind_nat_delays_phones_only_briefly():
    hall = AdmissionSimulation("behind nat")
    laptop = [(1000.0 + 0.001 * k, ("laptop", k), 7) for k in range(640)]
    people = [(1002.0 + 0.1 * k, ("phone", k), 7) for k in range(40)]
    hall.play(laptop + people)
    within = [when - 1000.0 for (who, _), when in hall.joined.items() if who == "phone"]
    assert len(within) == 40
    assert max(within) < 640 / JOIN_RATE + 10.0  # turns are reserved: who asks more often does not come sooner
    many = AdmissionSimulation("behind nat")
    many.play([(1000.0, k, 7) for k in range(4000)], until=1000.0)
    reserved = sum(answer.wait <= MAX_RESERVED_WAIT + 0.5 and bool(answer.voucher) for _, answer in many.refused)
    assert reserved == 4000 - JOIN_BURST
    assert max(answer.wait for _, answer in many.refused) <= MAX_RESERVED_WAIT + 0.5


def test_spent_code_refuses_devices_until_next_code():
    hall = AdmissionSimulation("behind nat", devices=100)
    hall.play([(1000.0, k, 7) for k in range(300)])
    assert len(hall.joined) == 100
    assert sum(answer.why is RefusalReason.SPENT for _, answer in hall.refused) == 200
    hall.play([(1030.0, 300 + k, 7) for k in range(5)])  # the next code
    assert len(hall.joined) == 105


def test_expired_code_admits_few_devices_on_own_wifi():
    hall = AdmissionSimulation("own wifi")
    key = hall.tickets.key(1000.0)  # gone from 1020 on
    minted = sum(hall.admission.admit_new(key, "", 100 + k, 1070.0).why is None for k in range(200))
    assert 0 < minted <= 8


def test_full_hall_reserves_lost_phones_and_admits_by_voucher():
    hall = AdmissionSimulation("own wifi", most=2)
    hall.play([(1000.0, "a", 1), (1000.1, "b", 2), (1000.2, "c", 3)], until=1003.0)
    assert set(hall.joined) == {"a", "b"}
    _, told = hall.refused[0]
    assert told.why is RefusalReason.FULL
    assert 3.0 <= told.wait <= 8.0
    a, b = hall.phones.by_number.values()
    hall.phones.remove(a, 1010.0)  # lost
    assert hall.admission.admit_new("", told.voucher, 3, 1012.0).why is RefusalReason.FULL  # the place is a's ...
    assert hall.admission.admit_known(1, 1012.0).why is None
    hall.phones.add(a)
    b.left_by_itself = True
    hall.phones.remove(b, 1020.0)
    assert hall.admission.admit_new("", told.voucher, 3, 1021.0).why is None  # ... and b's is nobody's
    assert hall.admission.admit_new("", told.voucher, 4, 1021.0).why is RefusalReason.LINK  # the voucher is used


def test_crowded_group_has_no_voice_until_crowd_expires():
    hall = AdmissionSimulation("own wifi")
    hall.play([(1000.0 + k, k, 5) for k in range(4)] + [(1000.0, 99, 6)], until=1010.0)
    phones = hall.phones.in_group(5)
    assert len(phones) == 4
    assert sum(hall.admission.voice_share(phone, 1010.0) for phone in phones) == pytest.approx(1.0)
    hall.play([(1010.0 + k, 10 + k, 5) for k in range(12)], until=1022.0)
    assert [hall.admission.voice_share(phone, 1022.0) for phone in phones] == [0.0] * 4
    assert hall.admission.voice_share(hall.phones.in_group(6)[0], 1022.0) == 1.0
    assert hall.admission.expire_crowds(1022.0 + CROWD_SECONDS) == [5]
    assert sum(hall.admission.voice_share(phone, 1023.0 + CROWD_SECONDS) for phone in phones) == pytest.approx(1.0)


@pytest.mark.long
def test_devices_from_one_origin_group_share_one_voice():
    hall = AdmissionSimulation("own wifi")
    phones = [Phone(1 + k, 0, 100 + k, None, None, 9) for k in range(20)]  # joined by 9, now each elsewhere
    for phone in phones:
        hall.phones.add(phone)
    assert sum(hall.admission.voice_share(phone, 1.0) for phone in phones) == pytest.approx(1.0)
    for k in range(20_000):
        hall.admission.admit_new(hall.tickets.key(5.0), "", k, 5.0)
        hall.admission.admit_new(hall.tickets.key(5.0), "", k // 50, 5.0)
    assert len(hall.admission._joins) <= 16_384
    assert len(hall.admission._crowded) <= 16_384


async def join_crowd(address, show, groups, sockets, where, joined):
    """`sockets` phones at each of the addresses, which drag to a place; returns those that were admitted."""

    async def one(group):
        host = aiohttp.TCPConnector(local_addr=(group, 0), limit=0)
        session = aiohttp.ClientSession(connector=host)
        joined.append(session)
        found = []
        for _ in range(sockets):
            phone = await FakePhone(session, address).join(current_key(show))
            if phone.number:
                await phone.touch(1, *where)
                found.append(phone)
        return found

    return [phone for some in await asyncio.gather(*map(one, groups)) for phone in some]


@pytest.mark.long
def test_laptop_with_forty_addresses_has_no_place_or_force():
    chance = random.Random(21)

    async def test(gateway, show, address):
        sessions = []
        honest = [f"127.0.1.{k + 1}" for k in range(40)]
        laptop = [f"127.0.2.{chance.randrange(1, 6) + 6 * k}" for k in range(40)]
        try:
            people, own = await asyncio.gather(
                join_crowd(address, show, honest, 1, (0.2, 0.5), sessions),
                join_crowd(address, show, laptop, 16, (0.9, 0.5), sessions),
            )
            assert len(people) == 40
            voices, hall = gateway.session.voices, gateway.session
            await until(lambda: show.look().facts.get("crowded") == 40)
            now = hall.now()
            hall.now = lambda: now  # all drag at the same moment, however slow the machine is
            for phone in [*people, *own]:
                await phone.touch(1, *((0.2, 0.5) if phone in people else (0.9, 0.5)))
            spoken = len(people) + len(own)
            await until(lambda: len(voices.pending_touches) + np.count_nonzero(voices.message_time == now) >= spoken)
            voices.apply_touches()
            weights = voices.weights(now)
            of_laptop = np.isin(voices.number, [phone.number for phone in own])
            assert weights[~of_laptop].sum() == pytest.approx(40.0)
            assert weights[of_laptop].sum() < 0.05 * weights.sum()
            force = voices.sketch(now).force()
            assert [round(place.x, 1) for place in force.places] == [-3.6]  # one place: that of the phones
            assert force.share == 1.0  # and the laptop's many do not make the phones few
        finally:
            await asyncio.gather(*(session.close() for session in sessions))

    run(test, most=4000, network="own wifi")


@pytest.mark.long
def test_addresses_of_one_network_card_form_one_group():
    async def test(gateway, show, address):
        async def card_of(found):
            return "card of the laptop" if str(found).startswith("127.0.2.") else ""

        gateway._server._neighbours.card_of = card_of
        sessions = []
        try:
            people = await join_crowd(address, show, [f"127.0.1.{k + 1}" for k in range(8)], 1, (0.2, 0.5), sessions)
            three = await join_crowd(address, show, [f"127.0.2.{k + 1}" for k in range(3)], 1, (0.9, 0.5), sessions)
            assert len(people) == 8
            assert len(three) == 3
            assert total_voice(gateway) == pytest.approx(8.0 + 1.0)
            own = []
            for k in range(37):
                own += await join_crowd(address, show, [f"127.0.2.{k + 4}"], 1, (0.9, 0.5), sessions)
            assert len(own) == 1  # four of one group may play at a time
            assert total_voice(gateway) == pytest.approx(8.0)
        finally:
            await asyncio.gather(*(session.close() for session in sessions))

    run(test, network="own wifi")

    async def unread(gateway, _show, _address):
        assert gateway._server._neighbours is None

    run(unread, network="own wifi", by_card=False)
    run(unread, network="behind nat")


def total_voice(gateway):
    """The sum of all voice shares."""
    return gateway.session.voices.share[gateway.session.voices.number > 0].sum()


@pytest.mark.parametrize("proxied", [True, False])
def test_forwarded_addresses_separate_phones_only_behind_named_proxy(proxied):
    async def test(gateway, show, address):
        async with aiohttp.ClientSession() as session:

            async def join(**headers):
                named = {name.replace("_", "-"): value for name, value in headers.items()}
                return await FakePhone(session, address).join(current_key(show), headers=named)

            phones = [await join(X_Forwarded_For=f"9.9.9.{k}, 203.0.113.{k}") for k in range(2)]
            phones += [await join(Forwarded=f'for="203.0.113.{k}:80"') for k in range(2, 4)]
            assert all(phone.number for phone in phones)
            assert total_voice(gateway) == pytest.approx(4.0 if proxied else 1.0)
            own = [await join(X_Forwarded_For=f"198.51.100.{k}, 203.0.113.200") for k in range(16)]
            assert sum(phone.number > 0 for phone in own) == (4 if proxied else 0)
            assert {phone.no for phone in own if not phone.number} == {"address"}
            assert total_voice(gateway) == pytest.approx(4.0 if proxied else 0.0)  # whoever does that is a crowd

    run(test, network="proxy", proxies=["127.0.0.1" if proxied else "10.0.0.1"])


def test_ipv6_64_and_mapped_ipv4_addresses_share_voices():
    async def test(gateway, show, address):
        async with aiohttp.ClientSession() as session:
            senders = ("2001:db8::1", "2001:db8::ffff:1", "2001:db8:0:1::1", "::ffff:192.0.2.1", "192.0.2.1")
            phones = [
                await FakePhone(session, address).join(current_key(show), headers={"X-Forwarded-For": sender})
                for sender in senders
            ]
            rows = [gateway.session.phones.by_number[phone.number].row for phone in phones]
            assert gateway.session.voices.share[rows].tolist() == [0.5, 0.5, 1.0, 0.5, 0.5]

    run(test, network="proxy", proxies=["127.0.0.1"])


@mostly_long("network", ["own wifi", "behind nat", "proxy"], quick=[1])
def test_ban_covers_rejoined_phones_until_operator_lifts_ban(network):
    async def test(gateway, show, address):
        def header(who, browser="A"):
            sent = {"User-Agent": browser}
            return sent | ({"X-Forwarded-For": who} if network == "proxy" else {})

        async with (
            aiohttp.ClientSession() as session,
            aiohttp.ClientSession(connector=aiohttp.TCPConnector(local_addr=("127.0.7.7", 0))) as elsewhere,
        ):
            hall = gateway.session

            async def heard(phone):
                await phone.touch(1, 0.5, 0.5)
                await until(lambda: hall.voices.touching[hall.phones.by_number[phone.number].row])
                return bool(hall.voices.allowed[hall.phones.by_number[phone.number].row])

            rowdy = await FakePhone(session, address).join(current_key(show), headers=header("203.0.113.1"))
            other = await FakePhone(elsewhere, address).join(current_key(show), headers=header("203.0.113.2"))
            assert await heard(rowdy)
            show.tell(Rules(order=1, banned=(rowdy.number,)))
            await until(lambda: hall.rules.order == 1)
            assert not await heard(rowdy)
            await rowdy.ws.close()
            again = await FakePhone(session, address).join(current_key(show), headers=header("203.0.113.1", "B"))
            assert again.number not in (0, rowdy.number)  # she is let in, and told nothing
            assert not await heard(again)
            back = await FakePhone(elsewhere, address).join(token=again.token, headers=header("203.0.113.9", "C"))
            assert back.number == again.number
            assert not await heard(back)  # with what she was given wherever she is
            stranger = await FakePhone(session, address).join(token=rowdy.token, headers=header("203.0.113.1"))
            assert not await heard(stranger)
            if network != "own wifi":  # there both tests' addresses are now the banned one's
                assert await heard(other)
            await until(lambda: show.look().facts.get("held", {}).get(str(rowdy.number)))
            assert again.number in show.facts["held"][str(rowdy.number)]
            show.tell(Rules(order=2))
            await until(lambda: hall.rules.order == 2)
            assert await heard(stranger)
            assert await heard(back)
            assert hall.bans.covered() == {}

    run(test, network=network, proxies=["127.0.0.1", "127.0.7.7"] if network == "proxy" else [])


def test_ban_behind_nat_covers_only_same_browser_for_minutes():
    async def test(gateway, show, address):
        hall = gateway.session
        async with aiohttp.ClientSession() as session:

            async def join(browser, **how):
                return await FakePhone(session, address).join(headers={"User-Agent": browser}, **how)

            def heard(phone):
                return bool(hall.voices.allowed[hall.phones.by_number[phone.number].row])

            rowdy, neighbour = await join("A", key=current_key(show)), await join("A", key=current_key(show))
            show.tell(Rules(order=1, banned=(rowdy.number,)))
            await until(lambda: hall.rules.order == 1)
            assert heard(neighbour)  # who was there before is somebody else
            hall._origin -= 31.0  # the next code is on the wall
            later = hall.tickets.key(hall.now())
            assert not heard(await join("A", key=later))
            assert heard(await join("B", key=later))
            hall._origin -= 600.0
            assert heard(await join("A", key=hall.tickets.key(hall.now())))
            assert heard(await join("A", token=neighbour.token))

    run(test)


def test_restarted_gateway_keeps_bans():
    told = []

    async def before(gateway, show, address):
        async with aiohttp.ClientSession() as session:
            rowdy = await FakePhone(session, address).join(current_key(show))
            show.tell(Rules(order=1, banned=(rowdy.number,)))
            await until(lambda: show.look().facts.get("bans"))
            told.extend((rowdy.number, show.facts["bans"]))

    async def after(gateway, show, address):
        show.tell(Rules(order=1, banned=(told[0],)))
        await until(lambda: gateway.session.rules.order == 1)
        async with aiohttp.ClientSession() as session:
            again = await FakePhone(session, address).join(current_key(show))
            assert again.number != told[0]
            assert not gateway.session.voices.allowed[gateway.session.phones.by_number[again.number].row]

    run(before, network="own wifi")
    run(after, network="own wifi", bans=told[1], first=500)
