"""Definition of a control, used over OSC, keys and web pages: arguments with types, units and ranges.

Values are checked here, before they reach numeric code.
"""

import math
import re
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

from live.control.events.event import ControlEvent
from live.control.registry.rejections import Reason, Rejection

NAME_LENGTH: Final = 64
TEXT_LENGTH: Final = 250
Role = Literal["operator", "musician", "audience"]
ROLE_RANKS: Final[dict[Role, int]] = {"audience": 0, "musician": 1, "operator": 2}
"""Order of the roles; a higher one includes the lower ones."""
Kind = Literal["continuous", "event"]
"""continuous: sets a value, so that of several messages at once only the last counts; event: every message acts."""
ArgumentValue = float | bool | str


@dataclass(frozen=True, slots=True, kw_only=True)
class Query:
    """A request to the port that received it, on behalf of the sender; the show does not change."""

    time: float
    source: str


@dataclass(frozen=True, slots=True)
class Released:
    """A button of a control without arguments was released; this is valid and has no effect."""


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument: its name (as the event's field), type, unit, allowed range and, if optional, default."""

    name: str
    type: Literal["float", "bool", "name", "text"]
    description: str
    unit: str = ""
    minimum: float = 0.0
    maximum: float = 0.0
    default: ArgumentValue | None = None
    """None: the argument is required."""
    convert: Callable[[Any], Any] | None = None
    """Makes the event's value of one that was checked: `round` for a whole number; ValueError if it cannot."""
    form: str = ""
    """How a text is written, if not any text is valid."""
    longest: int = 0
    """Maximum length of a text [characters]; 0: that of its type."""
    names: str = ""
    """What a name names, as in "step" or "cue": the names that exist are offered as completions."""

    @classmethod
    def number(
        cls, description: str, low: float, high: float, unit: str = "", default: float | None = None
    ) -> "Argument":
        """Return a number from `low` to `high`; the field has the name, and the default if none is given here."""
        return cls("", "float", description, unit, low, high, default)

    @classmethod
    def switch(cls, description: str) -> "Argument":
        """Return a switch: 0 or 1."""
        return cls("", "bool", description)

    @classmethod
    def label(cls, description: str, names: str = "", default: str | None = None) -> "Argument":
        """Return a short text that names something."""
        return cls("", "name", description, default=default, names=names)

    @classmethod
    def text(cls, description: str, names: str = "", longest: int = 0) -> "Argument":
        """Return a text."""
        return cls("", "text", description, longest=longest, names=names)

    @property
    def expected(self) -> str:
        """The allowed values as text."""
        if self.type == "float":
            return f"{self.name} {self.minimum:g} to {self.maximum:g}" + (f" {self.unit}" if self.unit else "")
        if self.type == "bool":
            return f"{self.name} 0 or 1"
        if self.form:
            return f"{self.name} {self.form}"
        return f"{self.name} of 1 to {self.length} printable characters"

    @property
    def length(self) -> int:
        """Maximum length of a name or text."""
        return self.longest or (NAME_LENGTH if self.type == "name" else TEXT_LENGTH)

    def check(self, value: object) -> ArgumentValue | Reason:
        """Return the value in its own type, never NaN or out of range, or the reason. `True` is not a number."""
        kind = type(value)
        if self.type in ("name", "text"):
            if value == "" == self.default:
                return ""
            if kind is not str:
                return Reason.WRONG_TYPE
            text = str(value)
            return text if 0 < len(text) <= self.length and text.isprintable() and text.strip() else Reason.NAME
        if self.type == "bool" and isinstance(value, bool):
            return value
        if (kind is not float and kind is not int) or not isinstance(value, int | float):
            return Reason.WRONG_TYPE
        if value != value or value in (float("inf"), float("-inf")):
            return Reason.NOT_FINITE
        if self.type == "bool":
            return bool(value) if value in (0, 1) else Reason.OUT_OF_RANGE
        if self.minimum <= value <= self.maximum:
            return float(value)
        edge = self.minimum if value < self.minimum else self.maximum
        return edge if value == _to_single(edge) else Reason.OUT_OF_RANGE


def parse_points(text: str) -> tuple[tuple[float, float], ...]:
    """Parse points written as "x z, x z" [m]; ValueError for anything else."""
    numbers = [[float(word) for word in pair.split()] for pair in text.replace(";", ",").split(",")]
    if any(len(pair) != 2 or not all(map(math.isfinite, pair)) for pair in numbers):
        raise ValueError(f"{text!r} are no points")
    return tuple((pair[0], pair[1]) for pair in numbers)


_IN_ADDRESS: Final = re.compile(r"[^\s#*,/?\[\]{}\x00-\x20\x7f-\U0010ffff]+")
_SINGLE: Final = struct.Struct("<f")


def _to_single(value: float) -> float:
    """Return a number rounded to single precision, as OSC sends it."""
    return float(_SINGLE.unpack(_SINGLE.pack(value))[0])


Result = ControlEvent | Query | Released | Rejection
"""Result of a call."""


@dataclass(frozen=True, slots=True)
class Control:
    """One control. `make` gets time [s], source and every argument by its name. `role`: the lowest role allowed."""

    address: str
    make: Callable[..., ControlEvent | Query]
    arguments: tuple[Argument, ...]
    description: str
    role: Role
    kind: Kind = "event"
    value: int = 0
    """Number of leading arguments (`named`: after the name) that form its current value; 0: no readable value."""
    start: tuple[ArgumentValue, ...] = ()
    """The default value; empty: the patch or the machine decides it."""
    named: bool = False
    """Whether the first argument names the owner of the value: each name has its own value, and the name may stand in
    the address, before its last part."""

    def __post_init__(self) -> None:
        if self.value and self.kind == "event":
            raise ValueError(f"{self.address}: an event has no current value")
        optional = [argument.default is not None for argument in self.arguments]
        if optional != sorted(optional):
            raise ValueError(f"{self.address}: a required argument comes after an optional one")

    @property
    def value_arguments(self) -> tuple[Argument, ...]:
        """The arguments that form its current value."""
        return self.arguments[self.named : self.named + self.value]

    def is_query(self, address: str) -> bool:
        """Whether a message without values to `address` is a query; not if all arguments are optional."""
        first = self.value_arguments if self.named and address != self.address else self.arguments
        return self.value > 0 and first[0].default is None

    def address_of(self, name: str) -> str | None:
        """Return the address with this name in it, as `/dance/mocap/anna/mirrored`; None if the name does not fit."""
        if not _IN_ADDRESS.fullmatch(name):
            return None
        head, _, last = self.address.rpartition("/")
        return f"{head}/{name}/{last}"

    def addressees(self, values: Sequence[object]) -> tuple[str, ...]:
        """Return the texts among a message's `values` that address it (name, group) and are not its value."""
        others = (*values[: self.named], *values[self.named + self.value :])
        return tuple(value for value in others if isinstance(value, str))

    def call(self, values: Sequence[object], time: float, source: str) -> Result:
        """Check `values` and make the event; for None an optional argument takes its default.

        Push buttons of control surfaces send 1 when pressed and 0 when released: a control without arguments acts on
        1 and ignores 0.
        """
        count = len(values)
        while count and values[count - 1] is None:
            count -= 1
        if not self.arguments and count == 1 and isinstance(values[0], int | float) and values[0] in (0, 1):
            if not values[0]:
                return Released()
            count = 0
        if count > len(self.arguments):
            expected = f"at most {len(self.arguments)} values" if self.arguments else "no value"
            return Rejection(Reason.EXTRA, self.address, expected, values[len(self.arguments)])
        named: dict[str, Any] = {}
        for index, argument in enumerate(self.arguments):
            value = values[index] if index < count else None
            result = argument.default if value is None else argument.check(value)
            if result is None:
                return Rejection(Reason.MISSING, self.address, argument.expected, None)
            if isinstance(result, Reason):
                return Rejection(result, self.address, argument.expected, value)
            try:
                named[argument.name] = result if argument.convert is None else argument.convert(result)
            except ValueError:
                return Rejection(Reason.FORM, self.address, argument.expected, value)
        return self.make(time=time, source=source, **named)
