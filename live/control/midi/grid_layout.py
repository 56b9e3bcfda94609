"""Grid controllers by the names of their ports: where their pads and buttons are, and how their lights are set.

Numbers are from the makers' programmers' references: Novation's of Launchpad (2009), MK2, X, Mini MK3 and Pro MK3 in
programmer mode; Akai's of APC Mini, APC Mini mk2 and APC40 mkII. No controller needs system exclusive for its lights.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

Address = tuple[int, int]
"""Status byte of a press (note on or controller, with the channel) and number."""
Light = Literal["off", "idle", "waits", "runs", "away", "refused", "dim", "bright"]
"""Of pads: nothing there, can be launched, waits, runs, cannot follow at once, was refused; of buttons: not chosen,
chosen."""
FUNCTIONS: Final = (
    "up", "down", "left", "right", "now", "beat", "measure", "section",
    "own", "step", "phrase", "formation", "element", "look", "undo", "stop",
)  # fmt: skip
"""Buttons beside the pads: of the row, then of the column."""
NOTE: Final = 0x90
CONTROLLER: Final = 0xB0
Colours = Callable[[Light, float | None], int]
"""Velocity of a light; the second value is its hue, 0 to 1, None: white."""


@dataclass(frozen=True, slots=True)
class GridLayout:
    """One kind of grid controller."""

    name: str
    port: re.Pattern[str]
    """Found in the name of its port, in lower case."""
    pads: Mapping[Address, tuple[int, int]]
    """Row from the top and column of each pad, from 0."""
    buttons: Mapping[Address, str]
    """The buttons beside the pads, by `FUNCTIONS`."""
    colours: Colours
    button_colours: Colours
    begin: bytes = b""
    """Message that makes its pads free for programs."""
    end: bytes = b""
    """Message that gives them back."""
    light_channel: int | None = None
    """Channel of the pads' lights, from 0, if it is not that of their presses."""

    @property
    def rows(self) -> int:
        """Number of rows of pads."""
        return 1 + max(row for row, _ in self.pads.values())

    @property
    def columns(self) -> int:
        """Number of columns of pads."""
        return 1 + max(column for _, column in self.pads.values())

    def light(self, address: Address, light: Light, hue: float | None = None) -> bytes:
        """Return the message that sets a light."""
        status, number = address
        if address in self.buttons:
            return bytes((status, number, self.button_colours(light, hue)))
        if self.light_channel is not None:
            status = NOTE | self.light_channel
        return bytes((status, number, self.colours(light, hue)))

    def press(self, message: Sequence[int]) -> tuple[Address, bool] | None:
        """Return what a message presses (True) or lets go; None for any other message."""
        if len(message) != 3:
            return None
        status, number, value = message
        kind = status & 0xF0
        if kind == 0x80:
            status, value = NOTE | (status & 0x0F), 0
        address = status, number
        return (address, value > 0) if address in self.pads or address in self.buttons else None


# -- colours ---------------------------------------------------------------------------------------------------------

_HUES: Final = (
    (0.0, 4), (0.08, 8), (0.16, 12), (0.25, 16), (0.33, 20), (0.42, 28), (0.5, 36), (0.58, 40), (0.66, 44), (0.74, 48),
    (0.83, 52), (0.93, 56), (1.0, 4),
)  # fmt: skip
"""Hues of the palette of 128 colours: its entries in fours, from pale to dark."""


def rgb_colour(light: Light, hue: float | None) -> int:
    """Return an entry of the palette of 128 colours that Launchpads since MK2 and APCs mk2 share."""
    match light:
        case "off":
            return 0
        case "away":
            return 7
        case "refused":
            return 5
        case "dim":
            return 1
        case "bright":
            return 3
    if hue is None:
        return 1 if light == "idle" else 3
    first = min(_HUES, key=lambda one: abs(one[0] - hue))[1]
    return first + 3 if light == "idle" else first + 1


def two_colours(codes: Mapping[Light, int]) -> Colours:
    """Return the colours of a controller with red and green lights only."""
    return lambda light, _hue: codes[light]


_LAUNCHPAD: Final = two_colours(
    {"off": 0x0C, "idle": 0x1D, "waits": 0x3E, "runs": 0x3C, "away": 0x0D, "refused": 0x0F, "dim": 0x1C, "bright": 0x3C}
)
_APC_MINI: Final = two_colours(
    {"off": 0, "idle": 5, "waits": 1, "runs": 1, "away": 3, "refused": 3, "dim": 0, "bright": 1}
)
_SINGLE: Final = two_colours(
    {"off": 0, "idle": 0, "waits": 1, "runs": 1, "away": 0, "refused": 1, "dim": 0, "bright": 1}
)

# -- controllers -----------------------------------------------------------------------------------------------------


def _square(number: Callable[[int, int], int], rows: int = 8) -> dict[Address, tuple[int, int]]:
    return {(NOTE, number(row, column)): (row, column) for row in range(rows) for column in range(8)}


def _buttons(row: Sequence[Address], column: Sequence[Address]) -> dict[Address, str]:
    return dict(zip((*row, *column), FUNCTIONS, strict=True))


def _novation(name: str, port: str, model: int, *, mk2: bool = False) -> GridLayout:
    """Return a Launchpad with pads 11 to 88 from the bottom left."""
    row = [(CONTROLLER, number) for number in (range(104, 112) if mk2 else range(91, 99))]
    column = [(NOTE if mk2 else CONTROLLER, number) for number in range(89, 9, -10)]
    head = bytes((0xF0, 0x00, 0x20, 0x29, 0x02, model))
    begin, end = (b"\x22\x00\xf7", b"") if mk2 else (b"\x0e\x01\xf7", b"\x0e\x00\xf7")
    return GridLayout(
        name, re.compile(port), _square(lambda row, column: 10 * (8 - row) + column + 1), _buttons(row, column),
        rgb_colour, rgb_colour, head + begin, head + end if end else b"",
    )  # fmt: skip


LAYOUTS: Final = (
    _novation("Launchpad X", r"(launchpad x|lpx)(?!.*(da\b|daw))", 0x0C),
    _novation("Launchpad Mini MK3", r"(launchpad mini mk3|lpminimk3)(?!.*(da\b|daw))", 0x0D),
    _novation("Launchpad Pro MK3", r"(launchpad pro mk3|lppromk3)(?!.*(da\b|daw|din))", 0x0E),
    _novation("Launchpad MK2", r"launchpad mk2", 0x18, mk2=True),
    GridLayout(
        "Launchpad", re.compile(r"launchpad(?!.*(mk2|mk3|pro\b|\bx\b|lpx))"),
        _square(lambda row, column: 16 * row + column),
        _buttons([(CONTROLLER, 104 + index) for index in range(8)], [(NOTE, 8 + 16 * index) for index in range(8)]),
        _LAUNCHPAD, _LAUNCHPAD, bytes((CONTROLLER, 0, 0)), bytes((CONTROLLER, 0, 0)),
    ),
    GridLayout(
        "APC Mini mk2", re.compile(r"apc mini mk2(?!.*notes)"), _square(lambda row, column: 8 * (7 - row) + column),
        _buttons([(NOTE, number) for number in range(100, 108)], [(NOTE, number) for number in range(112, 120)]),
        rgb_colour, _SINGLE, light_channel=6,
    ),
    GridLayout(
        "APC Mini", re.compile(r"apc mini(?! mk2)"), _square(lambda row, column: 8 * (7 - row) + column),
        _buttons([(NOTE, number) for number in range(64, 72)], [(NOTE, number) for number in range(82, 90)]),
        _APC_MINI, _SINGLE,
    ),
    GridLayout(
        "APC40 mkII", re.compile(r"apc40 mkii"), _square(lambda row, column: 8 * (4 - row) + column, rows=5),
        {
            (NOTE, 94): "up", (NOTE, 95): "down", (NOTE, 97): "left", (NOTE, 96): "right",
            **{(NOTE | channel, 51): FUNCTIONS[4 + channel] for channel in range(4)},
            **{(NOTE, 82 + index): FUNCTIONS[8 + index] for index in range(5)}, (NOTE, 81): "stop",
        },
        rgb_colour, _SINGLE,
    ),
)  # fmt: skip
"""All known grid controllers; the first one that fits a port's name counts."""


def layout_of(port: str) -> GridLayout | None:
    """Return the controller at a port, by the port's name; None for any other device."""
    folded = port.casefold()
    return next((layout for layout in LAYOUTS if layout.port.search(folded)), None)
