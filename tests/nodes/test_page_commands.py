"""The operator's page of a show on other machines, before and after another one takes over; a standby starts again."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import aiohttp
import psutil
import pytest

from live.base.system.features import LINUX
from tests.control.waiting import wait_for
from tests.nodes.test_commands import SHOW
from tests.supervisor.made_machines import free_port, pair_folders

pytest.importorskip("zenoh", reason="Eclipse Zenoh is not installed: pip install 'choreographics-live[nodes]'")
pytestmark = [pytest.mark.long, pytest.mark.skipif(not LINUX, reason="other systems have one loopback address")]

KEY = "the-key-of-stage-left"


class Machines:
    """Two machines that are paired: processes with config folders and loopback addresses of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.show = folder, folder / "show.toml"
        self.show.write_text(SHOW)
        self.lead, self.bus = free_port(), free_port()
        self.pages = {name: free_port() for name in ("first", "second", "node")}
        self.processes = dict[str, subprocess.Popen[bytes]]()
        for name in ("first", "second"):
            (folder / name).mkdir()
        pair_folders(folder / "first", folder / "second")

    def start(self, name: str, config: str, *words: str, **env: str) -> None:
        with (self.folder / f"{name}.out").open("wb") as said:
            self.processes[name] = subprocess.Popen(
                [sys.executable, "-m", "live", *words], stdout=said, stderr=said, start_new_session=True,
                env={**os.environ, "LIVE_CONFIG_DIR": str(self.folder / config), **env},
            )  # fmt: skip

    def play(self, name: str, host: str, *words: str, **env: str) -> None:
        page = f"{host}:{self.pages[name]}"
        common = ("--headless", "--bpm", "120", "--osc", f"{host}:{free_port()}", "--nodes", f"{host}:{self.bus}")
        self.start(name, name, "play", str(self.show), *common, "--web", page, *words, **env)

    def said(self, name: str) -> str:
        return (self.folder / f"{name}.out").read_text()

    def cluster(self, host: str, *words: str) -> "subprocess.CompletedProcess[str]":
        command = [sys.executable, "-m", "live", "cluster", *words, "--leader", f"{host}:{self.bus}"]
        env = {**os.environ, "LIVE_CONFIG_DIR": str(self.folder / "first")}
        return subprocess.run(command, capture_output=True, text=True, env=env, check=False, timeout=120)

    def standby(self) -> dict[str, object]:
        told = self.cluster("127.0.0.1", "status", "--json").stdout
        return next(iter(json.loads(told)["standbys"] if told else []), {})

    def kill(self, name: str) -> None:
        process = psutil.Process(self.processes[name].pid)
        for one in (process, *process.children(recursive=True)):
            one.kill()

    def stop(self) -> None:
        for process in list(self.processes.values())[::-1]:
            children = psutil.Process(process.pid).children(recursive=True) if process.poll() is None else []
            process.send_signal(signal.SIGINT)
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            for child in children:
                if child.is_running():
                    child.kill()


@pytest.fixture
def machines(tmp_path):
    made = Machines(tmp_path)
    try:
        yield made
    finally:
        made.stop()


async def status_of(url: str, **headers: str) -> int:
    async with aiohttp.ClientSession() as session:
        try:
            async with session.get(url, headers=headers) as answer:
                await answer.read()
                return answer.status
        except aiohttp.ClientError:
            return 0


def answers(url: str, wanted: int, seconds: float = 30.0, **headers: str) -> bool:
    return wait_for(lambda: asyncio.run(status_of(url, **headers)) == wanted, seconds)


async def command(page: str, address: str, value: float) -> bool:
    """Send a control from a page; return whether the page is told its new value."""
    protocols = ("live.operator", f"live.key.{KEY}")
    async with aiohttp.ClientSession() as session, session.ws_connect(f"{page}/ws", protocols=protocols) as socket:
        await socket.send_str(json.dumps({"address": address, "values": [value]}))
        end = time.monotonic() + 20.0
        while time.monotonic() < end:
            told = json.loads((await socket.receive(20.0)).data)
            assert "refused" not in told
            if told.get("values", {}).get(address) == [value]:
                return True
    return False


def test_page_is_at_the_same_addresses_whichever_machine_leads(machines):
    key = {"Authorization": f"Bearer {KEY}"}
    machines.play("first", "127.0.0.1", "--lead", f"127.0.0.1:{machines.lead}", LIVE_WEB_KEY=KEY)
    words = ("--name", "left", "--headless", "--patch", str(machines.show), "--web", str(machines.pages["node"]))
    machines.start("node", "second", "node", *(f"127.0.0.{k}:{machines.bus}" for k in (1, 2)), *words)
    pages = {name: f"http://127.0.0.1:{port}" for name, port in machines.pages.items()}
    pages["second"] = f"http://127.0.0.2:{machines.pages['second']}"
    assert answers(pages["node"], 200, 90.0), machines.said("first") + machines.said("node")
    machines.play("second", "127.0.0.2", "--standby", f"127.0.0.1:{machines.lead}")
    assert answers(pages["second"], 200, 90.0), machines.said("second")
    for name in ("node", "second"):
        assert answers(f"{pages[name]}/surface.json", 401)
        assert answers(f"{pages[name]}/surface.json", 200, **key)
        assert answers(f"{pages[name]}/", 403, Host="evil.example")
        assert answers(f"{pages[name]}/", 403, Origin="http://evil.example")
    forged = {"Host": f"evil.example:{machines.pages['first']}", "X-Live-Relay": "x" * 64}
    assert answers(f"{pages['first']}/", 403, **forged)
    assert asyncio.run(command(pages["node"], "/dance/blackout", 1))
    assert wait_for(lambda: machines.standby().get("state") == "ready", 60.0), machines.said("second")
    before = machines.standby()
    done = machines.cluster("127.0.0.1", "restart", "second")
    assert done.stdout == "second is back\n", done.stderr + machines.said("second")
    assert machines.standby()["process"] != before["process"]
    machines.kill("first")
    assert answers(f"{pages['second']}/surface.json", 200, **key), machines.said("second")
    assert answers(f"{pages['node']}/surface.json", 200, **key), machines.said("node")
    assert asyncio.run(command(pages["node"], "/dance/blackout", 0))
