"""MIDI mapping from notes, controllers, pitch bend and so on to the controls of the registry.

A note or program change is a press. A controller without a value to set (a pedal, a foot switch) is pressed when it
rises above the middle. Other controllers set the first number of their control, over its range or the given scale. A
switch is toggled by presses and follows controllers.
"""

from collections.abc import Iterator, Sequence
from typing import Final

from live.control.events.events import ControlEvent
from live.control.midi.channel_messages import ChannelMessageDecoder, MidiAction
from live.control.midi.midi_binding import CONTINUOUS_KINDS, DEFAULTS, Binding, Kind
from live.control.midi.midi_learn import Pickup
from live.control.registry.control import ArgumentValue, Control
from live.control.registry.registry import REGISTRY, Values
from live.control.registry.rejections import Rejection

SOURCE: Final = "midi"
_Trigger = tuple[Kind, int, bool]


class MidiMap:
    """Turns channel messages into events. Use from one thread at a time; `events` may be called from any."""

    def __init__(self, bindings: Sequence[Binding] = DEFAULTS, values: Values | None = None) -> None:
        """`values`: the current values, for soft takeover of faders and toggling by pads."""
        self.decoder = ChannelMessageDecoder()
        self._values = values or Values()
        self._bindings: dict[_Trigger, list[Binding]] = {}
        self._pressed: dict[tuple[_Trigger, int], bool] = {}
        self._switches: dict[tuple[str, object], bool] = {}
        self._pickups: dict[tuple[str, object], Pickup] = {}
        self.last_positions: dict[tuple[str, object], tuple[float, float, int]] = {}
        """By binding (`key`): the last position of its controller, its time [s], and its channel."""
        self.bindings: tuple[Binding, ...] = ()
        """The active bindings."""
        self.set_bindings(bindings)

    def set_bindings(self, bindings: Sequence[Binding]) -> None:
        """Replace the bindings; bindings that stay keep their state."""
        found: dict[_Trigger, list[Binding]] = {}
        for binding in bindings:
            fine = binding.fine or binding.kind == "nrpn"
            found.setdefault((binding.kind, binding.number, fine), []).append(binding)
        self._bindings, self.bindings = found, tuple(bindings)

    def events(self, message: Sequence[int], time: float) -> list[ControlEvent | Rejection]:
        """Return the events for a message received at `time` [s of the show]; empty if it is not mapped."""
        return [made for played in self.decoder.decode(message) for _, made in self.apply(played, time)]

    def apply(self, played: MidiAction, time: float) -> list[tuple[Binding, ControlEvent | Rejection]]:
        """Return the events for an action at `time` [s], each with its binding."""
        place = (played.kind, played.number, played.fine)
        bindings = self._bindings.get(place)
        if bindings is None:
            return []
        crossed = played.down != self._pressed.get((place, played.channel), False)
        self._pressed[place, played.channel] = played.down
        made: list[tuple[Binding, ControlEvent | Rejection]] = []
        for binding in bindings:
            if binding.channel in (0, played.channel):
                found = self._apply_binding(binding, played, crossed or played.kind not in CONTINUOUS_KINDS, time)
                made += ((binding, one) for one in found)
        return made

    def _apply_binding(
        self, binding: Binding, played: MidiAction, crossed: bool, time: float
    ) -> Iterator[ControlEvent | Rejection]:
        """Yield the events of one binding. `crossed`: it has just been pressed or released."""
        slot = binding.slot
        value: ArgumentValue | None = None
        if slot is not None:
            self.last_positions[binding_key(binding)] = (played.position, time, played.channel)
        if slot is not None and slot.type == "float":
            if not self._sets_number(binding, played, time):
                return
            value = binding.value(played.position)
        elif slot is not None and not binding.toggles:
            if not crossed:
                return
            value = played.down
        elif not crossed or not played.down:
            return
        elif slot is not None:
            value = self._switches[binding_key(binding)] = not self._is_on(binding)
        result = _call(binding, value, time)
        if isinstance(result, ControlEvent | Rejection):
            yield result

    def _sets_number(self, binding: Binding, played: MidiAction, time: float) -> bool:
        """Whether a number is set: by a note's press, or its release if momentary; by a fader after takeover."""
        if binding.kind == "note":
            return played.down or binding.mode == "momentary"
        now = current_value(binding, self._values) if binding.uses_pickup else None
        if now is None or isinstance(now, str):
            return True
        pickup = self._pickups.setdefault(binding_key(binding), Pickup())
        fades = bool(binding.values.get("measures"))
        return pickup.update(played.position, binding.position(float(now)), played.step, time, fades=fades)

    def _is_on(self, binding: Binding) -> bool:
        """Whether a switch is on, by the show's value if known, else by counted presses."""
        now = current_value(binding, self._values)
        return bool(now) if now is not None else self._switches.get(binding_key(binding), False)


def binding_key(binding: Binding) -> tuple[str, object]:
    """Return a key for a binding: its control and what is played."""
    return binding.control, (binding.trigger, binding.fine)


def current_value(binding: Binding, values: Values) -> ArgumentValue | None:
    """Return the current value of what a binding sets; None if it has no value or groups differ."""
    control, slot = REGISTRY[binding.control], binding.slot
    if slot is None or slot not in control.value_arguments:
        return None
    rows = values.rows(binding.control)
    if control.named:
        whose = binding.values.get(control.arguments[0].name)
        row = next((row for name, row in rows if name == whose), None)
    else:
        group = str(binding.values.get("group", "*")).strip().casefold()
        first = rows[0][1] if group in ("", "*") and rows else None
        row = next((row for name, row in rows if name in ("", group)), first)
    return None if row is None else row[control.value_arguments.index(slot)]


def _call(binding: Binding, value: ArgumentValue | None, time: float) -> object:
    """Call the control."""
    control: Control = REGISTRY[binding.control]
    slot = binding.slot
    values = [value if argument is slot else binding.values.get(argument.name) for argument in control.arguments]
    return control.call(values, time, SOURCE)
