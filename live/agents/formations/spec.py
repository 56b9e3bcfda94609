"""What a formation is to be: shape, density, pattern and the rest, as one frozen value (T087, T090-T093).

Metres and degrees; a point is (x, z) on the stage: +x to the right as the audience sees it, +z towards the audience.
"""

from dataclasses import dataclass
from typing import Literal, NoReturn

from live.agents.formations.spec_checks import INSIDE_PATTERNS, check_spec
from live.base.errors import PersonError

Point = tuple[float, float]
Shape = Literal[
    "grid", "line", "arc", "circle", "ellipse", "polygon", "rectangle", "star", "spiral", "text", "path", "polyline"
]
Pattern = Literal["even", "weighted", "grid", "diagonal", "concentric", "poisson"]


@dataclass(frozen=True, slots=True)
class FormationSpec:
    """A formation as a choreographer wishes it; every field has a meaning only where it is named.

    PersonError, naming the field, if a value cannot be.
    """

    shape: Shape = "grid"
    """Lines on the floor; "grid" is staggered rows that fill `size`."""
    name: str = ""
    """What others call it by."""
    centre: Point = (0.0, 0.0)
    """Middle of the formation (x, z) [m]; `points` without a `size` are moved by it."""
    size: Point | None = None
    """Width and depth [m] into which the shape is fitted; left out: 8 x 5, and `points` stay as drawn."""
    proportions: Literal["keep", "stretch"] | None = None
    """Whether the shape keeps its proportions in `size`; left out: line, grid, rectangle, ellipse, and a circle
    with a `size`, are stretched, all others keep them."""
    rotation_deg: float = 0.0
    """The shape is turned about its middle; positive turns its front towards +x."""
    corners: int = 5
    """Corners of a polygon without points, points of a star."""
    inner: float = 0.4
    """Inner radius of a star as a share of the outer one."""
    turns: float = 2.5
    """Turns of a spiral."""
    arc_deg: float = 180.0
    """How much of a circle an arc is; its middle lies at the back, so that it opens to the public."""
    text: str = ""
    """Letters A to Z, digits, blanks and hyphens of a text, readable from the public."""
    path: tuple[str, ...] = ()
    """SVG paths (the text of `d`); their y points to the public."""
    points: tuple[tuple[Point, ...], ...] = ()
    """Drawn lines, each a tuple of points (x, z) [m]; a polygon has one."""
    closed: bool | None = None
    """Whether drawn lines are closed; left out: if the last point is the first one, or dancers are inside."""
    dancers: Literal["on", "inside"] | None = None
    """On the lines or inside closed ones; left out: as the pattern needs it, else on."""
    pattern: Pattern | None = None
    """On lines: even or weighted. Inside: even, weighted, grid, diagonal, concentric, poisson. Left out: even, or
    weighted where weights or a focus are given."""
    mark_corners: bool | None = None
    """Whether corners of lines get a dancer before the rest; left out: for text, polygon, rectangle and star."""
    weights: tuple[float, ...] = ()
    """How dense dancers are along each line, at equal distances from its start to its end."""
    focus: Point | None = None
    """A place (x, z) [m] around which dancers are denser."""
    focus_reach: float = 2.0
    """How far the focus reaches [m]."""
    focus_strength: float = 3.0
    """How much denser they are at the focus than far from it: 1 + this."""
    count: int | None = None
    """How many places there are, soloists included; left out: as many as dancers, or as density or spacing say."""
    density: float | None = None
    """Dancers per square metre inside; the count follows."""
    spacing: float | None = None
    """Distance between neighbours [m]; the count follows."""
    mirror: Literal["left-right", "front-back"] | tuple[Point, Point] | None = None
    """Symmetry line: from back to front or from side to side through the centre, or through two points."""
    mirror_keep: Literal["left", "right", "front", "back"] | None = None
    """The side of the symmetry line that is reflected over it, as the audience sees it; left out: left, else back."""
    soloists: int = 0
    """How many dancers stand apart from the others."""
    soloist_place: Literal["front", "centre"] = "front"
    """In front of the others, or in the middle of the shape, where the others make room."""
    soloist_gap: float = 1.5
    """How far from the others [m]."""
    sections: tuple[int, ...] = ()
    """Sizes of sections whose dancers get neighbouring places; shares, if their sum is another than the count."""
    section_names: tuple[str, ...] = ()
    """A word for each section: dancers who have it as an attribute get its places."""
    heading: Literal["public", "centre", "outwards", "along", "angle"] = "public"
    """Where dancers face: the public, the middle, away from it, along the line, or `heading_deg`."""
    heading_deg: float = 0.0
    """Heading for "angle": 0 faces the public, positive towards +x."""

    def __post_init__(self) -> None:
        check_spec(self)

    @property
    def inside(self) -> bool:
        """Whether dancers are inside closed lines, not on them."""
        if self.dancers is not None:
            return self.dancers == "inside"
        return self.pattern in INSIDE_PATTERNS

    @property
    def distribution(self) -> Pattern:
        """The pattern, also where it is left out."""
        if self.pattern is not None:
            return self.pattern
        return "weighted" if self.weights or self.focus is not None else "even"

    def refuse(self, field: str, what: str, remedy: str | None = None) -> NoReturn:
        """Raise a PersonError that names this formation and the field."""
        named = f"formation {self.name!r}" if isinstance(self.name, str) and self.name else "formation"
        raise PersonError(f"{named}: {field}: {what}", remedy)
