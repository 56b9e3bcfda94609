"""Tests of OSCQuery: the tree matches the registry, and the process answers as the proposal requires."""

import asyncio
import json
import os
import shutil
import socket
import subprocess
import sys

import pytest
from pythonosc.osc_packet import OscPacket

from live.bridges.oscquery.oscquery_server import MAX_CLIENTS_PER_GROUP
from live.bridges.oscquery.oscquery_tree import ATTRIBUTES, Namespace, host_info, listed_arguments
from live.clock.time_source import SystemClock
from live.control.osc.osc_codec import encode
from live.control.registry.registry import READINGS, REGISTRY, Values
from live.control.registry.rejections import Rejection
from tests.control.waiting import wait_for

LIGHT, LARGER, MIRRORED = "/dance/light/key", "/dance/motion/larger", "/dance/mocap/mirrored"

NONSENSE = ("{", "[]", '{"COMMAND": "LISTEN"}', '{"COMMAND": "LISTEN", "DATA": "/nothing"}', "[" * 900)


def walk_nodes(node):
    yield node
    for below in node.get("CONTENTS", {}).values():
        yield from walk_nodes(below)


def test_tree_contains_all_controls_and_readings():
    values = Values()
    values.update({LIGHT: (("", (1.5,)),), LARGER: (("a", (0.25,)), ("b", (0.5,))), "/dance/hold": (("", (True,)),)})
    tree = Namespace(values).node("/")
    found = {node["FULL_PATH"]: node for node in walk_nodes(tree)}
    assert {path for path, node in found.items() if node["ACCESS"]} == {
        *(control.address for control in REGISTRY), *(reading.address for reading in READINGS)
    }  # fmt: skip
    for node in found.values():
        assert set(node) <= set(ATTRIBUTES)
        for name in ("RANGE", "UNIT", "VALUE", "CLIPMODE"):
            assert name not in node or len(node[name]) == len(node["TYPE"])
    for control in REGISTRY:
        node, arguments = found[control.address], listed_arguments(control)
        assert node["DESCRIPTION"] == control.description
        assert node["ACCESS"] == (3 if control.value else 2)
        for argument, allowed in zip(arguments, node.get("RANGE", []), strict=True):
            if argument.type == "float":
                assert allowed == {"MIN": argument.minimum, "MAX": argument.maximum}
        # what a program sends that knows only this acts: the middle of each range, or a text
        text = "1 2, 3 4" if any(argument.form for argument in arguments) else "x"
        if arguments and arguments[0].form.startswith("one of "):
            text = arguments[0].form.removeprefix("one of ").partition(",")[0]
        sent = [{"float": (a.minimum + a.maximum) / 2, "bool": True}.get(a.type, text) for a in arguments] or [None]
        assert not isinstance(control.call(sent, 0.0, "test"), Rejection), control.address
    assert found[LIGHT]["VALUE"] == [1.5]
    assert found[LARGER]["VALUE"] == [0.25]
    assert (found["/dance/hold"]["TYPE"], found["/dance/hold"]["VALUE"]) == ("T", [True])
    assert found["/dance/attract"]["TYPE"] == "ff"
    assert found["/dance/panic"] == found["/dance/panic"] | {"TYPE": "I", "ACCESS": 2, "CRITICAL": True}
    assert "VALUE" not in found["/dance/blackout"]


def test_single_attribute_and_host_info_are_returned():
    values = Values()
    values.update({LIGHT: (("", (1.5,)),)})
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


def test_tree_contains_all_named_performers():
    attract = "/dance/mocap/attract"
    values = Values()
    tree = Namespace(values)
    assert not tree.has("/dance/mocap/anna/mirrored")
    assert "VALUE" not in tree.node(MIRRORED)
    values.update({
        MIRRORED: (("anna", (True,)), ("ben", (False,))),
        "/dance/mocap/place": (("anna", (1.0, -2.0, 0.0, 1.0)), ("ben", (0.0, 0.0, 90.0, 1.0))),
        attract: (("anna", (0.5, "*")), ("ben", (0.0, "ember"))),
    })  # fmt: skip
    for name, value in (("anna", True), ("ben", False)):
        node = tree.node(f"/dance/mocap/{name}/mirrored")
        assert (node["TYPE"], node["VALUE"], node["ACCESS"]) == ("T" if value else "F", [value], 3)
    assert tree.attribute("/dance/mocap/anna/attract", "RANGE") == {"RANGE": [{"MIN": -10, "MAX": 10}, {}]}
    assert (tree.node(attract)["TYPE"], tree.node(attract)["VALUE"]) == ("sfs", ["anna", 0.5, "*"])
    assert set(tree.node("/dance/mocap/ben")["CONTENTS"]) == {"mirrored", "place", "attract"}


@pytest.mark.long
def test_programs_query_and_listen_but_foreign_sites_are_refused():
    aiohttp = pytest.importorskip("aiohttp")
    pytest.importorskip("zeroconf")
    from live.bridges.oscquery.oscquery_service import OscQueryService

    show = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    show.bind(("127.0.0.1", 0))
    show.setblocking(False)
    part = OscQueryService(("127.0.0.1", 0), show.getsockname(), "Live test", SystemClock(), hosts=["show.example:443"])
    part.publish({LIGHT: (("", (1.5,)),), LARGER: (("a", (0.25,)), ("b", (0.5,)))})
    part.publish({MIRRORED: (("anna", (True,)), ("ben", (False,)))})

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
            assert (await ask(client, "/?HOST_INFO"))["OSC_PORT"] == show.getsockname()[1]
            assert await ask(client, f"{LIGHT}?VALUE") == {"VALUE": [1.5]}
            await ask(client, f"{LIGHT}?CRITICAL", 204)
            await ask(client, f"{LIGHT}?NONSENSE", 400)
            await ask(client, "/../../etc/passwd", 404)
            await ask(client, "/", 403, Origin="http://evil.example")
            for name in (
                "evil.example",
                "evil.local",
                f"evil.local:{part.port}",
                f"live-{part.port}.local:{part.port}",
            ):
                await ask(client, "/", 403, Host=name)
            for name in ("show.example", f"localhost:{part.port}"):
                await ask(client, "/", 200, Host=name)
            async with client.put(f"http://127.0.0.1:{part.port}{LIGHT}") as answer:
                assert answer.status == 405
            async with client.post(f"http://127.0.0.1:{part.port}{LIGHT}", data=b"5") as answer:
                assert answer.status == 413
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
                part.publish({LIGHT: (("", (1.5,)),)})  # no other value
                part.frame()
                await asyncio.sleep(0.1)
                part.publish({LIGHT: (("", (0.5,)),)})
                part.frame()
                assert await heard(ws) == [(LIGHT, 0.5)]
                await ws.send_str(json.dumps({"COMMAND": "LISTEN", "DATA": "/dance/mocap/ben/mirrored"}))
                assert await heard(ws) == [("/dance/mocap/ben/mirrored", False)]
                part.publish({MIRRORED: (("anna", (False,)), ("ben", (True,)))})
                part.frame()
                assert await heard(ws) == [("/dance/mocap/ben/mirrored", True)]
                await ws.send_bytes(encode("/dance/blackout", (1.0,)))  # what OSC would do is not done here
                await ws.send_str(json.dumps({"COMMAND": "SET", "DATA": "/dance/blackout"}))
                await ws.send_str("x" * 5000)
                assert (await ws.receive(timeout=20.0)).type is aiohttp.WSMsgType.CLOSE
            assert wait_for(lambda: part.frame() or part.status().get("refused", 0) >= 14, 10.0)
            with pytest.raises(BlockingIOError):
                show.recv(1)
            many = [await client.ws_connect(f"http://127.0.0.1:{part.port}/") for _ in range(MAX_CLIENTS_PER_GROUP)]
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await client.ws_connect(f"http://127.0.0.1:{part.port}/")
            await many.pop().close()
            many.append(await client.ws_connect(f"http://127.0.0.1:{part.port}/"))
            for ws in many:
                await ws.close()

    part.start()
    try:
        asyncio.run(asyncio.wait_for(everything(), 60.0))
    finally:
        part.stop()
        show.close()


NETWORK = """
ip link set lo up && ip link set lo multicast on
ip link add hall type veth peer name hall_far && ip link add foyer type veth peer name foyer_far
for each in hall hall_far foyer foyer_far; do ip link set $each up; done
ip addr add 10.71.0.1/24 dev hall && ip addr add 10.72.0.1/24 dev foyer
ip addr add fd71::1/64 dev hall nodad
ip route add 224.0.0.0/4 dev lo
exec "$0" -c "$1"
"""
"""Loopback and two networks, seen by nobody else."""

BROWSE = """
import pathlib, socket, struct, threading
from zeroconf import ServiceBrowser, Zeroconf
from live.bridges.oscquery.oscquery_service import OscQueryService
from live.clock.time_source import SystemClock
from tests.control.waiting import wait_for

KINDS = ["_oscjson._tcp.local.", "_osc._udp.local."]
# what one machine of each network hears that has asked for the services: all that goes out on its interface
taps = {}
for name in ("lo", "hall", "foyer"):
    taps[name] = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
    taps[name].bind((name, 3))
    taps[name].setblocking(False)

def heard(name):
    found = False
    groups = [socket.inet_aton("224.0.0.251"), socket.inet_pton(socket.AF_INET6, "ff02::fb")]
    try:
        while True:
            data = taps[name].recv(70000)
            found |= b"_oscjson" in data and any(group in data for group in groups)
    except BlockingIOError:
        return found

def bound():
    # addresses of the mDNS port, as the kernel says
    found = set()
    for file, size in (("udp", 8), ("udp6", 32)):
        for line in pathlib.Path(f"/proc/net/{file}").read_text().splitlines()[1:]:
            address, port = line.split()[1].split(":")
            if int(port, 16) == 5353:
                raw = b"".join(bytes.fromhex(address[n:n+8])[::-1] for n in range(0, size, 8))
                found.add(socket.inet_ntop(socket.AF_INET if size == 8 else socket.AF_INET6, raw))
    return found

def asked(source):
    # a query over the network of `source` to the address of the other: nobody may answer from there
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        asking.bind((source, 0))
        asking.settimeout(0.5)
        query = struct.pack("!6H", 7, 0, 1, 0, 0, 0)
        query += b"\\x08_oscjson\\x04_tcp\\x05local\\0" + struct.pack("!2H", 12, 1)
        asking.sendto(query, (source, 5353))
        try:
            return asking.recv(9000)
        except (TimeoutError, ConnectionError):
            return b""

def announced(host, networks):
    for name in taps:
        heard(name)  # what is left of the one before
    part = OscQueryService((host, 0), (host, 9010), "Live test", SystemClock())
    part.start()
    try:
        there = set()
        def all_there():
            part.frame()
            there.update(name for name in taps if heard(name))
            return part.status().get("at") is not None and networks <= there  # both services are announced by then
        assert wait_for(all_there, 40.0), (host, there, part.status())
        assert part.status()["problem"] == "", part.status()
        return part, bound(), there
    except BaseException:
        part.stop()
        raise

for host, networks, sockets in (
    ("127.0.0.1", {"lo"}, {"127.0.0.1", "224.0.0.251"}),
    ("10.71.0.1", {"hall"}, {"10.71.0.1", "224.0.0.251"}),
    ("fd71::1", {"hall"}, {"fd71::1", "ff02::fb"}),
):
    part, found, there = announced(host, networks)
    try:
        assert found == sockets, (host, found)
        assert there == networks, (host, there)
        for other in {"10.71.0.1", "10.72.0.1"} - {host}:
            assert not asked(other), f"{host} is announced at {other}"
        if ":" in host:
            continue
        found, all_there = {}, threading.Event()
        class Listener:
            def add_service(self, zc, kind, name):
                found[kind] = zc.get_service_info(kind, name)
                if len(found) == 2: all_there.set()
            update_service = remove_service = lambda *_: None
        zc = Zeroconf(interfaces=[host])
        browser = ServiceBrowser(zc, KINDS, Listener())
        assert all_there.wait(40.0), found
        assert found[KINDS[0]].port == part.port
        assert found[KINDS[1]].port == 9010
        assert found[KINDS[0]].parsed_addresses() == [host]
        assert found[KINDS[0]].name.startswith("Live test.")
        zc.close()
    finally:
        part.stop()
print("found")
"""


@pytest.mark.long
@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0 or not shutil.which("unshare"), reason="needs a namespace")
def test_zeroconf_announces_only_on_the_served_network():
    pytest.importorskip("aiohttp")
    pytest.importorskip("zeroconf")
    command = ["unshare", "-n", "sh", "-c", NETWORK, sys.executable, BROWSE]
    done = subprocess.run(command, capture_output=True, text=True, timeout=180.0)
    if "unshare" in done.stderr or "ip:" in done.stderr or "RTNETLINK" in done.stderr:
        pytest.skip(done.stderr.strip())
    assert done.stdout.strip() == "found", done.stderr
