"""Tests of the selector loop that reads the channels of the supervisor's processes."""

import socket

from live.supervisor.line_channel import LineChannel
from live.supervisor.process import ProcessManager


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
