"""Connections of browsers over a bus in one process: what is relayed, what is refused, and a leader that changes."""

import asyncio
import socket
import time

import pytest

from live.control.web.web_key import RELAY_HEADER, relay_token
from live.nodes import messages
from live.nodes.messages import PageFrame, Pulse
from live.nodes.page_relay import MOST_CONNECTIONS, Entrance, Exit, admitted_head
from live.nodes.signed_bus import SignedBus
from live.supervisor.network.identity import Pairings, load_identity
from tests.fixtures.mostly_long import mostly_long

KEY = "a key of the page"
HOST = ("127.0.0.1", 8010)


class DirectBus:
    """Delivers at once to all who receive; `lossy` loses each fifth message for pages."""

    def __init__(self, lossy=False):
        self.receivers, self.count, self.lossy = [], 0, lossy

    def publish(self, key, data, *, bulk=False):
        self.count += bulk
        if not (self.lossy and bulk and self.count % 5 == 0):
            for wanted, act in list(self.receivers):
                if wanted == key:
                    act(data)

    def receive(self, key, act):
        self.receivers.append((key, act))


class Server:
    """Answers each request by its head, repeated, and closes; `mute`: keeps it waiting."""

    def __init__(self, repeat=1, mute=False):
        self.heads, self.repeat, self.mute, self.writers = [], repeat, mute, []

    async def start(self):
        self.server = await asyncio.start_server(self.answer, "127.0.0.1", 0)
        return self.server.sockets[0].getsockname()[:2]

    async def answer(self, reader, writer):
        head = await reader.readuntil(b"\r\n\r\n")
        self.heads.append(head)
        self.writers.append(writer)
        if self.mute:
            return
        writer.write(b"HTTP/1.1 200 OK\r\n\r\n" + head * self.repeat)
        await writer.drain()
        writer.close()

    def close(self):
        self.server.close()
        for writer in self.writers:
            writer.close()


class Hall:
    """A leader with a page, and an entrance of another machine."""

    def __init__(self, folder, lossy=False):
        self.here, self.there = load_identity(folder / "here"), load_identity(folder / "there")
        pairings = Pairings(folder / "here"), Pairings(folder / "there")
        pairings[0].add("there", self.there.certificate)
        pairings[1].add("here", self.here.certificate)
        self.bus, self.skew = DirectBus(lossy), 0.0
        self.mine = SignedBus(self.bus, self.here, pairings[0])
        self.theirs = SignedBus(self.bus, self.there, pairings[1])

    async def open(self, server, leader="stage-1"):
        self.exit = Exit(self.mine, leader, await server.start(), KEY)
        self.entrance = Entrance(self.theirs, ("stage.example",), lambda: time.monotonic() + self.skew)
        sock = socket.create_server(("127.0.0.1", 0))
        self.at = sock.getsockname()[:2]
        self.tasks = [asyncio.ensure_future(self.exit.run()), asyncio.ensure_future(self.entrance.serve(sock))]
        await asyncio.sleep(0)

    def pulse(self, leader="stage-1", epoch=1):
        self.mine.publish(messages.PULSE, messages.encode(Pulse(leader, epoch, "x", "y", 0, 0.0, 0.0)))

    async def ask(self, *headers, first="GET / HTTP/1.1"):
        reader, writer = await asyncio.open_connection(*self.at)
        lines = (first, *(headers or (f"Host: 127.0.0.1:{self.at[1]}",)))
        writer.write("\r\n".join((*lines, "", "")).encode())
        answer = await asyncio.wait_for(reader.read(), 20.0)
        writer.close()
        return answer

    async def until(self, holds):
        while not holds():
            await asyncio.sleep(0.01)

    async def close(self, *servers):
        self.exit.close()
        self.entrance.close()
        await self.until(lambda: not self.exit._flows and not self.entrance._flows)
        for task in self.tasks:
            task.cancel()
        for server in servers:
            server.close()
        await asyncio.gather(*self.tasks, return_exceptions=True)
        await asyncio.sleep(0.05)  # transports close in the loop's next turns


def play(hall, *servers, test):
    async def run():
        await hall.open(servers[0])
        for other in servers[1:]:
            other.at = await other.start()
        try:
            await asyncio.wait_for(test(), 60.0)
        finally:
            await hall.close(*servers)

    asyncio.run(run())


@mostly_long("lossy", [False, True], quick=[0])
def test_request_reaches_the_page_with_the_word_of_the_relay_and_its_answer_comes_whole(tmp_path, lossy):
    hall, server = Hall(tmp_path, lossy), Server(repeat=9000)

    async def test():
        hall.pulse()
        await hall.until(lambda: hall.entrance.leader == "stage-1")
        host = f"Host: stage.example:{hall.at[1]}"
        answer = await hall.ask(host, f"{RELAY_HEADER.lower()}: forged", "Connection: keep-alive", "Cookie: a=b")
        (head,) = server.heads
        token = relay_token(KEY.encode())
        assert head.decode().split("\r\n") == [
            "GET / HTTP/1.1", f"{RELAY_HEADER}: {token}", host, "Cookie: a=b", "Connection: close", "", "",
        ]  # fmt: skip
        assert answer == b"HTTP/1.1 200 OK\r\n\r\n" + head * 9000
        await hall.until(lambda: not hall.exit._flows and not hall.entrance._flows)
        assert hall.exit.refused == hall.entrance.refused == 0

    play(hall, server, test=test)


def test_other_hosts_are_refused_and_counted_and_without_a_leader_nothing_is_relayed(tmp_path):
    hall, server = Hall(tmp_path), Server()

    async def test():
        assert (await hall.ask()).startswith(b"HTTP/1.1 503 ")
        hall.pulse()
        await hall.until(lambda: hall.entrance.leader == "stage-1")
        assert (await hall.ask("Host: evil.example")).startswith(b"HTTP/1.1 403 ")
        assert (await hall.ask("X: no host")).startswith(b"HTTP/1.1 403 ")
        assert hall.entrance.refused == 2
        hall.skew += 3.0  # the leader is silent
        assert (await hall.ask()).startswith(b"HTTP/1.1 503 ")
        assert server.heads == []

    play(hall, server, test=test)


def test_leader_of_a_higher_epoch_gets_the_next_requests_and_others_break(tmp_path):
    hall, server, other = Hall(tmp_path), Server(mute=True), Server()

    async def test():
        hall.pulse()
        await hall.until(lambda: hall.entrance.leader == "stage-1")
        waiting = asyncio.ensure_future(hall.ask())
        await hall.until(lambda: len(hall.entrance._flows) == 1)
        second = Exit(hall.mine, "stage-2", other.at, "another key")
        hall.pulse("stage-2", epoch=2)
        assert await waiting == b""  # its browser comes back by itself
        assert (await hall.ask()).startswith(b"HTTP/1.1 200 OK")
        assert len(other.heads) == 1
        await hall.until(lambda: not second._flows)

    play(hall, server, other, test=test)


def test_messages_of_strangers_and_invalid_ones_are_counted_and_reach_no_server(tmp_path):
    hall, server = Hall(tmp_path), Server(mute=True)
    folder = tmp_path / "stranger"
    stranger = SignedBus(hall.bus, load_identity(folder), Pairings(folder))
    key, head = messages.page_key("stage-1"), b"GET / HTTP/1.1\r\n\r\n"

    async def test():
        stranger.publish(key, messages.encode(PageFrame(bytes(16), "me", "data", 0, 0, head)), bulk=True)
        hall.theirs.publish(key, b"\xc1", bulk=True)
        hall.theirs.publish(key, messages.encode(PageFrame(bytes(3), "me", "data", 0, 0, head)), bulk=True)
        hall.theirs.publish(key, messages.encode(PageFrame(bytes(16), "me", "data", 0, 0, b"no head")), bulk=True)
        hall.theirs.publish(key, messages.encode(PageFrame(bytes(16), "me", "data", 7, 0, head)), bulk=True)
        await hall.until(lambda: hall.exit.refused == 1)
        assert hall.mine.strangers == 1
        assert server.heads == []
        begin = PageFrame(bytes(16), "me", "data", 0, 0, head)
        hall.theirs.publish(key, messages.encode(begin), bulk=True)
        await hall.until(lambda: len(hall.exit._flows) == 1)
        other = PageFrame(bytes(16), "another", "data", len(head), 0, b"more")
        hall.theirs.publish(key, messages.encode(other), bulk=True)  # into the connection of another end
        await hall.until(lambda: hall.exit.refused == 2)
        for number in range(2 * MOST_CONNECTIONS):
            frame = PageFrame(number.to_bytes(16, "big"), "me", "data", 0, 0, head)
            hall.theirs.publish(key, messages.encode(frame), bulk=True)
        await hall.until(lambda: len(hall.exit._flows) >= MOST_CONNECTIONS)
        assert len(hall.exit._flows) == MOST_CONNECTIONS
        await hall.until(lambda: len(server.heads) == MOST_CONNECTIONS)

    play(hall, server, test=test)


@pytest.mark.parametrize(
    "lines",
    [
        ("GET / HTTP/1.1", "Host: 127.0.0.1:8010", "Host: 127.0.0.1:8010"),
        ("GET / HTTP/1.1", "Host : 127.0.0.1:8010"),
        ("GET / HTTP/1.1", "Host: 127.0.0.1:8010", " folded: line"),
        ("POST / HTTP/1.1", "Host: 127.0.0.1:8010", "Content-Length: 4"),
        ("POST / HTTP/1.1", "Host: 127.0.0.1:8010", "Transfer-Encoding: chunked"),
        ("GET / HTTP/1.1", "Host: 127.0.0.1:8010\nHost: evil.example"),
        ("GET / HTTP/1.1", "Host: 127.0.0.1:8011"),
        ("GET / HTTP/1.1",),
    ],
)
def test_heads_that_could_hide_another_request_or_host_are_not_admitted(lines):
    assert admitted_head("\r\n".join((*lines, "", "")).encode(), *HOST, ()) is None


def test_upgrade_of_a_web_socket_stays():
    head = b"GET /ws HTTP/1.1\r\nHost: localhost:8010\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\r\n"
    assert admitted_head(head, *HOST, ()) == head
