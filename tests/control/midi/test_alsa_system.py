"""Tests of ALSA's ports. alsa-midi's client, which calls the kernel's sequencer, is replaced; the rest is its own."""

import errno
import queue
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from live.base.event_queue import EventQueue
from live.clock.time_source import SystemClock
from live.control.events.events import ControlEvent, Tap
from live.control.midi import alsa_system, midi_ports
from live.control.midi.alsa_system import AlsaSystem
from live.control.midi.midi_input import MidiInput
from live.control.midi.midi_mapping import MidiMap
from live.control.midi.midi_system import MidiUnavailable
from tests.control.waiting import wait_for

PIECE = 256
"""The kernel hands exclusive messages over in pieces of so many bytes."""


class Sequencer:
    """The kernel: clients with ports, and connections between ports."""

    def __init__(self, library: Any) -> None:
        caps, types = library.PortCaps, library.PortType
        self.library = library
        self.reads, self.writes = caps.READ | caps.SUBS_READ, caps.WRITE | caps.SUBS_WRITE
        self.clients: dict[int, tuple[bytes, dict[int, Any]]] = {}
        self.connections: set[tuple[tuple[int, int], tuple[int, int]]] = set()
        self.inboxes: dict[int, queue.Queue[Any]] = {}
        self.arrived: dict[tuple[int, int], list[bytes]] = {}
        self.add(0, b"System", (b"Timer", self.reads | self.writes, types.ANY))
        self.add(14, b"Midi Through", (b"Midi Through Port-0", self.reads | self.writes, types.MIDI_GENERIC))

    def add(self, number: int, name: bytes, *ports: tuple[bytes, int, int]) -> None:
        self.clients[number] = (name, dict(enumerate(ports)))

    def pad(self, number: int, name: bytes = b"Pad") -> None:
        """A controller is plugged in: a port for both directions, and one that cannot be connected."""
        both, kind = self.reads | self.writes, self.library.PortType.MIDI_GENERIC
        self.add(number, name, (b"Pad MIDI 1", both, kind), (b"Pad secret", self.library.PortCaps.READ, kind))

    def unplug(self, number: int) -> None:
        del self.clients[number]
        self.connections = {pair for pair in self.connections if number not in (pair[0][0], pair[1][0])}

    def send(self, source: tuple[int, int], message: bytes, dest: tuple[int, int] | None = None) -> None:
        """Deliver a message to a port, or to all that are connected."""
        for sender, receiver in [(source, dest)] if dest else sorted(self.connections):
            if sender != source or receiver is None:
                continue
            for begin in range(0, len(message), PIECE):
                piece = message[begin : begin + PIECE]
                self.arrived.setdefault(receiver, []).append(piece)
                if receiver[0] in self.inboxes:
                    self.inboxes[receiver[0]].put(self.library.MidiBytesEvent(piece))


class Client:
    """What is used of alsa_midi.SequencerClient."""

    def __init__(self, name: str, kernel: Sequencer) -> None:
        self.client_id = next(number for number in range(128, 192) if number not in kernel.clients)
        self._kernel: Sequencer | None = kernel
        self._waiting: list[tuple[Any, Any, Any]] = []
        kernel.add(self.client_id, name.encode())
        kernel.inboxes[self.client_id] = queue.Queue()

    @property
    def kernel(self) -> Sequencer:
        assert self._kernel is not None, "used after it was closed"
        return self._kernel

    def query_next_client(self, previous: int) -> Any:
        number = min((each for each in self.kernel.clients if each > previous), default=None)
        if number is None:
            return None
        return self.kernel.library.ClientInfo(number, self.kernel.clients[number][0].decode())

    def query_next_port(self, client_id: int, previous: int) -> Any:
        _, ports = self.kernel.clients.get(client_id, (b"", {}))
        number = min((each for each in ports if each > previous), default=None)
        if number is None:
            return None
        name, caps, kind = ports[number]
        return self.kernel.library.PortInfo(client_id, number, name.decode(), caps, kind)

    def get_client_info(self, client_id: int) -> Any:
        return self._found(self.query_next_client(client_id - 1), client_id)

    def get_port_info(self, address: tuple[int, int]) -> Any:
        return self._found(self.query_next_port(address[0], address[1] - 1), address[1], "port_id")

    def _found(self, info: Any, number: int, of: str = "client_id") -> Any:
        if info is None or getattr(info, of) != number:
            raise self.kernel.library.ALSAError("No such file or directory", -errno.ENOENT)
        return info

    def create_port(self, name: str, caps: Any) -> "OwnPort":
        kind = self.kernel.library.PortType.MIDI_GENERIC
        self.kernel.clients[self.client_id][1][0] = (name.encode(), caps, kind)
        return OwnPort(self)

    def event_input(self, prefer_bytes: bool) -> Any:
        assert prefer_bytes
        event = self.kernel.inboxes[self.client_id].get(timeout=60.0)
        if isinstance(event, Exception):
            raise event
        return event

    def event_output(self, event: Any, port: "OwnPort", dest: Any) -> None:
        if (port.client_id, port.port_id) not in {pair[0] for pair in self.kernel.connections} and dest is None:
            raise self.kernel.library.ALSAError("No such device", -errno.ENODEV)
        self._waiting.append((event, port, dest))

    def drain_output(self) -> None:
        for event, port, dest in self._waiting:
            to = dest and (dest.client_id, dest.port_id)
            self.kernel.send((port.client_id, port.port_id), event.midi_bytes, to)
        self._waiting.clear()

    def close(self) -> None:
        self.kernel.unplug(self.client_id)
        self._kernel = None


class OwnPort:
    """What is used of alsa_midi.Port."""

    def __init__(self, client: Client) -> None:
        self.client_id, self.port_id, self._kernel = client.client_id, 0, client.kernel

    def connect_from(self, source: tuple[int, int]) -> None:
        self._kernel.connections.add((source, (self.client_id, self.port_id)))

    def connect_to(self, dest: tuple[int, int]) -> None:
        self._kernel.connections.add(((self.client_id, self.port_id), dest))


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Sequencer]:
    try:
        import alsa_midi
    except (ImportError, OSError) as error:
        pytest.skip(f"alsa-midi does not work here: {error}")
    device = tmp_path / "seq"
    device.touch()
    made = Sequencer(alsa_midi)
    monkeypatch.setattr(alsa_system, "SEQUENCER", str(device))
    monkeypatch.setattr(alsa_midi, "SequencerClient", lambda name: Client(name, made))
    monkeypatch.setattr(midi_ports, "SYSTEMS", (AlsaSystem(),))
    yield made
    assert [number for number in made.clients if number >= 128 and number != 150] == []  # all of ours are closed


def test_names_are_those_of_rtmidi_without_the_system_and_ourselves(kernel: Sequencer) -> None:
    kernel.pad(24)
    kernel.add(150, b"ChoreoGraphics", (b"in", kernel.reads | kernel.writes, kernel.library.PortType.MIDI_GENERIC))
    for direction in ("input", "output"):
        assert AlsaSystem().port_names(direction) == ["Midi Through:Midi Through Port-0 14:0", "Pad:Pad MIDI 1 24:0"]


def test_a_name_cut_within_a_character_hides_only_that_device(kernel: Sequencer) -> None:
    kernel.pad(20, "Gerät".encode()[:-2])
    kernel.pad(24)
    bad = (b"\xff", kernel.reads, kernel.library.PortType.MIDI_GENERIC)
    kernel.add(28, b"Box", bad, (b"good", *bad[1:]), bad)
    names = ["Midi Through:Midi Through Port-0 14:0", "Pad:Pad MIDI 1 24:0", "Box:good 28:1"]
    assert AlsaSystem().port_names("input") == names


def test_messages_of_every_kind_arrive_and_long_exclusive_ones_are_joined(kernel: Sequencer) -> None:
    kernel.pad(24)
    port = midi_ports.open_port("input", "pad midi")
    assert port.name == "Pad:Pad MIDI 1 24:0"
    received: list[bytes] = []
    sent = [b"\x90\x24\x7f", b"\xf8", b"\xfe", b"\xf0" + bytes(1000) + b"\xf7", b"\xf2\x01\x02"]
    try:
        port.listen(lambda message: received.append(bytes(message)))
        for message in sent:
            kernel.send((24, 0), message)
        assert wait_for(lambda: len(received) == len(sent), 5.0)
    finally:
        port.close()
        port.close()
    assert received == sent


def test_overrun_loses_messages_and_input_goes_on(kernel: Sequencer) -> None:
    kernel.pad(24)
    port = midi_ports.open_port("input", "Pad")
    received: list[bytes] = []
    try:
        port.listen(lambda message: received.append(bytes(message)))
        kernel.send((24, 0), b"\xf0\x01\x02")
        (inbox,) = (inbox for number, inbox in kernel.inboxes.items() if number in kernel.clients)
        inbox.put(kernel.library.ALSAError("No space left on device", -errno.ENOSPC))
        kernel.send((24, 0), b"\x90\x24\x7f")
        assert wait_for(lambda: received == [b"\x90\x24\x7f"], 5.0)
    finally:
        port.close()


def test_sent_messages_leave_at_once_until_the_device_is_gone(kernel: Sequencer) -> None:
    kernel.pad(24)
    port = midi_ports.open_output("Pad")
    port.send(b"\x90\x24\x7f")
    assert kernel.arrived == {(24, 0): [b"\x90\x24\x7f"]}
    assert port.exists
    kernel.unplug(24)
    assert not port.exists
    with pytest.raises(OSError, match="No such device"):
        port.send(b"\x90\x24\x00")
    port.close()
    with pytest.raises(OSError, match="closed"):
        port.send(b"\x90\x24\x00")


def test_open_port_is_looked_up_without_a_list_of_all(kernel: Sequencer, monkeypatch: pytest.MonkeyPatch) -> None:
    kernel.pad(24)
    port = midi_ports.open_output("Pad")
    monkeypatch.setattr(alsa_system, "_addresses", None)
    assert port.exists
    for name, exists in ((b"Drums", False), (b"Pad", True), (b"P\xff", False)):  # it has the number of one that left
        kernel.pad(24, name)
        assert port.exists == exists
    kernel.add(24, b"Pad")
    assert not port.exists
    port.close()
    assert not port.exists


def test_device_that_left_meanwhile_is_no_open_port(kernel: Sequencer) -> None:
    with pytest.raises(OSError, match="gone"):
        AlsaSystem().open_port("input", "Pad:Pad MIDI 1 24:0")


def test_controller_that_returns_with_another_number_is_opened_again(
    kernel: Sequencer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(midi_ports, "RETRY_INTERVAL", 0.1)
    kernel.pad(24)
    inbox: EventQueue[ControlEvent] = EventQueue()
    listens = MidiInput("Pad:Pad MIDI 1 24:0", inbox, SystemClock(), midi_map=MidiMap())
    listens.start()
    try:
        assert wait_for(lambda: listens.connected == "Pad:Pad MIDI 1 24:0", 10.0)
        kernel.unplug(24)
        assert wait_for(lambda: listens.connected == "", 10.0)
        kernel.pad(31)
        assert wait_for(lambda: listens.connected == "Pad:Pad MIDI 1 31:0", 10.0)
        kernel.send((31, 0), b"\xb0\x40\x7f")
        assert wait_for(lambda: listens.messages == 1, 10.0)
    finally:
        listens.stop()
    assert [type(event) for event in inbox.drain()] == [Tap]


def test_kernel_without_sequencer_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kernel: Sequencer) -> None:
    monkeypatch.setattr(alsa_system, "SEQUENCER", str(tmp_path / "none"))
    with pytest.raises(MidiUnavailable, match="the kernel has no ALSA sequencer"):
        AlsaSystem().port_names("input")


def test_sequencer_that_cannot_be_opened_is_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kernel: Sequencer
) -> None:
    monkeypatch.setattr(alsa_system, "SEQUENCER", str(tmp_path))
    with pytest.raises(MidiUnavailable, match="Is a directory"):
        AlsaSystem().port_names("input")


@pytest.mark.parametrize("fault", ["ImportError('no alsa_midi')", "OSError('no libasound.so.2')"])
def test_missing_library_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, fault: str) -> None:
    (tmp_path / "alsa_midi.py").write_text(f"raise {fault}\n")
    monkeypatch.delitem(sys.modules, "alsa_midi", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MidiUnavailable, match="ALSA: no "):
        AlsaSystem().port_names("input")
