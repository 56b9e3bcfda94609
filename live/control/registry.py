"""The registry: one table of every control, whoever uses it (OSC, keys, web pages), with types, units and ranges.

Values are checked here, before any numeric code sees them. The reference in docs/osc.md is written from this table.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM
from live.control import events
from live.control.events import ControlEvent
from live.control.rejections import Reason, Rejection

NAME_LENGTH: Final = 64
TEXT_LENGTH: Final = 250
Role = Literal["operator", "musician", "audience"]
Plain = float | bool | str


@dataclass(frozen=True, slots=True)
class Reply:
    """What a control answers to its sender only, instead of changing the show."""

    address: str


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
        return float(value) if self.minimum <= value <= self.maximum else Reason.OUT_OF_RANGE


@dataclass(frozen=True, slots=True)
class Control:
    """One control. `make` gets time [s], source and every argument by its name. `who`: the least role that may."""

    address: str
    make: Callable[..., ControlEvent | Reply]
    arguments: tuple[Argument, ...]
    description: str
    who: Role

    def __post_init__(self) -> None:
        optional = [argument.default is not None for argument in self.arguments]
        if optional != sorted(optional):
            raise ValueError(f"{self.address}: an argument that must be given stands after an optional one")

    def call(self, values: Sequence[object], time: float, source: str) -> ControlEvent | Reply | Released | Rejection:
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


class Registry:
    """Controls by their exact address; there are no patterns."""

    def __init__(self, controls: Sequence[Control]) -> None:
        self._controls: Mapping[str, Control] = {control.address: control for control in controls}
        if len(self._controls) != len(controls):
            raise ValueError("two controls have one address")

    def __iter__(self) -> Iterator[Control]:
        return iter(self._controls.values())

    def __getitem__(self, address: str) -> Control:
        return self._controls[address]

    def call(
        self, address: str, values: Sequence[object], time: float, source: str
    ) -> ControlEvent | Reply | Released | Rejection:
        """What the control at `address` makes of `values`, received at `time` [s of the show] from `source`.

        Thread: any. Never raises for anything a sender can choose.
        """
        control = self._controls.get(address)
        if control is None:
            return Rejection(Reason.UNKNOWN_ADDRESS, address)
        return control.call(values, time, source)


def _pong(time: float, source: str) -> Reply:
    return Reply("/dance/pong")


def _motion(parameter: str) -> Callable[..., ControlEvent]:
    """The event of one parameter of the motion; switches are 0 or 1."""

    def make(*, time: float, source: str, value: float, group: str) -> ControlEvent:
        return events.SetMotion(time=time, source=source, parameter=parameter, value=float(value), group=group)

    return make


_GROUP = Argument("group", "name", "the group's name in the patch; a single * is every group", default="*")
_X = Argument("x", "float", "to the right as the audience sees it, from the centre of the stage", "m", -100, 100)
_Z = Argument("z", "float", "towards the audience, from the centre of the stage", "m", -100, 100)
_STRENGTH = Argument("strength", "float", "how strongly it acts; 1 is the usual strength", "", 0, 10, 1.0)
_MEASURES = Argument("measures", "float", "how long it acts", "measures", 0.25, 1024, 4.0)

_SHARE = Argument("value", "float", "from none to all", "", 0, 1)
_MOTION: Final = (
    (
        "/dance/motion/warp", "warp_beats", Argument("value", "float", "ahead or behind at most", "beats", 0, 1),
        "Dancers are ahead of the beat or behind it, each in her own way, from the next decided measure on.",
    ),
    (
        "/dance/motion/warp_sequence", "warp_sequence",
        Argument("value", "bool", "1: over several measures, 0: within each"),
        "Whether they drift over several measures, or are back on the beat at every measure line.",
    ),
    (
        "/dance/motion/amplitude", "amplitude", Argument("value", "float", "larger or smaller at most", "", 0, 0.5),
        "The upper body moves more or less than recorded, each dancer in her own way.",
    ),
    (
        "/dance/motion/amplitude_sequence", "amplitude_sequence",
        Argument("value", "bool", "1: over several measures, 0: anew for each"),
        "Whether that changes slowly over several measures, or anew for each.",
    ),
    ("/dance/motion/mix", "mix", _SHARE, "How far another take of the same step is mixed into the body at most."),
    ("/dance/motion/arms", "arms", _SHARE, "Share of the dancers whose upper body dances another take of the step."),
    ("/dance/motion/head", "head", _SHARE, "How far heads turn to the public, as far as necks allow."),
    (
        "/dance/motion/foot_lock", "lock", Argument("value", "bool", "1: hold them, 0: let them slide"),
        "Whether feet that carry stay where they are.",
    ),
    (
        "/dance/motion/turn_on_support", "on_support", Argument("value", "bool", "1: on that foot, 0: evenly"),
        "Whether dancers turn on the foot that carries, or evenly over the measure.",
    ),
    (
        "/dance/motion/face_average", "face_average", Argument("value", "bool", "1: on the average, 0: at their ends"),
        "Whether measures face the wanted way on the average, or when they end.",
    ),
    (
        "/dance/motion/mirror", "mirror", Argument("value", "float", "-1: never, 0: both, 1: only", "", -1, 1),
        "Whether steps are danced as they were made, as mirror images, or both.",
    ),
)  # fmt: skip
"""Address, parameter of SetMotion, its argument, description."""

REGISTRY: Final = Registry(
    (
        Control(
            "/dance/attract", events.Attract, (_X, _Z, _STRENGTH, _MEASURES),
            "Dancers gather around a point of the stage.", "audience",
        ),
        Control(
            "/dance/repel", events.Repel, (_X, _Z, _STRENGTH, _MEASURES),
            "Dancers leave the surroundings of a point of the stage.", "musician",
        ),
        Control("/dance/spread", events.Spread, (_MEASURES,), "Dancers spread over the stage.", "musician"),
        Control(
            "/dance/clear", events.Clear, (),
            "All attractors, repulsors and spreaders end, and the patch chooses the steps again.", "operator",
        ),
        Control(
            "/dance/step", events.CallStep,
            (Argument("name", "name", "the step's name in the show's library"), _MEASURES),
            "All dancers dance this step from the next free measure on.", "musician",
        ),
        Control(
            "/dance/sequence", events.SetSequence,
            (
                Argument("steps", "text", 'names with commas between them, as "couru, couru left, echappe x2, *"'),
                _GROUP,
            ),
            "Dancers dance these steps in order, again and again, until /dance/clear; refused, and the present dance "
            "goes on, if they cannot be joined.", "musician",
        ),
        *(
            Control(address, _motion(parameter), (argument, _GROUP), description, "operator")
            for address, parameter, argument, description in _MOTION
        ),
        Control("/dance/clock/tap", events.Tap, (), "A beat is now; taps in a row give the tempo.", "musician"),
        Control("/dance/clock/one", events.One, (), '"This is the one": a measure begins now.', "musician"),
        Control(
            "/dance/clock/tempo", events.SetTempo,
            (Argument("tempo", "float", "the new tempo", "bpm", TEMPO_MIN_BPM, TEMPO_MAX_BPM),),
            "Sets the tempo; the beat goes on without a jump. Music that is heard takes over again after 8 s.",
            "musician",
        ),
        Control(
            "/dance/blackout", events.Blackout,
            (Argument("on", "bool", "1: the light goes out, 0: it comes back"),),
            "Turns the light of the show out or on.", "operator",
        ),
        Control("/dance/ping", _pong, (), "Answers /dance/pong, to the sender only; changes nothing.", "audience"),
    )
)  # fmt: skip
"""Every control there is."""
