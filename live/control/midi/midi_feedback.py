"""MIDI feedback: sends the show's values to pad lights and motor faders, and the output port for it.

A pad gets the state of its switch after every change. A fader gets its position, except while it is being moved and
for a value that it has just set.
"""

import contextlib
import queue
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Final

from live.clock.time_source import Clock
from live.control.midi import midi_ports
from live.control.midi.channel_messages import (
    BEND,
    CONTROLLER,
    DATA,
    DATA_FINE,
    MAX_7_BIT,
    MAX_14_BIT,
    MIDDLE,
    NOTE_ON,
    NRPN,
    NRPN_FINE,
)
from live.control.midi.midi_binding import Binding
from live.control.midi.midi_mapping import MidiMap, binding_key, current_value
from live.control.midi.midi_ports import Open, PortThread, error_text, open_output
from live.control.registry.registry import Values

MOVE_HOLD: Final = 1.0
"""Seconds after its last move in which a fader gets no feedback."""
UPDATE_INTERVAL: Final = 0.05
"""Minimum interval between two updates [s] ..."""
MAX_BINDINGS: Final = 48
"""... and maximum number of bindings in one: the capacity of a MIDI 1.0 cable in that time."""


class MidiFeedback:
    """Encodes the values of a map's bindings. Use from the show's thread; the map may be used by its own meanwhile."""

    def __init__(self, midi_map: MidiMap, values: Values) -> None:
        self._map, self._values = midi_map, values
        self._by_control: dict[str, list[Binding]] = {}
        self._all: dict[tuple[str, object], Binding] = {}
        self._due: dict[tuple[str, object], Binding] = {}
        self._last_sent: dict[tuple[str, object], tuple[int, ...]] = {}
        self._channels: dict[tuple[str, object], int] = {}  # last channel played
        self._next = 0.0
        self.sent = 0
        """Number of values sent."""

    def set_bindings(self, bindings: Sequence[Binding]) -> None:
        """Replace the bindings and queue all their values."""
        self._by_control, self._due, self._all = {}, {}, {}
        for binding in bindings:
            if binding.kind not in ("program", "pressure") and binding.slot is not None:
                self._by_control.setdefault(binding.control, []).append(binding)
                self._all[binding_key(binding)] = binding
        self._last_sent = {name: told for name, told in self._last_sent.items() if name in self._all}
        self.mark_changed(self._by_control)

    def mark_changed(self, addresses: Iterable[str]) -> None:
        """Mark the values at these addresses as changed."""
        for address in addresses:
            for binding in self._by_control.get(address, ()):
                self._due[binding_key(binding)] = binding

    def resend_all(self) -> None:
        """Queue all values again, for a device that was connected again."""
        self._last_sent.clear()
        self.mark_changed(self._by_control)

    def due_messages(self, now: float) -> list[bytes]:
        """Return the messages to send at `now` [s]."""
        if now < self._next:
            return []
        self._next = now + UPDATE_INTERVAL
        moved = self._map.last_positions.copy()
        for name, (_, at, _) in moved.items():
            if now - at >= MOVE_HOLD and name in self._all:  # no longer moved, and perhaps off the value
                self._due[name] = self._all[name]
        messages: list[bytes] = []
        for name, binding in list(self._due.items())[:MAX_BINDINGS]:
            share, at, channel = moved.get(name, (None, now - MOVE_HOLD, self._channels.get(name, 1)))
            self._channels[name] = channel
            if now - at < MOVE_HOLD and binding.kind != "note":
                continue
            del self._due[name]
            self._map.last_positions.pop(name, None)
            value = current_value(binding, self._values)
            if value is None or isinstance(value, str):
                continue
            numbers = _value_bytes(binding, float(value))
            stands = (
                self._last_sent.get(name)
                if share is None or binding.kind == "note"
                else _position_bytes(binding, share)
            )
            self._last_sent[name] = numbers
            if numbers != stands:
                messages += _messages(binding, binding.channel or channel, numbers)
                self.sent += 1
        return messages


def _value_bytes(binding: Binding, value: float) -> tuple[int, ...]:
    """Return the data bytes for a value."""
    slot = binding.slot
    if slot is not None and slot.type == "bool":
        return (binding.lit[bool(value)],) if binding.kind == "note" else _position_bytes(binding, float(bool(value)))
    return _position_bytes(binding, binding.position(value))


def _position_bytes(binding: Binding, share: float) -> tuple[int, ...]:
    """Return the data bytes for a position, the upper seven bits first if there are 14."""
    if binding.kind == "bend":
        bend = round(2 * share * MIDDLE if share <= 0.5 else MIDDLE + (2 * share - 1) * (MAX_14_BIT - MIDDLE))
        return divmod(bend, 128)
    if binding.fine or binding.kind == "nrpn":
        return divmod(round(share * MAX_14_BIT), 128)
    return (round(share * MAX_7_BIT),)


def _messages(binding: Binding, channel: int, numbers: tuple[int, ...]) -> Iterator[bytes]:
    controller = CONTROLLER << 4 | channel - 1
    if binding.kind == "note":
        yield bytes((NOTE_ON << 4 | channel - 1, binding.number, numbers[0]))
    elif binding.kind == "bend":
        yield bytes((BEND << 4 | channel - 1, numbers[1], numbers[0]))
    elif binding.kind == "nrpn":
        upper, lower = divmod(binding.number, 128)
        for number, value in ((NRPN, upper), (NRPN_FINE, lower), (DATA, numbers[0]), (DATA_FINE, numbers[1])):
            yield bytes((controller, number, value))
    else:
        yield bytes((controller, binding.number, numbers[0]))
        if binding.fine:
            yield bytes((controller, binding.number + 32, numbers[1]))


CHECK_INTERVAL: Final = 0.2
"""Seconds between checks whether an open port still exists."""
MAX_WAITING: Final = 512
"""Maximum number of waiting messages; more are counted and dropped."""
QUEUE_TIMEOUT: Final = 0.1


class MidiOutput(PortThread):
    """Sends messages to one MIDI port by name, from its own thread.

    Call `send` from the show's thread, `start` and `stop` from the creating thread.
    """

    def __init__(self, name: str, clock: Clock, *, open_by_name: Open = open_output) -> None:
        """Open nothing yet; a missing port is opened as soon as it appears."""
        super().__init__(name, "midi out", open_by_name)
        self.sent = 0
        self.dropped = 0
        """Number of messages dropped because the queue was full or no port was open."""
        self._clock = clock
        self._waiting: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def send(self, message: bytes) -> None:
        """Queue a message; never blocks."""
        if self._waiting.qsize() >= MAX_WAITING:
            self.dropped += 1
            return
        self._waiting.put(message)

    @property
    def waiting(self) -> int:
        """Number of messages that are not sent yet."""
        return self._waiting.qsize()

    def status(self) -> dict[str, Any]:
        """Return figures for the status line."""
        return super().status() | {"sent": self.sent, "dropped": self.dropped}

    def _run(self) -> None:
        due = self._clock.now()
        try:
            while not self._stop.is_set():
                if self._clock.now() >= due:
                    self._maintain()
                    due = self._clock.now() + (midi_ports.RETRY_INTERVAL if self._port is None else CHECK_INTERVAL)
                with contextlib.suppress(queue.Empty):
                    self._send_now(self._waiting.get(timeout=QUEUE_TIMEOUT))
        finally:
            with contextlib.suppress(queue.Empty):
                while self._port is not None:  # what was sent before the stop
                    self._send_now(self._waiting.get_nowait())
            self._disconnect("")

    def _send_now(self, message: bytes) -> None:
        if self._port is None:
            self.dropped += 1
            return
        try:
            self._port.send(message)
            self.sent += 1
        except Exception as error:  # the port is gone
            self.dropped += 1
            self._disconnect(error_text(error))
