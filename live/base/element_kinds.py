"""Kinds of procedural elements (T105-T110, T132): a new one is one row here, and its kernel.

From a row come its OSC addresses, its name in the patch's `[[element]]` and in the score, and its number in the
kernels' table.
"""

from dataclasses import dataclass
from typing import Final, Literal

ATTRACTOR: Final = 0
REPULSOR: Final = 1
SPREADER: Final = 2
CROSSING: Final = 3
FLOW: Final = 4
WANDER: Final = 5
FLOCK: Final = 6
FOLLOW: Final = 7
PURSUE: Final = 8
EVADE: Final = 9
PATH: Final = 10
PARTICIPANT: Final = 11
"""The attractor of one audience member."""
PHONE_LIGHT: Final = 12
"""The light of an audience member's phone, in its colour; drawn only."""
UNIFORM: Final = 0
RADIAL: Final = 1
VORTEX: Final = 2
DRAWN: Final = 3
GRID: Final = 4

Place = Literal["none", "point", "line", "drawn", "region", "target"]
"""What an address is told about the element's place: nothing, a point, two points, a drawn line, a disc, or whom it
follows."""


@dataclass(frozen=True, slots=True)
class ElementControl:
    """One address that places an element."""

    suffix: str
    """What follows the kind's address, as in "line"; empty: nothing."""
    place: Place
    description: str
    role: Literal["audience", "musician", "operator"] = "musician"
    flow: str = ""
    """The kind of flow, see `FLOW_NAMES`."""
    reversible: bool = False
    """Whether its strength may be below 0."""
    has_strength: bool = True


@dataclass(frozen=True, slots=True)
class ElementKind:
    """One kind of element."""

    name: str
    number: int
    """Its number in the kernels."""
    text: str
    """What it makes dancers do, for the reference."""
    controls: tuple[ElementControl, ...]
    decay: float = 1.2
    """Usual length of its fall-off [m]."""
    needs_line: bool = False
    """Whether it needs two points or more."""


ELEMENT_KINDS: Final = (
    ElementKind("attract", ATTRACTOR, "gather", (
        ElementControl("", "point", "Dancers gather around a point of the stage.", "audience"),
        ElementControl("line", "line", "Dancers gather along a line."),
        ElementControl("drawn", "drawn", "Dancers gather along a drawn line."),
        ElementControl("region", "region", "Dancers come into a region; inside it they move freely."),
    )),
    ElementKind("repel", REPULSOR, "leave", (
        ElementControl("", "point", "Dancers move away from a point."),
        ElementControl("line", "line", "Dancers move away from a line."),
        ElementControl("region", "region", "Dancers leave a region."),
    ), decay=1.6),
    ElementKind("spread", SPREADER, "spread over the stage", (
        ElementControl("", "none", "Dancers spread over the stage.", has_strength=False),
    )),
    ElementKind("cross", CROSSING, "change sides over a bar", (
        ElementControl("", "line", "Dancers cross a line through two points: each side changes to the other."),
    ), needs_line=True),
    ElementKind("flow", FLOW, "flow with a field", (
        ElementControl("", "line", "Dancers go in the direction from the first point to the second, everywhere on the "
                       "stage.", flow="uniform"),
        ElementControl("radial", "point", "Dancers go away from a point; with a strength below 0 towards it.",
                       flow="radial", reversible=True),
        ElementControl("vortex", "point", "Dancers go around a point.", flow="vortex", reversible=True),
        ElementControl("drawn", "drawn", "Dancers go in the direction of a drawn line.", flow="drawn"),
    )),
    ElementKind("path", PATH, "follow a drawn path", (
        ElementControl("", "drawn", "Dancers follow a drawn path."),
    ), needs_line=True),
    ElementKind("wander", WANDER, "wander", (ElementControl("", "none", "Dancers wander."),)),
    ElementKind("flock", FLOCK, "flock", (
        ElementControl("", "none", "Dancers move together, like birds in a flock."),
    )),
    ElementKind("follow", FOLLOW, "follow a leader", (ElementControl("", "target", "Dancers follow a leader."),)),
    ElementKind("pursue", PURSUE, "pursue a dancer", (
        ElementControl("", "target", "Dancers pursue a dancer or group."),
    )),
    ElementKind("evade", EVADE, "evade a dancer", (
        ElementControl("", "target", "Dancers evade a dancer or group."),
    ), decay=2.5),
)  # fmt: skip
"""All kinds, in the order of the reference."""

KIND_NAMES: Final = {kind.name: kind.number for kind in ELEMENT_KINDS}
"""Their numbers by name."""
FLOW_NAMES: Final = {"uniform": UNIFORM, "radial": RADIAL, "vortex": VORTEX, "drawn": DRAWN, "grid": GRID}
"""Kinds of flow by name."""
TARGETED_KINDS: Final = frozenset(
    kind.number for kind in ELEMENT_KINDS if any(control.place == "target" for control in kind.controls)
)
"""Numbers of the kinds that need a dancer or a group as their target."""
LINE_KINDS: Final = frozenset(kind.number for kind in ELEMENT_KINDS if kind.needs_line)
"""Numbers of the kinds that need two points or more."""
DECAYS: Final = {kind.number: kind.decay for kind in ELEMENT_KINDS}
"""Usual length of the fall-off of each kind [m]."""
if len({*KIND_NAMES.values(), PARTICIPANT, PHONE_LIGHT}) < len(KIND_NAMES) + 2:
    raise ValueError("two kinds of element have the same number")
KIND_COUNT: Final = 1 + max(PARTICIPANT, *KIND_NAMES.values())
"""Length of an array that has a place for each number."""
EVERYBODY: Final = (1 << 64) - 1
"""Group mask that addresses all dancers, including those of no group."""
MAX_VERTICES: Final = 512
"""Largest number of vertices of a drawn line that dancers follow; longer lines are simplified."""
OUTLINE_VERTICES: Final = 64
"""Largest number of vertices of a drawn line in the picture, and of a flow along it."""
MAX_POINTS: Final = 4096
"""Largest number of points of a drawn line."""
