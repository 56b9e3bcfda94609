"""Parameter: a value of the show that has its place in an array and needs no class of its own.

One row describes it: address, kind, range, start value, unit and words. The control (OSC, OSCQuery, MIDI, web page,
tablet), the patch key with its line in the reference and the editor's schema, the event, fades, scenes, undo, reading
back and the tests are made from the row. Rows: `picture_parameters` for the picture, `motion_parameters` for the motion
of each group.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

Kind = Literal["number", "switch", "choice", "names", "colour", "place"]
SPOT_COUNT: Final = 4
"""Number of follow spots."""
WORLD_NAMES: Final = ("haze", "studio", "paper", "constellation", "water", "dusk")
"""The worlds in which dancers are drawn; the amount of each is at `/dance/world/NAME`."""
_COMPONENTS: Final[Mapping[Kind, tuple[str, ...]]] = {
    "number": ("how much",),
    "switch": ("1: on, 0: off",),
    "choice": ("which",),
    "names": ("one name, or several with + between them: each dancer has one of these",),
    "colour": ("red, linear", "green, linear", "blue, linear"),
    "place": ("to the right as seen by the audience", "up", "towards the audience"),
}


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter: a number, switch (0 or 1), choice, names, colour (r, g, b), or place or direction (x, y, z).

    Names stand in the row as one number, the sum of the `choices` of each name, which are powers of two.
    """

    address: str
    kind: Kind
    low: float
    high: float
    start: tuple[float, ...]
    """Value if neither patch nor scene sets it."""
    unit: str
    description: str
    first: int = 0
    """Index of its first number in its row."""
    per_group: bool = False
    """Whether each group has a value of its own."""
    words: str = ""
    """Description of its number; empty: that of its kind."""
    patch: str = ""
    """Its key in the patch, as in "motion.head"; empty: it has none of its own."""
    patch_text: str = ""
    """Description in the patch; empty: as for the control."""
    choices: Mapping[str, float] = field(default_factory=dict)
    """Words of the patch for its numbers."""
    names: tuple[str, ...] = ("x", "y", "z")
    """Names of its numbers, as arguments."""

    @property
    def components(self) -> tuple[str, ...]:
        """Description of each of its numbers."""
        return (self.words,) if self.words else _COMPONENTS[self.kind]

    @property
    def size(self) -> int:
        """Number of its components."""
        return len(_COMPONENTS[self.kind])

    @property
    def row_slice(self) -> slice:
        """Slice of its numbers in the row."""
        return slice(self.first, self.first + self.size)

    @property
    def fades(self) -> bool:
        """Whether it can fade; switches, choices and names change at once."""
        return self.kind not in ("switch", "choice", "names")

    def number_of_names(self, words: str) -> float:
        """Return the number of names with `+` between them; ValueError for an unknown one."""
        total = 0
        for name in words.split("+"):
            known = self.choices.get(name.strip().casefold())
            if known is None:
                raise ValueError(f"{name.strip()!r} is none of {', '.join(self.choices)}")
            total |= int(known)
        return float(total)

    def names_of_number(self, number: float) -> str:
        """Return the names of a number, with `+` between them."""
        return " + ".join(name for name, bit in self.choices.items() if int(number) & int(bit))
