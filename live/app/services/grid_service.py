"""Grid controllers (Launchpad, APC): the show's pads on their pads, with lights.

Their ports have threads of their own. A frame passes on presses, and at most twenty times a second the lights that have
changed; while earlier ones are not sent yet it sends none, so that the latest state is the next one sent.
"""

import colorsys
import queue
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

from live.base.event_queue import PriorityQueue
from live.clock.time_source import Clock
from live.control.events.event import ControlEvent
from live.control.midi import midi_ports
from live.control.midi.grid_layout import Address, GridLayout, layout_of
from live.control.midi.grid_surface import GridSurface
from live.control.midi.midi_feedback import MidiOutput
from live.control.midi.midi_ports import Open, PortThread, UnknownPort, open_port, port_names
from live.control.midi.midi_streams import Direction, Port
from live.control.registry.registry import REGISTRY
from live.show.desk.launch_report import columns, launch_facts, pad_facts

if TYPE_CHECKING:
    from live.show.show import Show

AUTO: Final = "auto"
"""Instead of a port's name: the first grid controller that is there."""
INTERVAL: Final = 0.05
"""Minimum time between two updates of the lights [s] ..."""
MAX_LIGHTS: Final = 48
"""... and maximum number of lights in one: the capacity of a MIDI 1.0 cable in that time."""
MAX_PRESSES: Final = 256
"""Maximum number of presses that wait for a frame; more are dropped."""
GREY: Final = 0.15
"""Colours with less saturation are white."""


def open_grid(direction: Direction, wanted: str) -> Port:
    """Open the port of a grid controller by its name, or for `auto` the first one; UnknownPort if there is none."""
    if wanted != AUTO:
        return open_port(direction, wanted)
    for names in port_names(direction).values():
        for name in names:
            if layout_of(name) is not None:
                return open_port(direction, name)
    raise UnknownPort("no grid controller is connected")


class GridInput(PortThread):
    """Receives the presses of a grid controller. `take`: call from the show's thread."""

    def __init__(self, name: str, open_by_name: Open) -> None:
        super().__init__(name, "grid in", open_by_name)
        self.dropped = 0
        """Number of presses dropped because nobody took them."""
        self._arrived: queue.SimpleQueue[Sequence[int]] = queue.SimpleQueue()

    def receive(self, message: Sequence[int]) -> None:
        """Queue a message. Call from any thread; never blocks."""
        if len(message) != 3:
            return
        if self._arrived.qsize() >= MAX_PRESSES:
            self.dropped += 1
            return
        self._arrived.put(message)

    def take(self) -> Sequence[int] | None:
        """Return the next message; None if there is none."""
        try:
            return self._arrived.get_nowait()
        except queue.Empty:
            return None

    def _on_open(self, port: Port) -> None:
        port.listen(self.receive)

    def _run(self) -> None:
        try:
            while True:
                self._maintain()
                if self._stop.wait(midi_ports.RETRY_INTERVAL if self._port is None else 0.2):
                    return
        finally:
            self._close()


class GridService:
    """One grid controller of a show. Thread: the show's."""

    def __init__(
        self,
        show: "Show",
        inbox: PriorityQueue[ControlEvent],
        clock: Clock,
        name: str,
        *,
        open_by_name: Callable[[Direction, str], Port] = open_grid,
    ) -> None:
        """`name`: of its port, or `auto`; `inbox`: where its commands go. Opens nothing yet."""
        self._show, self._inbox, self._clock, self._name = show, inbox, clock, name
        self._input = GridInput(name, lambda wanted: open_by_name("input", wanted))
        self._output = MidiOutput(name, clock, open_by_name=lambda wanted: open_by_name("output", wanted))
        self.surface = GridSurface()
        self._sent: dict[Address, bytes] = {}
        self._opened = 0
        self._layout: GridLayout | None = None  # of the output that is open
        self._measure: int | None = None
        self._due = 0.0

    def start(self) -> None:
        """Open the ports; missing ports are opened when they appear."""
        self._input.start()
        self._output.start()

    def stop(self) -> None:
        """Switch the lights off, give the controller back and close the ports."""
        if self._layout is not None:
            for address in self._sent:
                self._output.send(self._layout.light(address, "off"))
            if self._layout.end:
                self._output.send(self._layout.end)
        self._input.stop()
        self._output.stop()

    def update_patch(self, _patch: object) -> None:
        """Show the pads of another patch."""
        self._measure = None

    def frame(self) -> None:
        """Pass on presses and lights, after each frame."""
        self._take_presses()
        now = self._clock.now()
        if now >= self._due:
            self._due = now + INTERVAL
            self._light()

    def _take_presses(self) -> None:
        layout = layout_of(self._input.connected)
        for _ in range(MAX_PRESSES):
            message = self._input.take()
            if message is None:
                return
            pressed = None if layout is None else layout.press(message)
            if layout is None or pressed is None:
                continue
            self._read_pads()
            call = self.surface.press(layout, *pressed)
            made = None if call is None else REGISTRY.call(*call, self._clock.now(), "grid")
            if isinstance(made, ControlEvent):
                self._inbox.put(made)

    def _read_pads(self) -> None:
        """Read the pads, once a measure and after an edit."""
        if self._measure == self._show.span.number:
            return
        self._measure = self._show.span.number
        self.surface.pads, self.surface.columns = pad_facts(self._show), columns(self._show)
        hues = {group.name: _hue(group.colour) for group in self._show.patch.group}
        self.surface.hues = {**hues, "*": None}

    def _light(self) -> None:
        """Send the lights that have changed, unless earlier ones still wait."""
        output = self._output
        if output.opened != self._opened:
            self._opened, self._layout = output.opened, layout_of(output.connected)
            self._sent.clear()
            if self._layout is not None and self._layout.begin:
                output.send(self._layout.begin)
        layout = self._layout
        if not output.connected or layout is None or output.waiting:
            return
        self._read_pads()
        on = self._show.danced_beats % 1.0 < 0.5
        wanted = self.surface.lights(layout, launch_facts(self._show), on=on)
        changed = 0
        for address, (light, hue) in wanted.items():
            message = layout.light(address, light, hue)
            if self._sent.get(address) != message and changed < MAX_LIGHTS:
                changed += 1
                self._sent[address] = message
                output.send(message)

    def problem(self) -> str:
        """Return why there is no grid, in words; empty if there is one, or any may come."""
        part = next((part for part in (self._input, self._output) if part.problem), None)
        if part is not None:
            return "" if self._name == AUTO else f"grid {self._name!r}: {part.problem}"
        if self._input.connected and layout_of(self._input.connected) is None:
            return f"grid {self._input.connected!r}: this controller is not known"
        return ""

    def status(self) -> dict[str, Any]:
        """Return figures for the status line."""
        layout = layout_of(self._input.connected)
        return {
            "controller": "" if layout is None else layout.name, "page": self.surface.page, "when": self.surface.when,
            "in": self._input.status(), "out": self._output.status(),
        }  # fmt: skip


def _hue(colour: Sequence[float] | None) -> float | None:
    if colour is None:
        return None
    hue, saturation, _ = colorsys.rgb_to_hsv(*colour)
    return hue if saturation >= GREY else None
