"""MidiLearn: finds out which controller somebody moves, for a control that is to be worked by it.

A key or pad that is struck is meant at once; a fader, wheel or bend once it has moved far enough that it cannot
be noise: the first to have gone so far. A controller whose partner 32 higher moves along is a pair of 14 bits.

Pickup: soft take-over: a fader does nothing until it comes to the value that is there, so that nothing jumps.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from live.control.midi.channel_messages import Played
from live.control.midi.midi_binding import MOVING, BadBinding, Binding, Kind
from live.control.registry.control import Control, Plain
from live.control.registry.registry import REGISTRY

WIGGLED: Final = 0.05
"""Share of its way that a fader must have gone."""
RESERVED_CONTROLLERS: Final = frozenset((6, 38, 96, 97, 98, 99, 100, 101, *range(120, 128)))
"""Controllers that mean something of their own: data entry, numbers of parameters, modes of the channel."""


@dataclass(slots=True)
class _Way:
    """How far something has moved."""

    low: float
    high: float


_FADER: Final = Played("cc", 0, 1, 1.0, 1.0, True)
_KEY: Final = Played("note", 0, 1, 1.0, 1.0, True)


class MidiLearn:
    """Listens for one control. Thread: one at a time."""

    def __init__(self, control: str, values: Mapping[str, Plain]) -> None:
        """BadBinding if nothing could ever work the control so."""
        self.control, self.values = control, dict(values)
        self._ways: dict[tuple[Kind, int, int], _Way] = {}
        if self._made(_KEY) is None:
            self._binding(_FADER)

    def hear(self, played: list[Played]) -> Binding | None:
        """What is meant, once that is known, by what one message says was `played`."""
        for one in played:
            if one.fine and one.kind == "cc":
                continue  # told with its own seven bits, too
            if one.kind == "cc" and one.number in RESERVED_CONTROLLERS:
                continue
            if one.kind in MOVING:
                found = self._moved(one)
            else:
                found = self._made(one) if one.down else None
            if found is not None:
                return found
        return None

    def _moved(self, one: Played) -> Binding | None:
        way = self._ways.get((one.kind, one.number, one.channel))
        if way is None:
            self._ways[one.kind, one.number, one.channel] = _Way(one.share, one.share)
            pressed = one.kind == "cc" and one.share == 1.0 and not self._is_lower(one)
            return self._made(one) if pressed and self._is_switch else None
        way.low, way.high = min(way.low, one.share), max(way.high, one.share)
        if way.high - way.low < WIGGLED or self._is_lower(one):
            return None
        return self._made(one)

    def _is_lower(self, one: Played) -> bool:
        """Whether it is the lower half of a pair, which moves more, and says less."""
        upper = ("cc", one.number - 32, one.channel)
        return one.kind == "cc" and 32 <= one.number < 64 and upper in self._ways

    @property
    def _is_switch(self) -> bool:
        """Whether the control is one that a button's single message can work."""
        try:
            slot = self._binding(_FADER).slot
        except BadBinding:
            return False
        return slot is None or slot.type != "float"

    def _made(self, one: Played) -> Binding | None:
        try:
            return self._binding(one)
        except BadBinding:  # what cannot work it is not meant: a pad for a number, a fader for a name
            return None

    def _binding(self, one: Played) -> Binding:
        fine = one.kind == "cc" and one.number < 32 and ("cc", one.number + 32, one.channel) in self._ways
        try:
            return Binding(one.kind, one.number, self.control, one.channel, self.values, fine=fine)
        except BadBinding:
            if one.kind != "note":
                raise
            return Binding(one.kind, one.number, self.control, one.channel, self.values, velocity=True)


def values_of(address: str, given: str) -> dict[str, Plain]:
    """The values that `given` names for a control, a line each; BadBinding for what it does not have."""
    control = REGISTRY.find(address)
    if control is None:
        near = [item.address for item in REGISTRY if item.address.startswith(address.rpartition("/")[0] or "/")]
        raise BadBinding(f"no control is called {address!r}; there are {', '.join(near[:12]) or 'others'}")
    values: dict[str, Plain] = {}
    for word in given.split("\n") if given else ():
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


def _value(control: Control, name: str, text: str) -> Plain:
    argument = next(one for one in control.arguments if one.name == name)
    if argument.type in ("name", "text"):
        return text
    if argument.type == "bool":
        return text.casefold() in ("1", "true", "yes", "on")
    try:
        return float(text)
    except ValueError:
        raise BadBinding(f"{name}: {argument.expected} expected, found {text!r}") from None


IN_FLIGHT: Final = 1.0
"""Seconds in which a value that was set may be on its way there: until then nobody else is thought to have set it."""
CLOSE: Final = 2.0
"""Steps of the fader by which a value may differ and be the same."""


@dataclass(slots=True)
class Pickup:
    """One fader and the value that it sets; all as places of the fader, 0 to 1. Thread: one at a time."""

    held: bool = False
    """Whether the fader has the value."""
    sent: float = 0.0
    at: float = 0.0
    """What it set last, and when [s]."""
    begun: float = 0.0
    """The value when that was set: a value that fades is between the two."""
    before: float | None = None
    """Where the fader was last."""

    def takes(self, share: float, present: float, step: float, time: float, *, fades: bool = False) -> bool:
        """Whether the fader, which is at `share` now, sets the value, which is `present`; to be told if it does.

        `fades`: what it sets takes a while to come.
        """
        before, self.before = self.before, share
        near = CLOSE * step
        if self.held and time - self.at > IN_FLIGHT:
            low, high = sorted((self.begun, self.sent)) if fades else (self.sent, self.sent)
            self.held = low - near <= present <= high + near
        if not self.held:
            crossed = before is not None and min(before, share) <= present <= max(before, share)
            self.held = crossed or abs(share - present) <= near
        if self.held:
            self.sent, self.at, self.begun = share, time, present
        return self.held
