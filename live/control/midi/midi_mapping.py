"""MIDI mapping from notes, controllers, pitch bend and so on to the controls of the registry.

A note or program change is a press. A controller without a value to set (a pedal, a foot switch) is pressed when it
rises above the middle. Other controllers set the first number of their control, over its range or the given scale. A
switch is toggled by presses and follows controllers.
"""

from collections.abc import Iterator, Sequence
from typing import Final

from live.control.events.events import ControlEvent
from live.control.midi.channel_messages import MidiHands, Played
from live.control.midi.midi_binding import DEFAULTS, MOVING, BadBinding, Binding, Kind
from live.control.midi.midi_learn import Pickup
from live.control.registry.control import Control, Plain
from live.control.registry.registry import REGISTRY, Values
from live.control.registry.rejections import Rejection

__all__ = ["DEFAULTS", "BadBinding", "Binding", "Kind", "MidiMap", "key", "present"]

SOURCE: Final = "midi"
_Place = tuple[Kind, int, bool]


class MidiMap:
    """Turns channel messages into events. Use from one thread at a time; `take` may be called from any."""

    def __init__(self, bindings: Sequence[Binding] = DEFAULTS, values: Values | None = None) -> None:
        """`values`: the current values, for soft takeover of faders and toggling by pads."""
        self.hands = MidiHands()
        self._values = values or Values()
        self._bindings: dict[_Place, list[Binding]] = {}
        self._down: dict[tuple[_Place, int], bool] = {}
        self._on: dict[tuple[str, object], bool] = {}
        self._pickups: dict[tuple[str, object], Pickup] = {}
        self.moved: dict[tuple[str, object], tuple[float, float, int]] = {}
        """By binding (`key`): the last position of its controller, its time [s], and its channel."""
        self.bindings: tuple[Binding, ...] = ()
        """The active bindings."""
        self.take(bindings)

    def take(self, bindings: Sequence[Binding]) -> None:
        """Replace the bindings; bindings that stay keep their state."""
        found: dict[_Place, list[Binding]] = {}
        for binding in bindings:
            fine = binding.fine or binding.kind == "nrpn"
            found.setdefault((binding.kind, binding.number, fine), []).append(binding)
        self._bindings, self.bindings = found, tuple(bindings)

    def events(self, message: Sequence[int], time: float) -> list[ControlEvent | Rejection]:
        """Return the events for a message received at `time` [s of the show]; empty if it is not mapped."""
        return [made for played in self.hands.played(message) for _, made in self.act(played, time)]

    def act(self, played: Played, time: float) -> list[tuple[Binding, ControlEvent | Rejection]]:
        """Return the events for an action at `time` [s], each with its binding."""
        place = (played.kind, played.number, played.fine)
        bindings = self._bindings.get(place)
        if bindings is None:
            return []
        crossed = played.down != self._down.get((place, played.channel), False)
        self._down[place, played.channel] = played.down
        made: list[tuple[Binding, ControlEvent | Rejection]] = []
        for binding in bindings:
            if binding.channel in (0, played.channel):
                found = self._work(binding, played, crossed or played.kind not in MOVING, time)
                made += ((binding, one) for one in found)
        return made

    def _work(self, binding: Binding, played: Played, crossed: bool, time: float) -> Iterator[ControlEvent | Rejection]:
        """Yield the events of one binding. `crossed`: it has just been pressed or released."""
        slot = binding.slot
        value: Plain | None = None
        if slot is not None:
            self.moved[key(binding)] = (played.share, time, played.channel)
        if slot is not None and slot.type == "float":
            if not self._sets(binding, played, time):
                return
            value = binding.value(played.share)
        elif slot is not None and not binding.toggles:
            if not crossed:
                return
            value = played.down
        elif not crossed or not played.down:
            return
        elif slot is not None:
            value = self._on[key(binding)] = not self._is_on(binding)
        result = _call(binding, value, time)
        if isinstance(result, ControlEvent | Rejection):
            yield result

    def _sets(self, binding: Binding, played: Played, time: float) -> bool:
        """Whether a number is set: by a note's press, or its release if momentary; by a fader after takeover."""
        if binding.kind == "note":
            return played.down or binding.mode == "momentary"
        now = present(binding, self._values) if binding.picks_up else None
        if now is None or isinstance(now, str):
            return True
        pickup = self._pickups.setdefault(key(binding), Pickup())
        fades = bool(binding.values.get("measures"))
        return pickup.takes(played.share, binding.share(float(now)), played.step, time, fades=fades)

    def _is_on(self, binding: Binding) -> bool:
        """Whether a switch is on, by the show's value if known, else by counted presses."""
        now = present(binding, self._values)
        return bool(now) if now is not None else self._on.get(key(binding), False)


def key(binding: Binding) -> tuple[str, object]:
    """Return a key for a binding: its control and what is played."""
    return binding.control, (binding.place, binding.fine)


def present(binding: Binding, values: Values) -> Plain | None:
    """Return the current value of what a binding sets; None if it has no value or groups differ."""
    control, slot = REGISTRY[binding.control], binding.slot
    if slot is None or slot not in control.valued:
        return None
    rows = values.rows(binding.control)
    if control.named:
        whose = binding.values.get(control.arguments[0].name)
        row = next((row for name, row in rows if name == whose), None)
    else:
        group = str(binding.values.get("group", "*")).strip().casefold()
        first = rows[0][1] if group in ("", "*") and rows else None
        row = next((row for name, row in rows if name in ("", group)), first)
    return None if row is None else row[control.valued.index(slot)]


def _call(binding: Binding, value: Plain | None, time: float) -> object:
    """Call the control."""
    control: Control = REGISTRY[binding.control]
    slot = binding.slot
    values = [value if argument is slot else binding.values.get(argument.name) for argument in control.arguments]
    return control.call(values, time, SOURCE)
