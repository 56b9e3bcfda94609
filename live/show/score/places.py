"""Places: the sections of a score as the playhead knows them, and where in them one measure of the show is (T015)."""

from dataclasses import dataclass
from typing import Final, Literal

END: Final = -1
"""Where a score goes that is over, and the section of a `Place` outside of all sections."""

When = Literal["measure", "section"]


@dataclass(frozen=True, slots=True)
class Stretch:
    """A section as the playhead knows it."""

    name: str
    measures: int | None
    """How long one pass is; None: it has no end."""
    repeat: int = 1
    """How many passes there are before it goes on; 0: until somebody says so."""
    then: int = END
    """Index of the section that comes after it, or END."""


@dataclass(frozen=True, slots=True)
class Place:
    """One measure of the score."""

    section: int
    """Index of the section; END before the first downbeat and when the score is over."""
    measure: int
    """Measure within the section, from 0."""
    turn: int = 0
    """How often this section had begun before, since the start of the show."""


@dataclass(frozen=True, slots=True)
class Stand:
    """Where the score is in one measure of the show, and what must be known to go on."""

    place: Place
    passes: int
    """Passes of this visit to the section, the present one included."""
    begun: tuple[int, ...]
    """How often each section has begun."""
    entered: bool
    """Whether the score came to this place with this measure: what is held in its measure begins nothing again."""
    jumped: bool = False
    """Whether it came here because somebody asked."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What waits for a line."""

    section: int | None = None
    """Where a jump goes ..."""
    measure: int = 0
    at_section: bool = False
    """... and whether it waits for the section's end."""
    leave: bool = False
    """Whether the section is left when its pass is over, whatever it repeats."""
