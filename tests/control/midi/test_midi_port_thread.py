"""The thread that keeps a MIDI port open: what comes of ports that go, come back, refuse, or hang."""

from collections.abc import Callable
from typing import cast

import pytest

from live.control.midi.midi_ports import PortThread
from live.control.midi.midi_streams import Port, Receive


class MadePort:
    """A port that can be unplugged."""

    system_runs = True

    def __init__(self, name: str, refuses: bool = False) -> None:
        self.name, self.exists, self.closed, self.refuses = name, True, 0, refuses

    def listen(self, receive: Receive) -> None:
        """Nothing ever comes."""

    def send(self, message: bytes) -> None:
        """It goes nowhere."""

    def close(self) -> None:
        self.closed += 1


class Cares(PortThread):
    """Looks after its port whenever it is told to, by nobody's thread."""

    def __init__(self, open_by_name: Callable[[str], Port]) -> None:
        super().__init__("pads", "midi test", open_by_name)

    def care(self) -> tuple[str, str, int]:
        """What is known of the port after one look."""
        self._maintain()
        return self.connected, self.problem, self.opened

    def _on_open(self, port: Port) -> None:
        if cast(MadePort, port).refuses:
            raise OSError("it is  taken\nby another")


@pytest.fixture
def plugged() -> list[MadePort]:
    """The ports that are plugged in; the first one is found."""
    return []


@pytest.fixture
def thread(plugged: list[MadePort]) -> Cares:
    def open_by_name(name: str) -> Port:
        if not plugged:
            raise OSError(f"no port {name}")
        return plugged[0]

    return Cares(open_by_name)


def test_a_port_is_waited_for_lost_and_found(thread: Cares, plugged: list[MadePort]) -> None:
    assert thread.care() == ("", "no port pads", 0)
    assert thread.status() == {"port": "pads", "problem": "no port pads"}
    first = MadePort("Pads 24:0")
    plugged.append(first)
    for _ in range(3):
        assert thread.care() == ("Pads 24:0", "", 1)
    assert thread.status() == {"port": "Pads 24:0", "problem": ""}
    first.exists = False
    plugged[0] = MadePort("Pads 28:0")
    assert thread.care() == ("Pads 28:0", "", 2)  # in the same look
    plugged[0].exists = False
    plugged.clear()
    assert thread.care() == ("", "no port pads", 2)
    assert first.closed == 1


def test_a_port_that_cannot_be_begun_with_is_closed_and_tried_again(thread: Cares, plugged: list[MadePort]) -> None:
    plugged.append(MadePort("Pads 24:0", refuses=True))
    assert thread.care() == ("", "it is taken by another", 0)
    assert plugged[0].closed == 1
    plugged[0].refuses = False
    assert thread.care() == ("Pads 24:0", "", 1)


def test_stop_is_harmless_before_start(thread: Cares) -> None:
    thread.stop()
