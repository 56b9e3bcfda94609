"""Tests of MIDI as a byte stream: mido's sockets, raw bytes over TCP, a named pipe."""

import os
import socket
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import mido
import pytest
from mido.sockets import PortServer, connect

from live.base.event_queue import EventQueue
from live.clock.time_source import SystemClock
from live.control.events.events import ControlEvent, One, Tap
from live.control.midi.midi_feedback import MidiOutput
from live.control.midi.midi_input import MidiInput
from live.control.midi.midi_mapping import MidiMap
from live.control.midi.midi_ports import open_port
from live.control.midi.midi_streams import MAX_SENDERS, StreamPort, parse_address
from tests.control.waiting import wait_for


@pytest.fixture
def input_port():
    """An open input port and the list of messages it has received."""
    found: list[bytes] = []

    def receive(message: Sequence[int]) -> None:
        found.append(bytes(message))

    port = StreamPort("input", "tcp:127.0.0.1:0")
    port.listen(receive)
    yield port, found
    port.close()


@pytest.fixture
def socket_stack():
    """A stack that closes its sockets after the test."""
    with ExitStack() as found:
        yield found


def test_messages_from_mido_socket_are_received(input_port) -> None:
    port, found = input_port
    out = connect(*port.address)
    sent = [mido.Message("note_on", note=60, velocity=7), mido.Message("clock"), mido.Message("sysex", data=(1, 2))]
    for message in sent:
        out.send(message)
    assert wait_for(lambda: len(found) == 3, 5.0)
    assert found == [bytes(message.bytes()) for message in sent]
    out.close()


def test_each_sender_has_its_own_running_status(input_port, socket_stack: ExitStack) -> None:
    port, found = input_port
    first, second = (socket_stack.enter_context(socket.create_connection(port.address)) for _ in range(2))
    first.sendall(b"\x90\x3c")
    second.sendall(b"\xb0\x07\x01")
    assert wait_for(lambda: found == [b"\xb0\x07\x01"], 5.0)
    first.sendall(b"\xf8\x40\x3e\x41")
    assert wait_for(lambda: found[1:] == [b"\xf8", b"\x90\x3c\x40", b"\x90\x3e\x41"], 5.0)
    first.sendall(b"\x3f")
    first.close()
    assert wait_for(lambda: port.rejected == 1, 5.0)  # the note that was cut off
    second.sendall(b"\x08\x02")
    assert wait_for(lambda: found[4:] == [b"\xb0\x08\x02"], 5.0)
    assert port.exists


def test_senders_above_the_limit_are_refused(input_port, socket_stack: ExitStack) -> None:
    port, found = input_port
    senders = [socket_stack.enter_context(socket.create_connection(port.address)) for _ in range(MAX_SENDERS)]
    for sender in senders:
        sender.sendall(b"\xf8")
    assert wait_for(lambda: len(found) == MAX_SENDERS, 5.0)
    with socket.create_connection(port.address) as more:
        more.settimeout(20.0)
        assert more.recv(1) == b""


def test_named_pipe_stays_open_after_writer_closes(tmp_path: Path) -> None:
    pipe = tmp_path / "midi"
    os.mkfifo(pipe)
    inbox: EventQueue[ControlEvent] = EventQueue()
    listens = MidiInput(f"raw:{pipe}", inbox, SystemClock(), midi_map=MidiMap())
    listens.start()
    try:
        assert wait_for(lambda: listens.connected != "", 5.0)
        for _ in range(2):
            with pipe.open("wb", buffering=0) as writes:
                writes.write(b"\x9f\x24\xf8\x40\x25\x40")  # the second note by running status
        assert wait_for(lambda: listens.messages == 6, 5.0)
    finally:
        listens.stop()
    assert [type(event) for event in inbox.drain() if isinstance(event, Tap | One)] == [Tap, One, Tap, One]


def test_output_reconnects_after_listener_closes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("live.control.midi.midi_ports.RETRY_INTERVAL", 0.05)
    server = PortServer("127.0.0.1", 0)
    where = server._socket.getsockname()
    tells = MidiOutput(f"tcp:127.0.0.1:{where[1]}", SystemClock())
    tells.start()
    try:
        assert wait_for(lambda: tells.connected != "", 5.0)
        client = server.accept()
        tells.send(b"\xb0\x07\x05")
        assert client.receive() == mido.Message("control_change", control=7, value=5)
        client.close()
        client._rfile.close(), client._wfile.close()

        def lost() -> bool:
            tells.send(b"\xb0\x07\x06")
            return tells.opened > 1

        assert wait_for(lost, 5.0)
    finally:
        tells.stop()
        server.close()


@pytest.mark.parametrize("name", ["tcp:9080", "tcp:127.0.0.1:", "tcp:127.0.0.1:x", "tcp::1", "tcp:127.0.0.1:70000"])
def test_invalid_addresses_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match="expected, as in"):
        parse_address(name)


def test_missing_pipe_raises_os_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="nothing"):
        open_port("input", f"raw:{tmp_path}/nothing")
