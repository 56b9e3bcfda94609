"""OSCQuery: the tree says of every control what the registry says, and the process answers as the proposal asks."""

import asyncio
import json
import os
import shutil
import subprocess
import sys

import pytest
from pythonosc.osc_packet import OscPacket

from live.clock.source import SystemClock
from live.control.oscquery import ATTRIBUTES, Namespace, host_info, told_of
from live.control.readings import READINGS
from live.control.registry import REGISTRY
from live.control.rejections import Rejection
from live.control.values import Values
from tests.control.waiting import wait_for

LIGHT, LARGER, MIRRORED = "/dance/light/key", "/dance/motion/larger", "/dance/mocap/mirrored"

NONSENSE = ("{", "[]", '{"COMMAND": "LISTEN"}', '{"COMMAND": "LISTEN", "DATA": "/nothing"}', "[" * 900)


def nodes(node):
    yield node
    for below in node.get("CONTENTS", {}).values():
        yield from nodes(below)


def test_every_control_and_figure_is_in_the_tree_with_what_the_registry_says():
    values = Values()
    values.take({LIGHT: (("", (1.5,)),), LARGER: (("a", (0.25,)), ("b", (0.5,))), "/dance/hold": (("", (True,)),)})
    tree = Namespace(values).node("/")
    found = {node["FULL_PATH"]: node for node in nodes(tree)}
    assert {path for path, node in found.items() if node["ACCESS"]} == {
        *(control.address for control in REGISTRY), *(reading.address for reading in READINGS)
    }  # fmt: skip
    for node in found.values():
        assert set(node) <= set(ATTRIBUTES)
        for name in ("RANGE", "UNIT", "VALUE", "CLIPMODE"):
            assert name not in node or len(node[name]) == len(node["TYPE"])
    for control in REGISTRY:
        node, arguments = found[control.address], told_of(control)
        assert node["DESCRIPTION"] == control.description
        assert node["ACCESS"] == (3 if control.value else 2)
        for argument, allowed in zip(arguments, node.get("RANGE", []), strict=True):
            if argument.type == "float":
                assert allowed == {"MIN": argument.minimum, "MAX": argument.maximum}
        # what a program sends that knows only this acts: the middle of each range, or a text
        sent = [{"float": (a.minimum + a.maximum) / 2, "bool": True}.get(a.type, "x") for a in arguments] or [None]
        assert not isinstance(control.call(sent, 0.0, "test"), Rejection), control.address
    assert found[LIGHT]["VALUE"] == [1.5]
    assert found[LARGER]["VALUE"] == [0.25]
    assert (found["/dance/hold"]["TYPE"], found["/dance/hold"]["VALUE"]) == ("T", [True])
    assert found["/dance/attract"]["TYPE"] == "ff"
    assert found["/dance/panic"] == found["/dance/panic"] | {"TYPE": "I", "ACCESS": 2, "CRITICAL": True}
    assert "VALUE" not in found["/dance/blackout"]


def test_one_attribute_and_who_answers():
    values = Values()
    values.take({LIGHT: (("", (1.5,)),)})
    tree = Namespace(values)
    assert tree.attribute(LIGHT, "VALUE") == {"VALUE": [1.5]}
    assert tree.attribute(LIGHT, "CRITICAL") is None
    with pytest.raises(KeyError):
        tree.attribute(LIGHT, "NONSENSE")
    with pytest.raises(KeyError):
        tree.node("/nothing")
    assert host_info("x", ("127.0.0.1", 1), ("0.0.0.0", 2)) == {
        "NAME": "x", "OSC_IP": "127.0.0.1", "OSC_PORT": 1, "OSC_TRANSPORT": "UDP", "WS_PORT": 2,
        "EXTENSIONS": host_info("x", ("", 1), ("", 2))["EXTENSIONS"],
    }  # fmt: skip


def test_programs_ask_and_listen_and_pages_of_other_sites_may_not():
    aiohttp = pytest.importorskip("aiohttp")
    pytest.importorskip("zeroconf")
    from live.cli.oscquery_part import OscQueryPart

    part = OscQueryPart(("127.0.0.1", 0), ("127.0.0.1", 9010), "Live test", SystemClock())
    part.tell({LIGHT: (("", (1.5,)),), LARGER: (("a", (0.25,)), ("b", (0.5,)))})
    part.tell({MIRRORED: (("anna", (True,)), ("ben", (False,)))})

    async def ask(client, path, status=200, **headers):
        async with client.get(f"http://127.0.0.1:{part.port}{path}", headers=headers) as answer:
            assert answer.status == status, (path, answer.status)
            return json.loads(await answer.text()) if status == 200 else None

    async def heard(ws):
        message = await ws.receive(timeout=20.0)
        return [(m.message.address, *m.message.params) for m in OscPacket(message.data).messages]

    async def everything():
        async with aiohttp.ClientSession() as client:
            while "anna" not in (await ask(client, "/dance/mocap"))["CONTENTS"]:
                part.frame()
                await asyncio.sleep(0.01)
            assert (await ask(client, "/?HOST_INFO"))["OSC_PORT"] == 9010
            assert await ask(client, f"{LIGHT}?VALUE") == {"VALUE": [1.5]}
            await ask(client, f"{LIGHT}?CRITICAL", 204)
            await ask(client, f"{LIGHT}?NONSENSE", 400)
            await ask(client, "/../../etc/passwd", 404)
            await ask(client, "/", 403, Origin="http://evil.example")
            await ask(client, "/", 403, Host="evil.example")
            async with client.ws_connect(f"http://127.0.0.1:{part.port}/") as ws:
                for nonsense in (
                    "{",
                    "[]",
                    '{"COMMAND": "LISTEN"}',
                    '{"COMMAND": "LISTEN", "DATA": "/nothing"}',
                    '{"COMMAND": "LISTEN", "DATA": "/dance/mocap/nobody/mirrored"}',
                    "[" * 900,
                ):
                    await ws.send_str(nonsense)
                for path in (LIGHT, LARGER):
                    await ws.send_str(json.dumps({"COMMAND": "LISTEN", "DATA": path}))
                told = await heard(ws)
                if len(told) == 1:
                    told += await heard(ws)
                assert told == [(LIGHT, 1.5), (LARGER, 0.25, "a"), (LARGER, 0.5, "b")]
                part.tell({LIGHT: (("", (1.5,)),)})  # no other value
                part.frame()
                await asyncio.sleep(0.1)
                part.tell({LIGHT: (("", (0.5,)),)})
                part.frame()
                assert await heard(ws) == [(LIGHT, 0.5)]
                await ws.send_str(json.dumps({"COMMAND": "LISTEN", "DATA": "/dance/mocap/ben/mirrored"}))
                assert await heard(ws) == [("/dance/mocap/ben/mirrored", False)]
                part.tell({MIRRORED: (("anna", (False,)), ("ben", (True,)))})
                part.frame()
                assert await heard(ws) == [("/dance/mocap/ben/mirrored", True)]
                await ws.send_str("x" * 5000)
                assert (await ws.receive(timeout=20.0)).type is aiohttp.WSMsgType.CLOSE
            assert wait_for(lambda: part.frame() or part.status().get("refused", 0) >= 8, 10.0)

    part.start()
    try:
        asyncio.run(asyncio.wait_for(everything(), 60.0))
    finally:
        part.stop()


BROWSE = """
import sys, time, threading
from zeroconf import ServiceBrowser, Zeroconf
from live.cli.oscquery_part import OscQueryPart
from live.clock.source import SystemClock
part = OscQueryPart(("127.0.0.1", 0), ("127.0.0.1", 9010), "Live test", SystemClock())
part.start()
found, all_there = {}, threading.Event()
class Listener:
    def add_service(self, zc, kind, name):
        found[kind] = zc.get_service_info(kind, name)
        if len(found) == 2: all_there.set()
    update_service = remove_service = lambda *_: None
zc = Zeroconf(interfaces=["127.0.0.1"])
browser = ServiceBrowser(zc, ["_oscjson._tcp.local.", "_osc._udp.local."], Listener())
assert all_there.wait(40.0), found
assert found["_oscjson._tcp.local."].port == part.port
assert found["_osc._udp.local."].port == 9010
assert found["_oscjson._tcp.local."].parsed_addresses() == ["127.0.0.1"]
assert found["_oscjson._tcp.local."].name.startswith("Live test.")
zc.close(); part.stop(); print("found")
"""


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0 or not shutil.which("unshare"), reason="needs a namespace")
def test_programs_find_it_by_zeroconf_in_a_network_of_its_own():
    pytest.importorskip("aiohttp")
    pytest.importorskip("zeroconf")
    script = 'ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec "$0" -c "$1"'
    command = ["unshare", "-n", "sh", "-c", script, sys.executable, BROWSE]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120.0)
    if "unshare" in done.stderr:
        pytest.skip(done.stderr.strip())
    assert done.stdout.strip() == "found", done.stderr
