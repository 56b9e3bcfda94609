"""Tests of the thread that keeps a MIDI port open: lost, found and refusing ports."""

from collections.abc import Callable
from typing import cast

import pytest

from live.control.midi.midi_ports import PortThread
from live.control.midi.midi_streams import Port, Receive


class FakePort:
    """A port that can be unplugged."""

    system_runs = True

    def __init__(self, name: str, refuses: bool = False) -> None:
        self.name, self.exists, self.closed, self.refuses = name, True, 0, refuses

    def listen(self, receive: Receive) -> None:
        """Receives nothing."""

    def send(self, message: bytes) -> None:
        """Discards the message."""

    def close(self) -> None:
        self.closed += 1


class ManualPortThread(PortThread):
    """A port thread whose checks the test runs itself."""

    def __init__(self, open_by_name: Callable[[str], Port]) -> None:
        super().__init__("pads", "midi test", open_by_name)

    def care(self) -> tuple[str, str, int]:
        """The state of the port after one check."""
        self._maintain()
        return self.connected, self.problem, self.opened

    def _on_open(self, port: Port) -> None:
        if cast(FakePort, port).refuses:
            raise OSError("it is  taken\nby another")


@pytest.fixture
def plugged_ports() -> list[FakePort]:
    """The ports that are plugged in; the first one is opened."""
    return []


@pytest.fixture
def thread(plugged_ports: list[FakePort]) -> ManualPortThread:
    def open_by_name(name: str) -> Port:
        if not plugged_ports:
            raise OSError(f"no port {name}")
        return plugged_ports[0]

    return ManualPortThread(open_by_name)


def test_port_is_opened_lost_and_reopened(thread: ManualPortThread, plugged_ports: list[FakePort]) -> None:
    assert thread.care() == ("", "no port pads", 0)
    assert thread.status() == {"port": "pads", "problem": "no port pads"}
    first = FakePort("Pads 24:0")
    plugged_ports.append(first)
    for _ in range(3):
        assert thread.care() == ("Pads 24:0", "", 1)
    assert thread.status() == {"port": "Pads 24:0", "problem": ""}
    first.exists = False
    plugged_ports[0] = FakePort("Pads 28:0")
    assert thread.care() == ("Pads 28:0", "", 2)  # in the same look
    plugged_ports[0].exists = False
    plugged_ports.clear()
    assert thread.care() == ("", "no port pads", 2)
    assert first.closed == 1


def test_failing_port_is_closed_and_retried(thread: ManualPortThread, plugged_ports: list[FakePort]) -> None:
    plugged_ports.append(FakePort("Pads 24:0", refuses=True))
    assert thread.care() == ("", "it is taken by another", 0)
    assert plugged_ports[0].closed == 1
    plugged_ports[0].refuses = False
    assert thread.care() == ("Pads 24:0", "", 1)


def test_stop_is_harmless_before_start(thread: ManualPortThread) -> None:
    thread.stop()
