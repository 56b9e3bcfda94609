"""MIDI bindings: which note or controller operates which control, and how."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from live.control.registry.control import Argument, ArgumentValue
from live.control.registry.registry import REGISTRY
from live.control.registry.rejections import Reason

Kind = Literal["note", "cc", "program", "bend", "pressure", "nrpn"]
Mode = Literal["toggle", "momentary"]

CONTINUOUS_KINDS: Final = ("cc", "bend", "pressure", "nrpn")
"""Kinds with a continuous position; the others are pressed."""
MAX_NUMBER: Final[dict[Kind, int]] = {"note": 127, "cc": 127, "program": 127, "bend": 0, "pressure": 0, "nrpn": 16383}
"""The highest number of each kind; a channel has one pitch bend and one pressure."""
FINE_BELOW: Final = 32
"""Controllers below this may have a second one, 32 higher, for their lower seven bits."""


class BadBinding(ValueError):
    """The binding cannot work; the message gives reason and remedy."""


@dataclass(frozen=True, slots=True)
class Binding:
    """One line of a MIDI map. Raises BadBinding if the control does not exist or cannot be operated so."""

    kind: Kind
    number: int
    control: str
    channel: int = 0
    """1 to 16; 0: all."""
    values: Mapping[str, ArgumentValue] = field(default_factory=dict)
    """Fixed arguments of the control, by name."""
    scale: tuple[float, float] | None = None
    """Values at the lowest and the highest position; None: the argument's own range."""
    curve: float = 1.0
    """Exponent from position, 0 to 1, to share of the scale: 2 is finer at the low end, 0.5 at the high end."""
    fine: bool = False
    """Whether a controller is part of a 14-bit pair."""
    velocity: bool = False
    """Whether a note sets a number by its velocity."""
    mode: Mode | None = None
    """How a switch is operated; None: toggle for notes and programs, momentary for controllers."""
    pickup: bool | None = None
    """Whether soft takeover is used; None: for cc and nrpn, not for pitch bend and pressure."""
    lit: tuple[int, int] = (0, 127)
    """Velocities sent to a pad when its switch is off and on; many pads show them as colours."""

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
            if isinstance(argument.check(value), Reason):
                raise BadBinding(f"values.{name}: {argument.expected} expected, found {value!r}")
        slot = self.slot
        for argument in control.arguments:
            if argument.default is None and argument.name not in self.values and argument is not slot:
                raise BadBinding(f"{self.control} needs a value: values = {{ {argument.name} = … }}")
        self._check_scale(slot)
        self._check_kind(slot)

    def _check_scale(self, slot: Argument | None) -> None:
        if self.scale is None and self.curve == 1.0:
            return
        if slot is None or slot.type != "float":
            raise BadBinding("scale is for controllers (cc) that set a number; so is curve")
        if self.scale is not None and not all(slot.minimum <= bound <= slot.maximum for bound in self.scale):
            raise BadBinding(f"scale: {slot.expected} expected, found {list(self.scale)}")

    def _check_kind(self, slot: Argument | None) -> None:
        if not 0 <= self.number <= MAX_NUMBER[self.kind]:
            raise BadBinding(f"{self.kind} 0 to {MAX_NUMBER[self.kind]} expected, found {self.number}")
        if self.fine and (self.kind != "cc" or self.number >= FINE_BELOW):
            raise BadBinding(
                f"fine is for controllers (cc) below {FINE_BELOW}, whose second one is {FINE_BELOW} higher"
            )
        if self.velocity and (self.kind != "note" or slot is None):
            raise BadBinding("velocity is for notes that set a number")
        if self.mode is not None and (slot is None or slot.type != "bool") and not self.velocity:
            raise BadBinding(f"mode is for switches; {self.control} has none")

    @property
    def slot(self) -> Argument | None:
        """The argument that is set: the first free number or switch for controllers, the first switch for presses."""
        free = [argument for argument in REGISTRY[self.control].arguments if argument.name not in self.values]
        wanted = ("float",) if self.velocity else ("float", "bool") if self.kind in CONTINUOUS_KINDS else ("bool",)
        return next((argument for type_ in wanted for argument in free if argument.type == type_), None)

    @property
    def toggles(self) -> bool:
        """Whether a press toggles a switch."""
        return self.mode == "toggle" or (self.mode is None and self.kind not in CONTINUOUS_KINDS)

    @property
    def uses_pickup(self) -> bool:
        """Whether soft takeover is used."""
        return self.kind in ("cc", "nrpn") if self.pickup is None else self.pickup

    @property
    def trigger(self) -> tuple[Kind, int, int]:
        """Kind, number and channel of what is played."""
        return self.kind, self.number, self.channel

    def value(self, position: float) -> float:
        """Return the value at `position`, 0 to 1."""
        low, high = self._bounds
        return low + (high - low) * (position if self.curve == 1.0 else position**self.curve)

    def position(self, value: float) -> float:
        """Return the position, 0 to 1, that sets `value`, clamped to the scale."""
        low, high = self._bounds
        share = min(max((value - low) / (high - low), 0.0), 1.0) if high != low else 0.0
        return share if self.curve == 1.0 else float(share ** (1.0 / self.curve))

    @property
    def _bounds(self) -> tuple[float, float]:
        slot = self.slot
        assert slot is not None  # a press has no value
        return self.scale or (slot.minimum, slot.maximum)


def merge_bindings(configured: Sequence[Binding], learned: Sequence[Binding]) -> tuple[Binding, ...]:
    """Return the learned bindings with those written ones that no learned one replaces."""
    taken = {(binding.kind, binding.number) for binding in learned}
    channels = {binding.trigger for binding in learned}

    def is_taken(binding: Binding) -> bool:
        if (binding.kind, binding.number) not in taken:
            return False
        either = binding.channel == 0 or (binding.kind, binding.number, 0) in channels
        return either or binding.trigger in channels

    return (*(binding for binding in configured if not is_taken(binding)), *learned)


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
"""Bindings without a map: pedals on any channel (sustain, sostenuto, soft) and notes from C2 (36) on channel 16."""
