"""Control: one control, whoever uses it (OSC, keys, web pages), with the types, units and ranges of its arguments.

Values are checked here, before any numeric code sees them.

Arguments that several controls have.
"""

import re
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from live.control.events.events import ControlEvent
from live.control.registry.rejections import Reason, Rejection

NAME_LENGTH: Final = 64
TEXT_LENGTH: Final = 250
Role = Literal["operator", "musician", "audience"]
RANKS: Final[dict[Role, int]] = {"audience": 0, "musician": 1, "operator": 2}
"""Who comes before whom."""
Kind = Literal["continuous", "event"]
"""continuous: says what something is from now on, so that of several at once the last one counts; event: each acts."""
Plain = float | bool | str


@dataclass(frozen=True, slots=True)
class Reply:
    """What a control answers to its sender only, instead of changing the show."""

    address: str


@dataclass(frozen=True, slots=True)
class Request:
    """What a control asks of the port over which it came, for its sender: nothing of the show changes."""

    what: Literal["get", "subscribe", "unsubscribe"]
    address: str = ""
    """Of which control, or which controls."""
    seconds: float = 0.0
    port: int = 0
    """Where the sender hears; 0: where it sends from."""


@dataclass(frozen=True, slots=True)
class Released:
    """A button of a control without arguments was let go: nothing happens, and nothing is wrong."""


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument: its name (that of the event's field), type, unit, allowed range and, if optional, default."""

    name: str
    type: Literal["float", "bool", "name", "text"]
    description: str
    unit: str = ""
    minimum: float = 0.0
    maximum: float = 0.0
    default: Plain | None = None
    """None: the argument must be given."""

    @property
    def expected(self) -> str:
        """What is allowed, in words."""
        if self.type == "float":
            return f"{self.name} {self.minimum:g} to {self.maximum:g}" + (f" {self.unit}" if self.unit else "")
        if self.type == "bool":
            return f"{self.name} 0 or 1"
        return f"{self.name} of 1 to {self.length} printable characters"

    @property
    def length(self) -> int:
        """Most characters of a name or text."""
        return NAME_LENGTH if self.type == "name" else TEXT_LENGTH

    def checked(self, value: object) -> Plain | Reason:
        """The value in its own type, or why not: never NaN, never out of range. `True` is no number here."""
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
        return edge if value == _as_sent(edge) else Reason.OUT_OF_RANGE


_IN_ADDRESS: Final = re.compile(r"[^\s#*,/?\[\]{}\x00-\x20\x7f-\U0010ffff]+")
_SINGLE: Final = struct.Struct("<f")


def _as_sent(value: float) -> float:
    """What comes of a number that is sent in single precision, as OSC sends it."""
    return float(_SINGLE.unpack(_SINGLE.pack(value))[0])


Result = ControlEvent | Reply | Request | Released | Rejection
"""What comes of a call."""


@dataclass(frozen=True, slots=True)
class Control:
    """One control. `make` gets time [s], source and every argument by its name. `who`: the least role that may."""

    address: str
    make: Callable[..., ControlEvent | Reply | Request]
    arguments: tuple[Argument, ...]
    description: str
    who: Role
    kind: Kind = "event"
    value: int = 0
    """How many of the first arguments (`named`: after the name) are its present value; 0: it has none that could be
    asked for."""
    start: tuple[Plain, ...] = ()
    """What the value is where nobody says anything; empty: the patch or the machine decides it."""
    named: bool = False
    """Whether the first argument is a name, of whom or what the value is: that one may stand in the address, before its
    last part, and each has a value of its own."""

    def __post_init__(self) -> None:
        if self.value and self.kind == "event":
            raise ValueError(f"{self.address}: an event has no present value")
        optional = [argument.default is not None for argument in self.arguments]
        if optional != sorted(optional):
            raise ValueError(f"{self.address}: an argument that must be given stands after an optional one")

    @property
    def valued(self) -> tuple[Argument, ...]:
        """The arguments that are its present value."""
        return self.arguments[self.named : self.named + self.value]

    def asked_by_nothing(self, address: str) -> bool:
        """Whether a message without values to an `address` of its asks for the value: not where it already means
        something."""
        first = self.valued if self.named and address != self.address else self.arguments
        return self.value > 0 and first[0].default is None

    def address_of(self, name: str) -> str | None:
        """The address that has this name in it, as `/dance/mocap/anna/mirrored`; None if no address can."""
        if not _IN_ADDRESS.fullmatch(name):
            return None
        head, _, last = self.address.rpartition("/")
        return f"{head}/{name}/{last}"

    def whom(self, values: Sequence[object]) -> tuple[str, ...]:
        """The texts among the `values` of a message that are not its value, but say whose it is."""
        others = (*values[: self.named], *values[self.named + self.value :])
        return tuple(value for value in others if isinstance(value, str))

    def call(self, values: Sequence[object], time: float, source: str) -> Result:
        """Check `values` and make the event; None is no value: an optional argument takes its default.

        Push buttons of control surfaces send 1 when pressed and 0 when let go: a control without arguments acts on
        the 1 and ignores the 0.
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
        named: dict[str, Plain] = {}
        for index, argument in enumerate(self.arguments):
            value = values[index] if index < count else None
            result = argument.default if value is None else argument.checked(value)
            if result is None:
                return Rejection(Reason.MISSING, self.address, argument.expected, None)
            if isinstance(result, Reason):
                return Rejection(result, self.address, argument.expected, value)
            named[argument.name] = result
        return self.make(time=time, source=source, **named)


GROUP = Argument("group", "name", "the group's name in the patch; a single * is every group", default="*")
WHO = Argument(
    "group",
    "text",
    "who: a group, or groups, attributes, numbers and places as in `ember & left + 12-14`; * is all",
    default="*",
)
X = Argument("x", "float", "to the right as the audience sees it, from the centre of the stage", "m", -100, 100)
Z = Argument("z", "float", "towards the audience, from the centre of the stage", "m", -100, 100)
X2 = Argument("x2", "float", "the same of the second point", "m", -100, 100)
Z2 = Argument("z2", "float", "the same of the second point", "m", -100, 100)
STRENGTH = Argument("strength", "float", "how strongly it acts; 1 is the usual strength", "", 0, 10, 1.0)
MEASURES = Argument("measures", "float", "how long it acts", "measures", 0.25, 1024, 4.0)
NEXT = Argument("next", "bool", "1: from the next measure line on, 0: now", default=False)
POINTS = Argument("points", "text", "x z of one point after the other, as in `-3 0, 0 -2, 3 0`")
