"""Tests of several gateways beside a show: real processes over loopback, and the sudden death of each."""

import asyncio
import os
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import aiohttp
import pytest

from live import __version__
from live.app.launch_options import LaunchOptions
from live.app.services.audience_service import AudienceService
from live.app.services.gateway_shards import part_of
from live.app.services.gateway_status import GatewayStatus
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.base.system.features import LINUX
from live.clock.time_source import SystemClock
from live.control.events import events
from live.show.venue.venue_audience import VenueAudience
from live.supervisor.network.identity import Pairings, load_identity
from tests.app.services.test_audience_service import Stage
from tests.app.services.test_audience_tls import write_certificate
from tests.control.audience.made_gateway import FakePhone, until
from tests.show.made_show import made_show

pytestmark = pytest.mark.skipif(not LINUX, reason="several gateways share a port on Linux alone")


@pytest.fixture(autouse=True)
def own_keys(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path / "show"))


def rows(stage):
    return stage.part.status().get("gateways") or ()


def is_at(stage, x):
    return any(e.source == "audience 1" and e.x == x for e in stage.show.motion.elements.in_force)


async def join_both(stage, session):
    """Phones, so many that each of two gateways has one."""
    await until(lambda: len(rows(stage)) == 2)
    key, phones = stage.part.link.partition("#")[2], []
    while len(phones) < 3 or min(row["phones"] for row in rows(stage)) < 1:
        phones.append(await FakePhone(session, stage.part.address).join(key))
        await until(lambda: sum(row["phones"] for row in rows(stage)) == len(phones))
        assert len(phones) < 24
    return phones


async def is_cut_off(phone):
    try:
        while True:
            message = await asyncio.wait_for(phone.ws.receive(), 0.1)
            if message.type not in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY):
                return True
    except TimeoutError:
        return False


async def return_within(stage, session, phone, seconds, address=""):
    began = stage.clock.now()
    while True:
        assert stage.clock.now() - began < seconds
        try:
            return await FakePhone(session, address or stage.part.address).join(token=phone.token)
        except (aiohttp.ClientError, OSError):
            await asyncio.sleep(0.05)


async def drag_until(stage, phones, x):
    began = stage.clock.now()
    while not is_at(stage, 12.0 * x - 6.0):
        assert stage.clock.now() - began < 20.0
        for phone in phones:
            await phone.touch(1, x, 0.5)
        await asyncio.sleep(0.1)


@pytest.mark.long
def test_phones_of_two_gateways_move_dancers_and_vote_and_outlive_gateway_and_reducer():
    stage = Stage(gateways=2)

    async def vote(phones):
        stage.say(events.AskVote, what="step", first="sway", second="spin")
        for phone in phones:
            while not phone.said.get("s", {}).get("vote"):
                await phone.hear()
            await phone.ws.send_bytes(bytes((3, phone.said["s"]["vote"][0] % 256, 1)))
        total = [0, 100 * len(phones)]
        await until(lambda: list(stage.show.audience.vote.counts) == total)
        while phones[0].said.get("n", [0])[1:] != total:  # phones see the votes of all gateways
            await phones[0].hear()
        stage.say(events.DropVote)

    async def test(session):
        part = stage.part
        phones = await join_both(stage, session)
        assert len({phone.number for phone in phones}) == len(phones)
        await drag_until(stage, phones, 1.0)
        assert stage.show.audience.phones == len(phones)
        await vote(phones)
        os.kill(part.gateway_pids[0], signal.SIGKILL)
        lost = [phone for phone in phones if await is_cut_off(phone)]
        assert 0 < len(lost) < len(phones)
        there = [phone for phone in phones if phone not in lost]
        for phone in lost:
            there.append(await return_within(stage, session, phone, 10.0))
            assert there[-1].number == phone.number
        await until(lambda: sum(row["phones"] for row in rows(stage) if not row["gone"]) == len(phones))
        reducer = part.pid
        os.kill(reducer, signal.SIGKILL)
        await until(lambda: part.pid not in (None, reducer))
        await drag_until(stage, there, 0.0)
        assert not any([await is_cut_off(phone) for phone in there])
        stranger = await FakePhone(session, part.address).join(part.link.partition("#")[2])
        assert stranger.number not in {phone.number for phone in phones}

    asyncio.run(asyncio.wait_for(stage.play(test), 120.0))
    assert stage.show.refusals.count == 0


def start_gateway(folder, port):
    """`live gateway` as on another machine: with keys of its own; returns the process and its port for phones."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        own = free.getsockname()[1]
    words = [f"127.0.0.1:{port}", "--listen", f"127.0.0.1:{own}", "--phones", "50", "--name", "elsewhere"]
    process = subprocess.Popen(
        [sys.executable, "-m", "live", "gateway", *words], env=os.environ | {"LIVE_CONFIG_DIR": str(folder)},
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    return process, own


@pytest.mark.long
def test_gateway_of_a_paired_machine_serves_phones_and_that_of_a_stranger_does_not(tmp_path):
    stage = Stage(gateways=0, gateways_listen=("127.0.0.1", 0))
    here, there = Pairings(tmp_path / "show/network"), tmp_path / "there/network"
    show, other = load_identity(tmp_path / "show/network"), load_identity(there)
    Pairings(there).add("show", show.certificate)

    async def test(session):
        _, port = stage.part._shards.reducer_socket.getsockname()[:2]
        process, phones_at = start_gateway(tmp_path / "there", port)
        try:
            said = await asyncio.to_thread(process.stderr.readline)
            assert "does not know this one" in said
            assert rows(stage) == ()
            here.add("there", other.certificate)  # the show runs on, and hears of it
            await until(lambda: len(rows(stage)) == 1)
            [row] = rows(stage)
            assert row["name"].startswith("elsewhere")
            assert row["most"] == 50
            phone = await FakePhone(session, f"http://127.0.0.1:{phones_at}").join(stage.part.link.partition("#")[2])
            await drag_until(stage, [phone], 1.0)
            told = GatewayStatus(stage.part, None)
            loads = ["gateways: 1, phones: 1", "1 of 50 phones"]
            await until(lambda: [row["load"] for row in told.rows()] == loads)
            known = told.rows()[1]
            assert (known["kind"], known["name"], known["machine"]) == ("gateway", "elsewhere", "there")
            assert (known["state"], known["version"]) == ("serves", __version__)
            told.restart("gateway", "elsewhere", known["process"])
            assert await is_cut_off(phone)
            await until(lambda: any(row["process"] != known["process"] for row in told.rows()[1:]))
            phone = await return_within(stage, session, phone, 10.0, f"http://127.0.0.1:{phones_at}")
            assert process.poll() is None  # the same process, with another program in it
            process.send_signal(signal.SIGTERM)
            assert await asyncio.to_thread(process.wait, 20.0) == 0
            assert await is_cut_off(phone)
            await until(lambda: all(row["gone"] for row in rows(stage)))
        finally:
            process.kill()
            process.communicate()

    asyncio.run(asyncio.wait_for(stage.play(test), 90.0))


def test_orders_start_gateway_and_reducer_again_and_the_supervisor_is_told():
    stage = Stage(gateways=2)
    link = MadeLink()
    told = GatewayStatus(stage.part, link)

    def kinds():
        return {(row["kind"], row["name"]): row for row in told.rows() if row["state"] == "serves"}

    async def test(_session):
        await until(lambda: len(kinds()) == 3)
        told.frame(1.0)
        (message,) = link.sent
        assert message["alive"] == "gateways"
        assert [(row["kind"], row["name"], row["machine"]) for row in message["rows"]] == [
            ("reducer", "reducer", ""), ("gateway", "here 1", ""), ("gateway", "here 2", ""),
        ]  # fmt: skip
        for kind, name in (("gateway", "here 2"), ("reducer", "reducer")):
            before = kinds()
            for process in ("of another", before[kind, name]["process"]):
                link.requests.append({"alive": "restart", "kind": kind, "name": name, "process": process})
            told.frame(1.5)
            await until(lambda kind=kind, name=name, before=before: len(kinds()) == 3
                        and kinds()[kind, name]["process"] != before[kind, name]["process"])  # fmt: skip
            assert kinds()["gateway", "here 1"]["process"] == before["gateway", "here 1"]["process"]
        refused = {**told.rows()[1], "name": "old", "state": "refused", "why": "of version 9", "machine": "stage-pc"}
        told._tell_refused([refused])
        told._tell_refused([refused])
        assert link.notes == ["gateway old of stage-pc is refused: of version 9"]

    asyncio.run(asyncio.wait_for(stage.play(test), 120.0))


class MadeLink:
    """The engine's end of its link to the supervisor."""

    def __init__(self):
        self.sent, self.notes, self.requests, self.channel = [], [], [], self

    def send_json(self, **told):
        self.sent.append(told)

    def send_note(self, words):
        self.notes.append(words)

    def pop_request(self, name):
        return self.requests.pop(0) if self.requests else None


def proxy_config(folder, port, gateways):
    """The configuration of the manual, for this machine."""
    page = (Path(__file__).parents[3] / "docs/how-to/hall/stadium.md").read_text("utf-8")
    text = page.partition("```text\n")[2].partition("```")[0]
    owner = () if os.geteuid() == 0 else ("  user ", "  group ")  # only root can become another
    lines = [line for line in text.splitlines() if not line.startswith(("  server ", *owner))]
    lines += [f"  server gateway{k} 127.0.0.1:{at}" for k, at in enumerate(gateways)]
    text = "\n".join(lines).replace("bind :443", f"bind 127.0.0.1:{port}").replace("maxconn 130000", "maxconn 500")
    certificate, key = write_certificate(folder)
    (folder / "play.pem").write_bytes(certificate.read_bytes() + key.read_bytes())
    config = folder / "haproxy.cfg"
    config.write_text(text.replace("/etc/haproxy/play.pem", str(folder / "play.pem")) + "\n")
    return config


@pytest.mark.long
@pytest.mark.skipif(shutil.which("haproxy") is None, reason="needs haproxy: apt-get install haproxy")
def test_phones_come_through_the_proxy_of_the_manual_and_move_when_a_gateway_dies(tmp_path):
    stage = Stage(gateways=0, gateways_listen=("127.0.0.1", 0), audience_link="https://play.example")
    stage.part._venue = VenueAudience(network="proxy", proxies=("127.0.0.1",))
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]

    async def test(_session):
        _, joins = stage.part._shards.reducer_socket.getsockname()[:2]
        started = [start_gateway(tmp_path / "show", joins) for _ in range(2)]
        config = proxy_config(tmp_path, port, [at for _, at in started])
        await until(lambda: len(rows(stage)) == 2)
        proxy = subprocess.Popen(["haproxy", "-db", "-f", str(config)], stderr=subprocess.DEVNULL)
        sessions, phones = [], []
        try:
            for k in range(6):
                host = aiohttp.TCPConnector(local_addr=(f"127.0.3.{k + 1}", 0), ssl=False)
                sessions.append(aiohttp.ClientSession(connector=host))
                phones.append(await join_soon(stage, sessions[-1], f"https://127.0.0.1:{port}"))
            await until(lambda: [row["phones"] for row in rows(stage)] == [3, 3])  # leastconn
            await until(lambda: stage.part.status()["voices"] == 6.0)  # addresses as the proxy forwards them
            await drag_until(stage, phones, 1.0)
            started[0][0].kill()
            lost = [k for k, phone in enumerate(phones) if await is_cut_off(phone)]
            assert len(lost) == 3
            died = stage.clock.now()
            for k in lost:
                phones[k] = await join_soon(stage, sessions[k], f"https://127.0.0.1:{port}", token=phones[k].token)
            assert stage.clock.now() - died < 10.0
            await until(lambda: [row["phones"] for row in rows(stage) if not row["gone"]] == [6])
        finally:
            await asyncio.gather(*(session.close() for session in sessions))
            for process in (proxy, *(process for process, _ in started)):
                process.kill()
                process.communicate()

    asyncio.run(asyncio.wait_for(stage.play(test), 120.0))


async def join_soon(stage, session, address, token=None):
    began = stage.clock.now()
    while True:
        assert stage.clock.now() - began < 20.0
        try:
            key = None if token else stage.part.link.partition("#")[2]
            return await FakePhone(session, address).join(key, token=token)
        except (aiohttp.ClientError, ConnectionError, OSError):
            await asyncio.sleep(0.1)


def test_gateways_have_room_for_those_of_one_that_dies():
    assert part_of(4000, 1) == part_of(4000, 2) == 4000
    for count in (3, 5, 16):
        assert (count - 1) * part_of(4000, count) >= 4000
        assert part_of(4000, count) >= 1.25 * 4000 / count
    made = made_show(), EventQueue().add_queue(), SystemClock()
    nobody = AudienceService(LaunchOptions(audience=("127.0.0.1", 0), gateways=0, audience_secret=b"x"), *made)
    with pytest.raises(PersonError, match="nobody serves the phones"):
        nobody.start()
