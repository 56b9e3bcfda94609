"""Tests of MIDI on macOS and Windows. python-rtmidi, which is installed only there, is replaced by a module like it."""

import sys
from types import SimpleNamespace
from typing import Any

import pytest

from live.control.midi import midi_ports
from live.control.midi.midi_ports import open_port
from live.control.midi.midi_system import MidiUnavailable
from live.control.midi.rtmidi_system import RtMidiSystem


class Bus:
    """Ports of the system, and what was sent to each; makes what is used of the module rtmidi."""

    def __init__(self, *names: str) -> None:
        self.names = [*names]
        self.sent: dict[str, list[bytes]] = {name: [] for name in names}
        self.listens: dict[str, Any] = {}
        self.clients: set[Any] = set()
        self.module = SimpleNamespace(MidiIn=lambda name: _Client(self), MidiOut=lambda name: _Client(self))


class _Client:
    def __init__(self, bus: Bus) -> None:
        self._bus, self._name, self.ignores = bus, "", (True, True, True)
        bus.clients.add(self)

    def get_ports(self) -> list[str]:
        return self._bus.names

    def open_port(self, number: int, name: str) -> None:
        self._name = self._bus.names[number]

    def ignore_types(self, sysex: bool, timing: bool, active_sense: bool) -> None:
        self.ignores = (sysex, timing, active_sense)

    def set_callback(self, callback: Any) -> None:
        self._bus.listens[self._name] = lambda message: callback((message, 0.0), None)

    def cancel_callback(self) -> None:
        self._bus.listens.pop(self._name, None)

    def send_message(self, message: bytes) -> None:
        self._bus.sent[self._name].append(message)

    def close_port(self) -> None: ...

    def delete(self) -> None:
        self._bus.clients.remove(self)


@pytest.fixture
def bus(monkeypatch: pytest.MonkeyPatch) -> Bus:
    made = Bus("Keys", "Pads", "ChoreoGraphics in")
    monkeypatch.setitem(sys.modules, "rtmidi", made.module)
    monkeypatch.setattr(midi_ports, "SYSTEMS", (RtMidiSystem(),))
    return made


def test_ports_of_others_are_listed_and_no_client_stays_behind(bus: Bus) -> None:
    assert RtMidiSystem().port_names("input") == ["Keys", "Pads"]
    assert not bus.clients


def test_input_passes_on_every_kind_of_message_until_it_is_closed(bus: Bus) -> None:
    port = open_port("input", "keys")
    received: list[Any] = []
    port.listen(received.append)
    bus.listens["Keys"]([0xF8])
    (client,) = bus.clients
    assert client.ignores == (False, False, False)
    bus.names.remove("Keys")
    assert not port.exists
    port.close()
    port.close()
    assert (received, bus.listens, bus.clients) == ([[0xF8]], {}, set())


def test_output_sends_until_it_is_closed(bus: Bus) -> None:
    port = open_port("output", "pads")
    port.send(b"\x90\x24\x7f")
    assert bus.sent["Pads"] == [b"\x90\x24\x7f"]
    port.close()
    with pytest.raises(OSError, match="closed"):
        port.send(b"\x90\x24\x7f")


def test_device_that_left_meanwhile_is_no_open_port(bus: Bus) -> None:
    with pytest.raises(OSError, match="gone"):
        RtMidiSystem().open_port("input", "Drums")
    assert not bus.clients


@pytest.mark.parametrize("call", ["get_ports", "open_port"])
def test_port_that_cannot_be_opened_is_told_and_leaves_no_client(
    bus: Bus, monkeypatch: pytest.MonkeyPatch, call: str
) -> None:
    def fail(*_: Any) -> None:
        raise RuntimeError("MidiInWinMM::openPort: error creating\nport")

    monkeypatch.setattr(_Client, call, fail)
    with pytest.raises(OSError, match="error creating port"):
        RtMidiSystem().open_port("input", "Keys")
    assert not bus.clients


def test_list_that_fails_is_told(bus: Bus, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: Any) -> None:
        raise RuntimeError("no ports\nnow")

    monkeypatch.setattr(_Client, "get_ports", fail)
    with pytest.raises(MidiUnavailable, match="no ports now"):
        RtMidiSystem().port_names("input")
    assert not bus.clients


def test_python_without_rtmidi_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rtmidi", None)
    with pytest.raises(MidiUnavailable, match=r"rtmidi.*MIDI needs Python 3\.11 or 3\.12"):
        RtMidiSystem().port_names("input")


def test_system_that_fails_is_told_on_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(name: str) -> None:
        raise RuntimeError("MidiInCore::initialize: error creating\nclient")

    monkeypatch.setitem(sys.modules, "rtmidi", SimpleNamespace(MidiIn=fail))
    with pytest.raises(MidiUnavailable, match="error creating client"):
        RtMidiSystem().port_names("input")
