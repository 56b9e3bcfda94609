"""MidiMap: notes, controllers, bends … that work the controls of the registry.

A note or program change is a press; a controller without a value to set (a pedal, a foot switch) is pressed as it
rises over the middle. Other controllers set the first number of their control, over its range or the one given. A
control with one switch is toggled by presses and follows controllers.
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
    """Turns channel messages into events. Thread: one at a time; `take` from any."""

    def __init__(self, bindings: Sequence[Binding] = DEFAULTS, values: Values | None = None) -> None:
        """`values`: what everything is now, so that faders pick it up and pads turn over what is there."""
        self.hands = MidiHands()
        self._values = values or Values()
        self._bindings: dict[_Place, list[Binding]] = {}
        self._down: dict[tuple[_Place, int], bool] = {}
        self._on: dict[tuple[str, object], bool] = {}
        self._pickups: dict[tuple[str, object], Pickup] = {}
        self.moved: dict[tuple[str, object], tuple[float, float, int]] = {}
        """Where each binding (by `key`) stands as its controller said last, when [s], and on which channel."""
        self.bindings: tuple[Binding, ...] = ()
        """The lines that hold."""
        self.take(bindings)

    def take(self, bindings: Sequence[Binding]) -> None:
        """From now on these hold; what stays keeps its state."""
        found: dict[_Place, list[Binding]] = {}
        for binding in bindings:
            fine = binding.fine or binding.kind == "nrpn"
            found.setdefault((binding.kind, binding.number, fine), []).append(binding)
        self._bindings, self.bindings = found, tuple(bindings)

    def events(self, message: Sequence[int], time: float) -> list[ControlEvent | Rejection]:
        """What a message that arrived at `time` [s of the show] does; nothing for what is not in the map."""
        return [made for played in self.hands.played(message) for _, made in self.act(played, time)]

    def act(self, played: Played, time: float) -> list[tuple[Binding, ControlEvent | Rejection]]:
        """What something that was played at `time` [s] does, each by a line of the map."""
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
        """What a binding makes of it. `crossed`: whether it has just been pressed or let go."""
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
        """Whether a number is set: notes by their strokes, and let go if they are momentary; faders that have it."""
        if binding.kind == "note":
            return played.down or binding.mode == "momentary"
        now = present(binding, self._values) if binding.picks_up else None
        if now is None or isinstance(now, str):
            return True
        pickup = self._pickups.setdefault(key(binding), Pickup())
        fades = bool(binding.values.get("measures"))
        return pickup.takes(played.share, binding.share(float(now)), played.step, time, fades=fades)

    def _is_on(self, binding: Binding) -> bool:
        """How a switch stands: as the show says, else as presses have left it."""
        now = present(binding, self._values)
        return bool(now) if now is not None else self._on.get(key(binding), False)


def key(binding: Binding) -> tuple[str, object]:
    """A binding by what is played and what it works."""
    return binding.control, (binding.place, binding.fine)


def present(binding: Binding, values: Values) -> Plain | None:
    """What a binding sets, as it is now; None where that has no value, or groups have different ones."""
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
    """Work the control."""
    control: Control = REGISTRY[binding.control]
    slot = binding.slot
    values = [value if argument is slot else binding.values.get(argument.name) for argument in control.arguments]
    return control.call(values, time, SOURCE)
