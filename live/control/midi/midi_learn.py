"""MIDI learn and soft takeover.

MIDI learn binds a control to the controller that is moved next: a key or pad at once; a fader, wheel or pitch bend
when it is the first to move farther than noise. A controller that moves together with the one 32 higher is learned as
a 14-bit pair. With soft takeover (`Pickup`) a fader has no effect until it reaches the current value.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from live.control.midi.channel_messages import MidiAction
from live.control.midi.midi_binding import CONTINUOUS_KINDS, BadBinding, Binding, Kind
from live.control.registry.control import ArgumentValue, Control
from live.control.registry.registry import REGISTRY

MIN_MOVEMENT: Final = 0.05
"""Share of its range that a fader must move to be learned."""
RESERVED_CONTROLLERS: Final = frozenset((6, 38, 96, 97, 98, 99, 100, 101, *range(120, 128)))
"""Controllers with a fixed meaning: data entry, parameter numbers, channel modes."""


@dataclass(slots=True)
class _Range:
    """Range over which a controller has moved."""

    low: float
    high: float


_FADER: Final = MidiAction("cc", 0, 1, 1.0, 1.0, True)
_KEY: Final = MidiAction("note", 0, 1, 1.0, 1.0, True)


class MidiLearn:
    """Learns a binding for one control. Use from one thread at a time."""

    def __init__(self, control: str, values: Mapping[str, ArgumentValue]) -> None:
        """Raise BadBinding if no binding is possible for the control with these values."""
        self.control, self.values = control, dict(values)
        self._ranges: dict[tuple[Kind, int, int], _Range] = {}
        if self._try_binding(_KEY) is None:
            self._binding(_FADER)

    def process(self, played: list[MidiAction]) -> Binding | None:
        """Return the binding once `played`, the actions in one message, decide it; else None."""
        for one in played:
            if one.fine and one.kind == "cc":
                continue  # its 7-bit action comes in the same list
            if one.kind == "cc" and one.number in RESERVED_CONTROLLERS:
                continue
            if one.kind in CONTINUOUS_KINDS:
                found = self._moved(one)
            else:
                found = self._try_binding(one) if one.down else None
            if found is not None:
                return found
        return None

    def _moved(self, one: MidiAction) -> Binding | None:
        way = self._ranges.get((one.kind, one.number, one.channel))
        if way is None:
            self._ranges[one.kind, one.number, one.channel] = _Range(one.position, one.position)
            pressed = one.kind == "cc" and one.position == 1.0 and not self._is_lower(one)
            return self._try_binding(one) if pressed and self._is_switch else None
        way.low, way.high = min(way.low, one.position), max(way.high, one.position)
        if way.high - way.low < MIN_MOVEMENT or self._is_lower(one):
            return None
        return self._try_binding(one)

    def _is_lower(self, one: MidiAction) -> bool:
        """Whether it is the lower half of a pair, which moves more but means less."""
        upper = ("cc", one.number - 32, one.channel)
        return one.kind == "cc" and 32 <= one.number < 64 and upper in self._ranges

    @property
    def _is_switch(self) -> bool:
        """Whether a single message of a button can operate the control."""
        try:
            slot = self._binding(_FADER).slot
        except BadBinding:
            return False
        return slot is None or slot.type != "float"

    def _try_binding(self, one: MidiAction) -> Binding | None:
        try:
            return self._binding(one)
        except BadBinding:  # unsuitable, such as a pad for a number or a fader for a name
            return None

    def _binding(self, one: MidiAction) -> Binding:
        fine = one.kind == "cc" and one.number < 32 and ("cc", one.number + 32, one.channel) in self._ranges
        try:
            return Binding(one.kind, one.number, self.control, one.channel, self.values, fine=fine)
        except BadBinding:
            if one.kind != "note":
                raise
            return Binding(one.kind, one.number, self.control, one.channel, self.values, velocity=True)


def parse_values(address: str, given: Sequence[str]) -> dict[str, ArgumentValue]:
    """Return the values of a control that `given` names; BadBinding for unknown ones."""
    control = REGISTRY.find(address)
    if control is None:
        near = [item.address for item in REGISTRY if item.address.startswith(address.rpartition("/")[0] or "/")]
        raise BadBinding(f"no control is called {address!r}; there are {', '.join(near[:12]) or 'others'}")
    values: dict[str, ArgumentValue] = {}
    for word in given:
        name, said, value = word.partition("=")
        if said and any(argument.name == name.strip() for argument in control.arguments):
            values[name.strip()] = _value(control, name.strip(), value.strip())
            continue
        free = (one for one in control.arguments if one.type in ("name", "text") and one.name not in values)
        argument = next(free, None)
        if argument is None:
            names = ", ".join(one.name for one in control.arguments) or "none"
            raise BadBinding(f"{address} takes no text {word!r}; its values are {names}: write name=value")
        values[argument.name] = word
    return values


def _value(control: Control, name: str, text: str) -> ArgumentValue:
    argument = next(one for one in control.arguments if one.name == name)
    if argument.type in ("name", "text"):
        return text
    if argument.type == "bool":
        return text.casefold() in ("1", "true", "yes", "on")
    try:
        return float(text)
    except ValueError:
        raise BadBinding(f"{name}: {argument.expected} expected, found {text!r}") from None


SETTLE_TIME: Final = 1.0
"""Seconds that a value may take to have effect; until then a different value does not count as set by others."""
TOLERANCE_STEPS: Final = 2.0
"""Tolerance in steps of the fader within which two values are equal."""


@dataclass(slots=True)
class Pickup:
    """Soft takeover of one fader; all values are fader positions, 0 to 1. Use from one thread at a time."""

    engaged: bool = False
    """Whether the fader controls the value."""
    sent: float = 0.0
    at: float = 0.0
    """The last value it set, and when [s]."""
    value_before: float = 0.0
    """The current value at that time; a fading value lies between the two."""
    previous: float | None = None
    """The fader's previous position."""

    def update(self, share: float, present: float, step: float, time: float, *, fades: bool = False) -> bool:
        """Update with the fader at `share` and the value at `present`; return whether the fader sets the value.

        `fades`: the value changes gradually after it is set.
        """
        before, self.previous = self.previous, share
        near = TOLERANCE_STEPS * step
        if self.engaged and time - self.at > SETTLE_TIME:
            low, high = sorted((self.value_before, self.sent)) if fades else (self.sent, self.sent)
            self.engaged = low - near <= present <= high + near
        if not self.engaged:
            crossed = before is not None and min(before, share) <= present <= max(before, share)
            self.engaged = crossed or abs(share - present) <= near
        if self.engaged:
            self.sent, self.at, self.value_before = share, time, present
        return self.engaged
