"""Tests of the connections to children, by the way of Linux and by the one that works everywhere."""

import asyncio
import contextlib
import os
import select
import socket
import subprocess
import sys
import threading

import pytest

from live.base.system import channel, features, shared_page
from live.base.system.files import memory_folder
from live.base.system.loopback import ChildConnection
from live.base.system.packet_socket import MAX_BYTES, PacketSocket

ECHO_LINES = """
import sys
from live.base.system.channel import stream_of_argument
from live.base.system.shared_page import SharedPage
sock, page = stream_of_argument(sys.argv[1]), SharedPage.of_argument(sys.argv[2])
while data := sock.recv(1 << 16):
    page.memory[0] = page.memory[0] + 1
    sock.sendall(data)
"""
ECHO_PACKETS = """
import sys, select
from live.base.system.channel import packets_of_argument
channel = packets_of_argument(sys.argv[1])
channel.setblocking(True)
while data := channel.recv(1 << 16):
    channel.send(data)
"""


@pytest.fixture(params=["linux", "portable"], autouse=True)
def way(request, monkeypatch):
    for module in (features, channel, shared_page):
        monkeypatch.setattr(module, "LINUX", request.param == "linux")
    monkeypatch.setenv("LIVE_PORTABLE", "1" if request.param == "portable" else "")
    return request.param


def receive(end, within=20.0):
    while True:
        try:
            return end.recv(1 << 20)
        except BlockingIOError:
            connected = getattr(end, "connected", True)
            assert select.select([end], [], [], within if connected else 0.02)[0] or not connected, "no answer"


def test_stream_and_page_reach_the_child(way):
    page = shared_page.SharedPage.create()
    mine, process = channel.start_child([sys.executable, "-c", ECHO_LINES], page.argument, inherit=page.inherit)
    with mine if isinstance(mine, socket.socket) else mine.wait() as mine:
        mine.settimeout(20.0)
        mine.sendall(b"one\n")
        assert mine.recv(100) == b"one\n"
        assert page.memory[0] == 1
        assert page.inherit or not os.path.exists(page.argument)  # none is left, whoever is killed now
    assert process.wait(20.0) == 0
    page.close()


def test_a_page_in_a_file_lies_in_memory_and_goes_with_the_page(way):
    page = shared_page.SharedPage.create()
    path = page.argument
    assert page.inherit or os.path.dirname(path) == str(memory_folder())
    page.close()
    assert not os.path.exists(path)


def test_packets_keep_their_bounds_and_wait_for_the_child(way):
    mine, process = channel.start_packet_child([sys.executable, "-c", ECHO_PACKETS])
    packets = [b"a", b"bc" * 10_000, b"d"]
    for packet in packets:
        mine.send(packet)
    assert [receive(mine) for _ in packets] == packets
    mine.close()
    assert process.wait(20.0) == 0


def test_the_end_of_the_child_is_the_end_of_the_channel(way):
    mine, process = channel.start_packet_child([sys.executable, "-c", ""])
    assert process.wait(20.0) == 0
    with contextlib.suppress(OSError):  # it never connected
        assert receive(mine) == b""
    mine.close()


def test_a_command_that_does_not_exist_is_an_error(way):
    with pytest.raises(OSError, match="no such program"):
        channel.start_child(["/no such program"])


def test_a_listening_socket_is_handed_over(way):
    listening = socket.create_server(("127.0.0.1", 0))
    where = listening.getsockname()
    found, inherit = channel.hand_over(listening)
    assert bool(inherit) == (way == "linux")
    there = channel.listening_socket_of(os.dup(found) if isinstance(found, int) else found)
    with there, socket.create_connection(where, timeout=5.0):
        assert there.accept()[0].close() is None
    listening.close()


def start_silent_child():
    return ChildConnection([sys.executable, "-c", "import time; time.sleep(60)"], (), {})


def test_strangers_without_the_token_are_refused(way):
    there = start_silent_child()
    try:
        where = ("127.0.0.1", there.listening.getsockname()[1])
        with socket.create_connection(where, timeout=5.0) as stranger:
            stranger.sendall(b"0" * 32)
            while select.select([stranger], [], [], 0.0)[0] == []:
                assert there.accept() is None
            assert stranger.recv(1) == b""
        with socket.create_connection(where, timeout=5.0) as child:
            child.sendall(there._token)
            while (sock := there.accept()) is None:
                pass
            sock.close()
    finally:
        there.process.kill()
        there.process.wait()
        there.close()


def test_a_child_that_ends_at_once_is_an_error(way):
    there = ChildConnection([sys.executable, "-c", ""], (), {"stderr": subprocess.DEVNULL})
    with pytest.raises(ConnectionError):
        there.wait()


def test_a_child_that_does_not_connect_in_time_is_an_error(way, monkeypatch):
    monkeypatch.setattr("live.base.system.loopback.CONNECT_TIMEOUT", -1.0)
    there = start_silent_child()
    silent = PacketSocket(there)
    try:
        with pytest.raises(TimeoutError):
            silent.recv()
    finally:
        there.process.kill()
        there.process.wait()
        silent.close()


def packet_ends():
    mine, theirs = socket.socketpair()
    return PacketSocket(mine), theirs


def fill(end):
    """Send until the connection is full; return how many packets wait or are on their way."""
    sent = 0
    with contextlib.suppress(BlockingIOError):
        while True:
            end.send(b"x" * 10_000)
            sent += 1
    return sent


def test_a_packet_that_is_too_long_ends_the_connection(way):
    mine, theirs = packet_ends()
    theirs.sendall((MAX_BYTES + 1).to_bytes(4, "little"))
    with pytest.raises(ConnectionAbortedError):
        receive(mine)
    mine.close()
    theirs.close()


def test_a_full_connection_refuses_packets_and_loses_none(way):
    mine, theirs = packet_ends()
    sent = fill(mine)
    reader = PacketSocket(theirs)
    received = 0
    while received < sent:
        try:
            assert reader.recv() == b"x" * 10_000
            received += 1
        except BlockingIOError:
            with pytest.raises(BlockingIOError):
                mine.recv()  # what was left is sent on
    mine.close()
    assert receive(reader) == b""
    reader.close()


def test_senders_do_not_mix_their_packets(way):
    mine, theirs = packet_ends()
    reader = PacketSocket(theirs)

    def send(mark):
        for _ in range(50):
            while True:
                try:
                    mine.send(mark * 3000)
                    break
                except BlockingIOError:
                    select.select([], [mine], [], 1.0)

    threads = [threading.Thread(target=send, args=(mark,)) for mark in (b"a", b"b")]
    for thread in threads:
        thread.start()
    found = []
    while len(found) < 100:
        data = receive(reader)
        assert len(data) == 3000
        assert len(set(data)) == 1
        found.append(data[:1])
        if len(found) < 100 and not any(thread.is_alive() for thread in threads):
            with contextlib.suppress(BlockingIOError):
                mine.recv()
    for thread in threads:
        thread.join()
    assert found.count(b"a") == 50
    mine.close()
    reader.close()


def test_a_packet_is_cut_to_what_is_asked_for(way):
    mine, theirs = packet_ends()
    other = PacketSocket(theirs)
    mine.send(b"abcd")
    mine.send(b"ef")
    assert [other.recv(3), other.recv(3)] == [b"abc", b"ef"]
    mine.close()
    other.close()


def test_the_last_packets_of_a_peer_that_has_gone_are_read(way):
    mine, theirs = packet_ends()
    fill(mine)
    other = PacketSocket(theirs)
    other.send(b"why it ended")
    other.close()
    assert mine.recv() == b"why it ended"
    with contextlib.suppress(ConnectionError):
        assert mine.recv() == b""
    mine.close()


def test_a_question_of_which_a_part_waits_is_answered(way):
    mine, theirs = packet_ends()
    asked = fill(mine)
    other = PacketSocket(theirs)

    async def answer():
        for _ in range(asked):
            assert len(await channel.receive_packet(other)) == 10_000
        other.send(b"answer")

    async def both():
        return (await asyncio.gather(channel.receive_packet(mine), answer()))[0]

    assert asyncio.run(asyncio.wait_for(both(), 20.0)) == b"answer"
    mine.close()
    other.close()
