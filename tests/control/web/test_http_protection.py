"""Tests of the protection shared by all HTTP servers: host names, address groups, connection limits."""

import asyncio
import contextlib
import socket

import pytest
from aiohttp import web

from live.control.web.http_protection import BoundedServer, FailedKeys, accepted_hosts, address_group, mdns_name, serve


def test_only_own_host_names_are_accepted():
    loopback = {"127.0.0.1:8010", "localhost:8010", "[::1]:8010"}
    assert accepted_hosts("127.0.0.1", 8010) == loopback == accepted_hosts("::1", 8010)
    assert accepted_hosts("::ffff:127.0.0.1", 8010) == loopback
    assert accepted_hosts("127.0.0.2", 8010) == loopback | {"127.0.0.2:8010"}
    assert accepted_hosts("192.168.1.20", 8010) == {"192.168.1.20:8010", f"{mdns_name()}:8010"}
    assert accepted_hosts("fe80::1%eth0", 8010) == {"[fe80::1]:8010", f"{mdns_name()}:8010"}
    assert mdns_name().endswith(".local")
    assert accepted_hosts("127.0.0.1", 80) == {f"{host}{port}" for host in ("127.0.0.1", "localhost", "[::1]")
                                               for port in ("", ":80")}  # fmt: skip
    named = accepted_hosts("192.168.1.20", 8010, ("Show.Example", "show.example:443"))
    assert named - accepted_hosts("192.168.1.20", 8010) == {"show.example:8010", "show.example:443", "show.example"}


@pytest.mark.parametrize(
    ("address", "group"),
    [
        ("192.168.1.20", "192.168.1.20"), ("::ffff:192.168.1.20", "192.168.1.20"), ("2001:db8::1", "2001:db8::/64"),
        ("2001:db8::ffff:1:2", "2001:db8::/64"), ("2001:db8:0:1::1", "2001:db8:0:1::/64"), ("fe80::1%3", "fe80::/64"),
        ("", ""),
    ],
)  # fmt: skip
def test_addresses_of_one_device_form_one_group(address, group):
    assert address_group(address) == group


def test_wrong_keys_are_limited_per_device_with_bounded_memory():
    now = [0.0]
    failed = FailedKeys(lambda: now[0])
    assert [failed.may_answer("a") for _ in range(12)] == [True] * 10 + [False] * 2
    assert failed.may_answer("b")
    now[0] = 2.0
    assert [failed.may_answer("a") for _ in range(2)] == [True, False]
    now[0] = 1000.0
    assert [failed.may_answer("a") for _ in range(11)] == [True] * 10 + [False]
    for number in range(10_000):
        failed.may_answer(f"c{number}")
    assert len(failed._left) <= 4096
    assert failed.count == 10_026


def connect_from(port, source):
    made = socket.socket()
    made.bind((source, 0))
    made.connect(("127.0.0.1", port))
    made.setblocking(False)
    return made


def is_open(each):
    try:
        return bool(each.recv(100))
    except BlockingIOError:
        return True
    except OSError:
        return False


async def until(condition):
    async with asyncio.timeout(20.0):
        while not condition():
            await asyncio.sleep(0.01)


async def run_server(what, **bounds):
    gate = asyncio.Event()

    async def answer(request):
        if request.path == "/later":
            await gate.wait()
        return web.Response(text="here")

    server = BoundedServer(answer, **bounds)
    with socket.create_server(("127.0.0.1", 0)) as listening, contextlib.ExitStack() as opened:
        runner = await serve(server, listening)
        try:
            port = listening.getsockname()[1]
            await what(server, lambda source: opened.enter_context(connect_from(port, source)), gate)
        finally:
            await runner.cleanup()


def test_largest_client_loses_its_oldest_idle_connection():
    async def what(server, connect, gate):
        quiet = connect("127.0.0.2")
        await until(lambda: server.waiting == 1)
        first = connect("127.0.0.3")
        await until(lambda: server.waiting == 2)
        first.send(b"GET /later HTTP/1.1\r\nHost: x\r\n\r\n")
        await asyncio.sleep(0.05)
        many = []
        for count in range(60):
            many.append(connect("127.0.0.3"))
            await until(lambda count=count: server.waiting + server.dropped == count + 3)
        assert server.waiting == 12
        assert server.dropped == 50
        assert is_open(quiet), "who has one keeps it"
        assert [is_open(each) for each in many] == [False] * 50 + [True] * 10
        got = b""
        gate.set()
        while not got.endswith(b"here"):
            await asyncio.sleep(0.01)
            with contextlib.suppress(BlockingIOError):
                got += first.recv(1000)  # it was asked for before the others came

    asyncio.run(run_server(what, most=12, most_of_one=100, within=30.0))


def test_connections_of_one_address_are_bounded():
    async def what(server, connect, gate):
        many = []
        for count in range(30):
            many.append(connect("127.0.0.3"))
            await until(lambda count=count: server.waiting + server.dropped == count + 1)
        assert server.waiting == 8
        assert [is_open(each) for each in many] == [False] * 22 + [True] * 8
        assert is_open(connect("127.0.0.2"))

    asyncio.run(run_server(what, most=100, most_of_one=8, within=30.0))


def test_slow_connection_is_closed_and_active_connection_kept():
    async def what(server, connect, gate):
        silent, slow, good = (connect("127.0.0.1") for _ in range(3))
        answers = 0
        for turn in range(12):
            with contextlib.suppress(OSError):
                slow.send(b"GET /" if turn == 0 else b"a")
            good.send(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")
            await until(lambda: is_readable(good))
            answers += good.recv(4000).count(b"here")
            await asyncio.sleep(0.05)
        assert answers == 12
        assert (is_open(silent), is_open(slow), server.dropped) == (False, False, 2)
        assert server.waiting == 1
        await until(lambda: server.waiting == 0)

    asyncio.run(run_server(what, within=0.4))


def is_readable(each):
    with contextlib.suppress(BlockingIOError):
        return bool(each.recv(1, socket.MSG_PEEK))
    return False
