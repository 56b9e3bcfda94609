"""Tests of grid controllers on a running show: presses, lights, plugging in and out; over JACK, too."""

import contextlib
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from live.app.services.grid_service import AUTO, GridService, open_grid
from live.base.event_queue import EventQueue
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.events.event import ControlEvent
from live.control.events.events import Launch
from live.control.midi import midi_ports
from live.control.midi.grid_layout import LAYOUTS
from live.control.midi.midi_ports import UnknownPort
from live.control.midi.midi_streams import Direction, Port, Receive
from live.show.venue.venue import VenueMidi
from tests.control.midi.jack import JackPeer, JackServer, jack_server  # noqa: F401 - a fixture
from tests.control.waiting import wait_for
from tests.show.made_show import made_show

NAME = "Launchpad Mini MK3 LPMiniMK3 MI 24:1"
MINI = next(layout for layout in LAYOUTS if layout.name == "Launchpad Mini MK3")


class Device:
    """A Launchpad that can be plugged out; it remembers its lights."""

    system_runs = True

    def __init__(self, name: str = NAME) -> None:
        self.name, self.exists, self.lights, self.exclusive = name, True, dict[tuple[int, int], int](), list[bytes]()
        self.messages = 0
        self.press: Receive = lambda _message: None
        self.blocks: Callable[[], object] = lambda: None

    def open(self, direction: Direction, wanted: str) -> Port:
        if not self.exists:
            raise UnknownPort("no grid controller is connected")
        return self

    def listen(self, receive: Receive) -> None:
        self.press = receive

    def send(self, message: bytes) -> None:
        self.blocks()
        self.messages += 1
        if message[0] == 0xF0:
            self.exclusive.append(message)
        else:
            self.lights[message[0], message[1]] = message[2]

    def close(self) -> None:
        """Nothing."""


class GridNight:
    """A show with a grid controller, frame by frame."""

    def __init__(self, device: Device, name: str = AUTO, opener: Any = None) -> None:
        self.show, self.clock, self.inbox = made_show(), ManualClock(), EventQueue[ControlEvent]()
        self.device = device
        self.service = GridService(
            self.show, self.inbox.add_queue(), self.clock, name, open_by_name=opener or device.open
        )
        self.events: list[ControlEvent] = []
        self.ticks = 0

    def run(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            self.ticks += 1
            self.clock.advance(TICK)
            for event in self.inbox.drain():
                self.events.append(event)
                self.show.apply(event)
            self.show.tick(self.ticks * TICK)
            self.service.frame()

    def until(self, fits: Callable[[], bool]) -> None:
        """Run frames until the threads of the ports have done their part."""

        def step() -> bool:
            self.clock.advance(0.06)  # time passes for the lights
            self.service.frame()
            return fits()

        assert wait_for(step, 40.0)


@pytest.fixture
def night(monkeypatch: pytest.MonkeyPatch) -> Iterator[GridNight]:
    monkeypatch.setattr(midi_ports, "RETRY_INTERVAL", 0.05)
    made = GridNight(Device())
    made.service.start()
    yield made
    made.device.blocks = lambda: None
    made.service.stop()


def lit(device: Device, row: int, column: int) -> int:
    address = next(address for address, place in MINI.pads.items() if place == (row, column))
    return device.lights.get(address, -1)


def test_a_press_is_launched_and_its_light_waits_and_runs(night: GridNight) -> None:
    night.until(lambda: len(night.device.lights) == 80)  # all pads and buttons
    assert night.device.exclusive == [MINI.begin]
    assert night.service.status()["controller"] == "Launchpad Mini MK3"
    idle = lit(night.device, 2, 1)
    assert [lit(night.device, row, 0) for row in range(5)] == [1, 1, 1, 1, 0]  # four steps, in white
    night.device.press([0x90, 62, 127])  # the third step, for the first group
    night.run(2)
    (event,) = night.events
    assert isinstance(event, Launch)
    assert (event.pad, event.group, event.when, event.source) == ("step spin", "front", "measure", "grid")
    seen = set()

    def blinks() -> bool:
        seen.add(lit(night.device, 2, 1))
        return len(seen - {idle}) == 2

    while night.show.danced_beats < 3.5 and not blinks():
        night.run(1)
        assert wait_for(lambda: not night.service._output.waiting, 5.0)
    assert len(seen - {idle}) == 2  # bright and dark
    night.run(150)
    assert set(night.show.launcher.running) == {"steps front"}
    night.until(lambda: lit(night.device, 2, 1) == MINI.colours("runs", None))
    night.device.press([0xB0, 19, 127])
    night.device.press([0xB0, 19, 0])
    night.run(3)
    assert not night.show.launcher.running
    night.until(lambda: lit(night.device, 2, 1) == idle)


def test_a_controller_that_returns_gets_all_lights_again(night: GridNight) -> None:
    night.until(lambda: len(night.device.lights) == 80)
    night.device.exists = False
    night.until(lambda: not night.service._output.connected and not night.service._input.connected)
    night.device.lights.clear()
    night.device.exists = True
    night.until(lambda: len(night.device.lights) == 80)
    assert night.device.exclusive == [MINI.begin] * 2
    assert night.service.problem() == ""


@pytest.mark.long
def test_a_controller_that_hangs_delays_no_frame_and_gets_the_latest_state(night: GridNight) -> None:
    night.until(lambda: len(night.device.lights) == 80)
    go = threading.Event()
    night.device.blocks = partial(go.wait, 20.0)
    night.device.press([0x90, 62, 127])
    before = night.device.messages
    night.run(300)
    assert night.device.messages == before
    assert night.service._output.waiting < 10
    night.device.blocks = lambda: None
    go.set()
    night.until(lambda: lit(night.device, 2, 1) == MINI.colours("runs", None))


def test_the_lights_go_out_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    night = GridNight(Device())
    night.service.start()
    night.until(lambda: len(night.device.lights) == 80)
    night.service.stop()
    assert set(night.device.lights.values()) == {0}
    assert night.device.exclusive[-1] == MINI.end


def test_hostile_messages_and_unknown_devices_do_nothing(night: GridNight) -> None:
    night.until(lambda: len(night.device.lights) == 80)
    for message in ([0x90], [], [0x90, 999, 1], [0xF0] * 3, [0xFF, 0xFF, 0xFF], [0x90, 62, 127] * 3):
        night.device.press(message)
    for _ in range(1000):
        night.device.press([0x90, 62, 127])
    night.run(20)
    assert 0 < len(night.events) <= 256
    assert night.service._input.dropped > 700
    other = GridNight(Device("piano"), "piano")
    other.service.start()
    other.until(lambda: bool(other.service._input.connected))
    other.device.press([0x90, 62, 127])
    other.run(5)
    assert (other.events, other.device.lights) == ([], {})
    assert "not known" in other.service.problem()
    other.service.stop()


def test_venue_and_patch_can_name_it(tmp_path: Path) -> None:
    assert VenueMidi(grid="auto").grid == "auto"
    assert made_show('[midi]\ngrid = "APC"\n').patch.midi.grid == "APC"


def test_a_grid_is_found_by_its_name_among_real_ports(
    jack_server: JackServer,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(midi_ports, "RETRY_INTERVAL", 0.1)
    with pytest.raises(UnknownPort, match="no grid controller"):
        open_grid("input", AUTO)
    lights: dict[tuple[int, int], int] = {}
    with contextlib.ExitStack() as ends:

        def light(message: list[int]) -> None:
            lights[message[0], message[1]] = message[2]

        night = GridNight(Device(), AUTO, opener=open_grid)
        night.service.start()
        ends.callback(night.service.stop)
        lamps = JackPeer("LPMiniMK3 MIDI", "in", "receives", light)
        ends.callback(lamps.close)
        keys = JackPeer("LPMiniMK3 MIDI", "out", "sends")
        ends.callback(keys.close)
        night.until(lambda: len(lights) >= 80 and bool(night.service._input.connected))
        keys.send([0x90, 81, 127])
        night.until(lambda: not night.service._input._arrived.empty() or bool(night.inbox))
        night.run(3)
        assert [event.pad for event in night.events if isinstance(event, Launch)] == ["step sway"]
