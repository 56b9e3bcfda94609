"""Tests of the selector loop that reads the channels of the supervisor's processes."""

import socket
import sys

import pytest

from live.base.system import channel as system_channel
from live.base.system import loopback, shared_page
from live.supervisor.line_channel import LineChannel
from live.supervisor.process import ProcessManager
from tests.control.waiting import wait_for

SLOW_CHILD = """
import socket, sys
from live.base.system.channel import stream_of_argument
with socket.create_connection(("127.0.0.1", int(sys.argv[1]))) as gate:
    gate.recv(1)  # until the test lets it go on
parent = stream_of_argument(sys.argv[2])
parent.sendall(b"got " + parent.recv(100))
"""


@pytest.fixture
def portable(monkeypatch):
    """Children connect over loopback, as on systems other than Linux."""
    for module in (system_channel, shared_page):
        monkeypatch.setattr(module, "LINUX", False)


def test_a_child_that_starts_slowly_delays_nothing(portable, monkeypatch):
    monkeypatch.setattr(loopback, "CONNECT_TIMEOUT", 20.0)
    processes, received, others = ProcessManager(), [], []
    ours, other = socket.socketpair()
    processes.register(LineChannel(ours), others.append)
    with ours, other, socket.create_server(("127.0.0.1", 0)) as gate:
        gate.settimeout(20.0)
        command = [sys.executable, "-c", SLOW_CHILD, str(gate.getsockname()[1])]
        child = processes.start("engine", command, received.append)
        child.channel.send_line("brief")
        at_gate, _ = gate.accept()
        other.send(b"hello\n")
        processes.poll()
        assert (others, received, child.channel.connected) == (["hello"], [], False)
        at_gate.close()
        assert wait_for(lambda: processes.poll() and received, 10.0)
        assert received == ["got brief"]
        assert wait_for(lambda: processes.poll() and child.channel.ended, 10.0)
        assert child.end() == 0
    processes.close()


@pytest.mark.parametrize(("program", "code", "limit"), [("", 0, 20.0), ("import time; time.sleep(60)", -9, -1.0)])
def test_a_child_that_never_connects_is_ended(portable, monkeypatch, program, code, limit):
    monkeypatch.setattr(loopback, "CONNECT_TIMEOUT", limit)
    processes = ProcessManager()
    child = processes.start("engine", [sys.executable, "-c", program], lambda line: None)
    assert wait_for(lambda: processes.poll() and child.channel.ended, 10.0)
    assert child.process.wait(20.0) == code
    child.end()
    processes.close()


def test_descriptor_of_closed_channel_can_be_registered_again():
    """A process that dies in the middle of a round is closed before the end of its channel was read."""
    processes, received = ProcessManager(), []
    first, first_peer = socket.socketpair()
    number = first.fileno()
    channel = LineChannel(first)
    processes.register(channel, received.append)
    channel.close()
    ours, peer = socket.socketpair()
    assert number in (ours.fileno(), peer.fileno())  # the system gives the lowest free descriptor
    ours, peer = (ours, peer) if ours.fileno() == number else (peer, ours)
    channel = LineChannel(ours)
    processes.register(channel, received.append)
    peer.send(b"hello\n")
    processes.poll()
    assert received == ["hello"]
    for end in (first_peer, peer):
        end.close()
    channel.close()
    assert not processes.selector.get_map()
    processes.close()
