"""MidiMap: notes, controllers and program changes that work the controls of the registry.

A note or program change is a press; a controller without a value to set (a pedal, a foot switch) is pressed as it
rises over the middle. Other controllers set the first number of their control, over its range or the one given. A
control with one switch is toggled by presses and follows controllers.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from live.control.control import Argument, Control, Plain
from live.control.events import ControlEvent
from live.control.registry import REGISTRY
from live.control.rejections import Reason, Rejection

Kind = Literal["note", "cc", "program"]

NOTE_OFF, NOTE_ON, CONTROLLER, PROGRAM = 0x8, 0x9, 0xB, 0xC
MIDDLE: Final = 64
MOST: Final = 127
SOURCE: Final = "midi"


class BadBinding(ValueError):
    """A line of a map that cannot work; the message says why and what could."""


@dataclass(frozen=True, slots=True)
class Binding:
    """One line of a map. BadBinding if the control does not exist or cannot be worked so."""

    kind: Kind
    number: int
    control: str
    channel: int = 0
    """1 to 16; 0: all."""
    values: Mapping[str, Plain] = field(default_factory=dict)
    """Arguments of the control that are always the same, by name."""
    scale: tuple[float, float] | None = None
    """What a controller's 0 and 127 mean; the argument's own range if not given."""

    def __post_init__(self) -> None:
        try:
            control = REGISTRY[self.control]
        except KeyError:
            near = [item.address for item in REGISTRY if item.address.startswith(self.control.rpartition("/")[0])]
            known = ", ".join(near or [item.address for item in REGISTRY])
            raise BadBinding(f"no control is called {self.control!r}; there are {known}") from None
        names = [argument.name for argument in control.arguments]
        for name, value in self.values.items():
            argument = next((item for item in control.arguments if item.name == name), None)
            if argument is None:
                raise BadBinding(f"{self.control} has no value {name!r}; it has {', '.join(names) or 'none'}")
            if isinstance(argument.checked(value), Reason):
                raise BadBinding(f"values.{name}: {argument.expected} expected, found {value!r}")
        slot = self.slot
        for argument in control.arguments:
            if argument.default is None and argument.name not in self.values and argument is not slot:
                raise BadBinding(f"{self.control} needs a value: values = {{ {argument.name} = … }}")
        self._check_scale(slot)

    def _check_scale(self, slot: Argument | None) -> None:
        if self.scale is None:
            return
        if self.kind != "cc" or slot is None or slot.type != "float":
            raise BadBinding("scale is for controllers (cc) that set a number")
        if not all(slot.minimum <= bound <= slot.maximum for bound in self.scale):
            raise BadBinding(f"scale: {slot.expected} expected, found {list(self.scale)}")

    @property
    def slot(self) -> Argument | None:
        """The argument that is set by what is played: a controller's number or switch, or what presses toggle."""
        free = [argument for argument in REGISTRY[self.control].arguments if argument.name not in self.values]
        wanted = ("float", "bool") if self.kind == "cc" else ("bool",)
        return next((argument for type_ in wanted for argument in free if argument.type == type_), None)


DEFAULTS: Final = (
    Binding("cc", 64, "/dance/clock/tap"),
    Binding("cc", 66, "/dance/clock/one"),
    Binding("cc", 67, "/dance/clock/hold"),
    Binding("note", 36, "/dance/clock/tap", 16),
    Binding("note", 37, "/dance/clock/one", 16),
    Binding("note", 38, "/dance/clock/half", 16),
    Binding("note", 39, "/dance/clock/double", 16),
    Binding("note", 40, "/dance/clock/hold", 16),
    Binding("note", 41, "/dance/clock/nudge", 16, {"seconds": -0.01}),
    Binding("note", 42, "/dance/clock/nudge", 16, {"seconds": 0.01}),
    Binding("note", 43, "/dance/clock/shift", 16, {"beats": -1.0}),
    Binding("note", 44, "/dance/clock/shift", 16, {"beats": 1.0}),
    Binding("note", 45, "/dance/clock/count_in", 16),
)
"""What works without a map: pedals on any channel (sustain, sostenuto, soft) and notes from C2 (36) on channel 16."""


class MidiMap:
    """Turns channel messages into events. Thread: one at a time."""

    def __init__(self, bindings: Sequence[Binding] = DEFAULTS) -> None:
        self._bindings: dict[tuple[Kind, int], list[Binding]] = {}
        for binding in bindings:
            self._bindings.setdefault((binding.kind, binding.number), []).append(binding)
        self._down: dict[tuple[int, int], bool] = {}
        self._on: dict[int, bool] = {}

    def events(self, message: Sequence[int], time: float) -> list[ControlEvent | Rejection]:
        """What a message that arrived at `time` [s of the show] does; nothing for what is not in the map."""
        if len(message) < 2 or max(message[1:]) > MOST or not 0x80 <= message[0] < 0xF0:
            return []
        status, channel = message[0] >> 4, (message[0] & 15) + 1
        if status == PROGRAM and len(message) == 2:
            return self._press("program", message[1], channel, time)
        if status == NOTE_ON and len(message) == 3 and message[2]:
            return self._press("note", message[1], channel, time)
        if status == CONTROLLER and len(message) == 3:
            return self._move(message[1], message[2], channel, time)
        return []

    def _found(self, kind: Kind, number: int, channel: int) -> list[Binding]:
        return [item for item in self._bindings.get((kind, number), ()) if item.channel in (0, channel)]

    def _press(self, kind: Kind, number: int, channel: int, time: float) -> list[ControlEvent | Rejection]:
        made = (self._pressed(binding, time) for binding in self._found(kind, number, channel))
        return [item for item in made if item is not None]

    def _move(self, number: int, value: int, channel: int, time: float) -> list[ControlEvent | Rejection]:
        down = value >= MIDDLE
        crossed = down != self._down.get((channel, number), False)
        self._down[channel, number] = down
        made: list[ControlEvent | Rejection | None] = []
        for binding in self._found("cc", number, channel):
            slot = binding.slot
            if slot is not None and slot.type == "float":
                low, high = binding.scale or (slot.minimum, slot.maximum)
                made.append(_call(binding, low + (high - low) * value / MOST, time))
            elif crossed and slot is not None:
                made.append(_call(binding, down, time))
            elif crossed and down:
                made.append(_call(binding, None, time))
        return [item for item in made if item is not None]

    def _pressed(self, binding: Binding, time: float) -> ControlEvent | Rejection | None:
        if binding.slot is None:
            return _call(binding, None, time)
        key = id(binding)
        self._on[key] = not self._on.get(key, False)
        return _call(binding, self._on[key], time)


def _call(binding: Binding, value: Plain | None, time: float) -> ControlEvent | Rejection | None:
    """Work the control; replies and releases are nothing here."""
    control: Control = REGISTRY[binding.control]
    slot = binding.slot
    values = [value if argument is slot else binding.values.get(argument.name) for argument in control.arguments]
    result = control.call(values, time, SOURCE)
    return result if isinstance(result, ControlEvent | Rejection) else None
