"""Formation spec: shape, density, pattern and other settings as one frozen value, its validation, and its form as a
TOML or JSON table (T087: stored once, referenced by name; T090-T093).

Metres and degrees; a point is (x, z) on the stage: +x to the right as the audience sees it, +z towards the audience.
"""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, NoReturn, get_args

from live.base.errors import PersonError

Shape = Literal[
    "grid",
    "line",
    "arc",
    "circle",
    "ellipse",
    "polygon",
    "rectangle",
    "star",
    "spiral",
    "text",
    "path",
    "polyline",
    "places",
]
Pattern = Literal["even", "weighted", "grid", "diagonal", "concentric", "poisson"]
SHAPES: Final[tuple[Shape, ...]] = get_args(Shape)
PATTERNS: Final[tuple[Pattern, ...]] = get_args(Pattern)
INSIDE_PATTERNS: Final = ("grid", "diagonal", "concentric", "poisson")
MAX_DANCERS: Final = 10_000
MAX_POINTS: Final = 20_000
MAX_TEXT_LENGTH: Final = 40
MAX_PATH_LENGTH: Final = 200_000
MAX_DISTANCE: Final = 1000.0
"""Largest distance of a place from the centre of the stage [m]."""


def check_spec(spec: Any) -> None:
    """Raise a PersonError for the first invalid field of a FormationSpec (typed `Any`: defined below)."""
    for check in (_check_choices, _check_numbers, _check_sections, _check_shape, _check_points, _check_pattern):
        check(spec)
    _check_mirror(spec)
    _check_like(spec)


_CHOICES: Final[dict[str, tuple[str, ...]]] = {
    "shape": SHAPES,
    "pattern": PATTERNS,
    "proportions": ("keep", "stretch"),
    "dancers": ("on", "inside"),
    "mirror_keep": ("left", "right", "front", "back"),
    "soloist_place": ("front", "centre"),
    "neighbours": ("keep", "any"),
    "heading": ("public", "centre", "outwards", "along", "angle"),
}
_RANGES: Final[dict[str, tuple[float, float]]] = {
    "rotation_deg": (-3600, 3600),
    "inner": (0.05, 0.95),
    "turns": (0.25, 20),
    "arc_deg": (1, 359),
    "focus_reach": (0.1, 100),
    "focus_strength": (0, 100),
    "density": (0.001, 100),
    "spacing": (0.1, 100),
    "soloist_gap": (0.1, 50),
    "bend_deg": (-720, 720),
    "heading_deg": (-3600, 3600),
}
_INTEGER_RANGES: Final[dict[str, tuple[int, int]]] = {
    "corners": (3, 100),
    "count": (0, MAX_DANCERS),
    "soloists": (0, 100),
}


def _check_choices(spec: Any) -> None:
    if not isinstance(spec.name, str) or len(spec.name) > 64:
        spec.refuse("name", "a name of 64 letters at most expected")
    for field in ("closed", "mark_corners"):
        if getattr(spec, field) not in (None, True, False):
            spec.refuse(field, "true or false expected")
    for field, allowed in _CHOICES.items():
        value = getattr(spec, field)
        if value is not None and value not in allowed:
            spec.refuse(field, f"{str(value)[:60]!r} is unknown; there are: {', '.join(allowed)}")


def _check_numbers(spec: Any) -> None:
    for field, (low, high) in {**_RANGES, **_INTEGER_RANGES}.items():
        value = getattr(spec, field)
        whole = field in _INTEGER_RANGES
        if value is None and (field in ("density", "spacing", "count")):
            continue
        if not _is_number(value) or (whole and value != int(value)) or not low <= value <= high:
            kind = "a whole number" if whole else "a number"
            spec.refuse(field, f"{str(value)[:60]}: {kind} from {low:g} to {high:g} expected")
    _check_point(spec, "centre", spec.centre, 100)
    if spec.focus is not None:
        _check_point(spec, "focus", spec.focus, MAX_DISTANCE)
    if spec.size is not None:
        _check_point(spec, "size", spec.size, 200)
        if min(spec.size) < 0.1 and not (spec.shape == "line" and spec.size[0] >= 0.1 and spec.size[1] >= 0):
            spec.refuse("size", f"{spec.size[0]:g} x {spec.size[1]:g} m: each from 0.1 to 200 m expected")
    if len([value for value in (spec.count, spec.density, spec.spacing) if value is not None]) > 1:
        spec.refuse(
            "count", "only one of count, density and spacing can be given: each says how many dancers there are"
        )
    for field, most in (("weights", 1000.0), ("sections", float(MAX_DANCERS))):
        values = getattr(spec, field)
        if not isinstance(values, tuple) or not all(_is_number(each) and 0 <= each <= most for each in values):
            spec.refuse(field, f"numbers from 0 to {most:g} expected")
        if values and not (len(values) <= 1000 and sum(values) > 0):
            spec.refuse(field, "at most 1000 numbers, one of them above 0, expected")


def _check_sections(spec: Any) -> None:
    names = spec.section_names
    if not isinstance(names, tuple) or not all(isinstance(name, str) and 0 < len(name) <= 64 for name in names):
        spec.refuse("section_names", "words of 1 to 64 letters expected")
    if names and len(names) != len(spec.sections):
        spec.refuse("section_names", f"{len(names)} names for {len(spec.sections)} sections")


def _check_shape(spec: Any) -> None:
    if spec.shape == "text" and not (isinstance(spec.text, str) and spec.text.strip()):
        spec.refuse("text", "the letters of the text expected", 'text = "LIVE"')
    if not isinstance(spec.text, str) or len(spec.text) > MAX_TEXT_LENGTH:
        spec.refuse("text", f"{MAX_TEXT_LENGTH} letters at most expected")
    if spec.shape == "path" and not spec.path:
        spec.refuse("path", "an SVG path expected", 'path = "M 0 0 C 2 3 4 3 6 0"')
    if not isinstance(spec.path, tuple) or not all(isinstance(each, str) for each in spec.path):
        spec.refuse("path", "SVG paths as texts expected")
    if sum(map(len, spec.path)) > MAX_PATH_LENGTH:
        spec.refuse("path", f"longer than {MAX_PATH_LENGTH} characters", "draw it with fewer points")


def _check_points(spec: Any) -> None:
    if spec.shape == "polyline" and not spec.points:
        spec.refuse("points", "a list of points [x, z] expected", "points = [[-3, 0], [0, -2], [3, 0]]")
    if spec.shape == "places":
        _check_places(spec)
    elif spec.headings_deg:
        spec.refuse("headings_deg", "are for shape = 'places'", "heading = 'angle' with heading_deg turns all")
    if spec.points and spec.shape not in ("polyline", "polygon", "places"):
        spec.refuse(
            "points",
            f"points draw a line or an outline, and the shape is {spec.shape!r} (grid, if none is written)",
            "add shape = 'polyline' or 'polygon', or leave points out",
        )
    if not isinstance(spec.points, tuple) or not all(isinstance(line, tuple) for line in spec.points):
        spec.refuse("points", "a list of points [x, z], or several such lists, expected", "points = [[-3, 0], [3, 0]]")
    if sum(map(len, spec.points)) > MAX_POINTS:
        spec.refuse("points", f"more than {MAX_POINTS} points", "draw with fewer points")
    if spec.shape == "polygon" and len(spec.points) > 1:
        spec.refuse("points", "a polygon has one line", "several lines are shape = 'polyline'")
    for line in spec.points:
        if len(line) < 2 and spec.shape != "places":
            spec.refuse("points", "a line needs two points at least")
        for point in line:
            _check_point(spec, "points", point, MAX_DISTANCE)


def _check_places(spec: Any) -> None:
    if len(spec.points) != 1:
        spec.refuse("points", "a list of places [x, z] expected", "points = [[-1, 0], [1, 0]]")
    if isinstance(spec.points[0], tuple) and len(spec.points[0]) > MAX_DANCERS:
        spec.refuse("points", f"more than {MAX_DANCERS} places")
    headings = spec.headings_deg
    if not isinstance(headings, tuple) or not all(_is_number(each) and abs(each) <= 3600 for each in headings):
        spec.refuse("headings_deg", "numbers from -3600 to 3600 expected")
    if headings and len(headings) != len(spec.points[0]):
        spec.refuse("headings_deg", f"{len(headings)} headings for {len(spec.points[0])} places")
    for field in ("dancers", "pattern", "weights", "focus", "count", "density", "spacing", "mirror"):
        if getattr(spec, field) not in (None, ()):
            spec.refuse(field, "is for lines and areas; places stand where they are written", f"leave {field} out")
    if spec.heading == "along":
        spec.refuse("heading", "there is no line along which places could face", "give headings_deg")


def _check_pattern(spec: Any) -> None:
    if spec.pattern == "weighted" and not spec.weights and spec.focus is None:
        spec.refuse("pattern", "weighted needs weights along the line, or a focus", "focus = [0, 2]")
    if spec.inside and spec.weights:
        spec.refuse("weights", "weights run along lines; inside a shape a focus says where dancers are denser")
    if spec.pattern in INSIDE_PATTERNS and spec.dancers == "on":
        spec.refuse("pattern", f"{spec.pattern!r} is for dancers inside; on lines: even or weighted")
    if spec.pattern in (*INSIDE_PATTERNS, "even") and (spec.weights or spec.focus is not None):
        spec.refuse("pattern", f"{spec.pattern!r} takes no weights or focus", "pattern = 'weighted'")
    if spec.shape == "grid" and (spec.dancers == "on" or spec.pattern not in (None, "even")):
        spec.refuse("pattern", "a grid is rows already", "shape = 'rectangle' takes all patterns")
    if spec.shape == "grid" and (spec.weights or spec.focus is not None):
        spec.refuse("pattern", "a grid is even rows", "shape = 'rectangle' with pattern = 'weighted'")
    if spec.density is not None and not spec.inside and spec.shape != "grid":
        spec.refuse("density", "is for dancers inside a shape; on lines give the spacing", "spacing = 1.0")


def _check_mirror(spec: Any) -> None:
    mirror = spec.mirror
    if mirror is not None and spec.shape == "grid" and spec.like is None:
        spec.refuse(
            "mirror", "a grid is staggered rows, which have no symmetry", "shape = 'rectangle', pattern = 'grid'"
        )
    if spec.mirror_at is not None:
        if mirror is None or isinstance(mirror, tuple):
            spec.refuse(
                "mirror_at", "is the point of a line whose direction is given by mirror", "mirror = 'left-right'"
            )
        _check_point(spec, "mirror_at", spec.mirror_at, MAX_DISTANCE)
    if mirror is None or mirror in ("left-right", "front-back"):
        return
    if _is_number(mirror):
        if abs(mirror) > 360:
            spec.refuse("mirror", f"{mirror:g}: a direction from -360 to 360 degrees expected")
        return
    if not isinstance(mirror, tuple) or len(mirror) != 2:
        what = "'left-right', 'front-back', a direction in degrees or two points expected"
        spec.refuse("mirror", what, "mirror = [[0, -4], [0, 4]]")
    for point in mirror:
        _check_point(spec, "mirror", point, MAX_DISTANCE)
    if math.dist(mirror[0], mirror[1]) < 1e-3:
        spec.refuse("mirror", "both points are the same: there is no line through them")


def _check_like(spec: Any) -> None:
    scale = spec.scale if isinstance(spec.scale, tuple) else (spec.scale, spec.scale)
    if len(scale) != 2 or not all(_is_number(each) and 0.01 <= each <= 100 for each in scale):
        spec.refuse("scale", f"{str(spec.scale)[:60]}: a number from 0.01 to 100, or two, expected")
    if spec.like is None:
        given = [
            field
            for field in ("scale", "bend_deg", "along", "into", "neighbours")
            if getattr(spec, field) != _FIELDS[field]
        ]
        if given:
            spec.refuse(given[0], "transforms another formation, and there is none", 'like = "wave"')
        return
    if not isinstance(spec.like, str | FormationSpec) or spec.like == "":
        spec.refuse("like", "the name of a formation expected", 'like = "wave"')
    if spec.size is not None and scale != (1.0, 1.0):
        spec.refuse("scale", "and size: leave one out")
    if spec.along and spec.into:
        spec.refuse("along", "and into: leave one out; another formation can be like this one")
    if not isinstance(spec.along, str):
        _check_line(spec, "along", spec.along)
    if not isinstance(spec.into, str):
        if not isinstance(spec.into, tuple):
            spec.refuse(
                "into", "points of a closed line, or the name of a formation, expected", "[[-3, 0], [3, 0], [0, 4]]"
            )
        for ring in spec.into:
            _check_line(spec, "into", ring)


def _check_line(spec: Any, field: str, points: Any) -> None:
    """Refuse what is no line of points; an empty one is none."""
    if not isinstance(points, tuple) or len(points) > MAX_POINTS:
        spec.refuse(field, f"up to {MAX_POINTS} points [x, z] expected", f"{field} = [[-3, 0], [0, -2], [3, 0]]")
    for point in points:
        _check_point(spec, field, point, MAX_DISTANCE)


def _check_point(spec: Any, field: str, point: object, most: float) -> None:
    pair = isinstance(point, tuple) and len(point) == 2
    if not (pair and isinstance(point, tuple) and all(_is_number(each) and abs(each) <= most for each in point)):
        spec.refuse(field, f"{str(point)[:60]}: two numbers up to {most:g} m expected")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class FormationSpec:
    """A formation as specified by a choreographer; fields that do not apply to the shape or pattern are ignored.

    PersonError, naming the field, if a value is invalid.
    """

    shape: Shape = "grid"
    """Lines on the floor; "grid" is staggered rows that fill `size`."""
    name: str = ""
    """Name by which evolutions and scores refer to it."""
    centre: Point = (0.0, 0.0)
    """Middle of the formation (x, z) [m]; an offset for `points` without a `size`."""
    size: Point | None = None
    """Width and depth [m] into which the shape is fitted; default 8 x 5, and `points` stay as drawn."""
    proportions: Literal["keep", "stretch"] | None = None
    """Whether the shape keeps its proportions in `size`; default: stretch for line, grid, rectangle, ellipse, and a
    circle with a `size`, else keep.
    """
    rotation_deg: float = 0.0
    """Rotation about the middle; positive turns the front towards +x."""
    corners: int = 5
    """Corners of a polygon without points, points of a star."""
    inner: float = 0.4
    """Inner radius of a star as a share of the outer one."""
    turns: float = 2.5
    """Turns of a spiral."""
    arc_deg: float = 180.0
    """Angle of an arc; its middle lies at the back, so that it opens to the public."""
    text: str = ""
    """Letters A to Z, digits, blanks and hyphens, readable from the public."""
    path: tuple[str, ...] = ()
    """SVG paths (the text of `d`); their y points to the public."""
    points: tuple[tuple[Point, ...], ...] = ()
    """Drawn lines, each a tuple of points (x, z) [m]; a polygon has one. Of "places": one tuple, the places."""
    closed: bool | None = None
    """Whether drawn lines are closed; default: if the last point equals the first, or dancers are inside."""
    dancers: Literal["on", "inside"] | None = None
    """On the lines or inside closed ones; default: as the pattern requires, else on."""
    pattern: Pattern | None = None
    """On lines: even or weighted. Inside: even, weighted, grid, diagonal, concentric, poisson. Default: even, or
    weighted if weights or a focus are given.
    """
    mark_corners: bool | None = None
    """Whether corners of lines are filled first; default: for text, polygon, rectangle and star."""
    weights: tuple[float, ...] = ()
    """Relative density along each line, at equal distances from its start to its end."""
    focus: Point | None = None
    """Place (x, z) [m] around which dancers are denser."""
    focus_reach: float = 2.0
    """Reach of the focus [m]."""
    focus_strength: float = 3.0
    """Density at the focus relative to far from it is 1 + this."""
    count: int | None = None
    """Number of places, soloists included; default: number of dancers, or from density or spacing."""
    density: float | None = None
    """Dancers per square metre inside; determines the count."""
    spacing: float | None = None
    """Distance between neighbours [m]; determines the count."""
    mirror: Literal["left-right", "front-back"] | float | tuple[Point, Point] | None = None
    """Symmetry line: from back to front, from side to side, in a direction [degrees; 0: to the public, positive towards
    +x], or through two points."""
    mirror_at: Point | None = None
    """A point (x, z) [m] of the symmetry line; default: the middle of the stage."""
    mirror_keep: Literal["left", "right", "front", "back"] | None = None
    """Side of the symmetry line that is kept and reflected, as the audience sees it; default: left, else back; if
    nothing of the shape lies there, the other one."""
    soloists: int = 0
    """Number of soloists."""
    soloist_place: Literal["front", "centre"] = "front"
    """Soloists stand in front of the others, or in the middle of the shape, where the others make room."""
    soloist_gap: float = 1.5
    """Distance of soloists from the others [m]."""
    sections: tuple[int, ...] = ()
    """Sizes of sections whose dancers get neighbouring places; proportions, if their sum differs from the count."""
    section_names: tuple[str, ...] = ()
    """A word for each section: dancers with this attribute get its places."""
    heading: Literal["public", "centre", "outwards", "along", "angle"] = "public"
    """Facing direction: the public, the middle, away from it, along the line, or `heading_deg`."""
    heading_deg: float = 0.0
    """Heading for "angle": 0 faces the public, positive towards +x."""
    headings_deg: tuple[float, ...] = ()
    """Of "places": the heading of each; empty: as `heading` says."""
    like: Any = None
    """Instead of a shape: another formation, by name or in words, whose places are transformed with neighbours kept, in
    this order: `scale` or `size` (with `proportions`), `bend_deg`, `rotation_deg`, moved by `centre`, `mirror` (then
    all places are mirrored about it), `along`, `into`."""
    scale: float | Point = 1.0
    """With `like`: how many times as large; two numbers: in width and in depth."""
    bend_deg: float = 0.0
    """With `like`: angle of the arc to which its width is bent; positive: both sides come to the public."""
    along: Any = ()
    """With `like`: the line on which its width is laid: points (x, z) [m], or the name of a formation with a line."""
    into: Any = ()
    """With `like`: the region into which it is squeezed: points (x, z) [m] of a closed line, or several (a line within
    another is a hole), or the name of a formation with closed lines. Bodies never touch; too many dancers are refused.
    `proportions`: stretch fills the region at any cost, keep does not stretch; left out: it is filled as far as
    neighbours stay neighbours."""
    neighbours: Literal["keep", "any"] | None = None
    """With `like`: keep: neighbours stay neighbours, also where it is stretched; any: places are only mapped; left out:
    lines stay lines where it is scaled, neighbours are kept where it is bent, along a line or in a region."""
    counts_ahead: tuple[int, ...] = ()
    """Numbers of dancers for which `into` is computed when a show is loaded; for others places follow from the nearest
    of them. Set by the show; empty: all are computed."""

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
        """The pattern with its default resolved."""
        if self.pattern is not None:
            return self.pattern
        return "weighted" if self.weights or self.focus is not None else "even"

    def refuse(self, field: str, what: str, remedy: str | None = None) -> NoReturn:
        """Raise a PersonError that names this formation and the field."""
        named = f"formation {self.name!r}" if isinstance(self.name, str) and self.name else "formation"
        raise PersonError(f"{named}: {field}: {what}", remedy)


_FIELDS: Final = {field.name: field.default for field in dataclasses.fields(FormationSpec)}
_OWN_SHAPE: Final = ("shape", "corners", "inner", "turns", "arc_deg", "text", "path", "points", "closed", "dancers",
    "pattern", "mark_corners", "weights", "focus", "focus_reach", "focus_strength", "count", "density", "spacing",
    "mirror_keep", "soloists", "soloist_place", "soloist_gap", "sections", "section_names", "headings_deg",
)  # fmt: skip
"""Keys that say what the places are, which a formation that is like another one has from that one."""


def spec_from_table(table: Mapping[str, Any], where: str = "formation") -> FormationSpec:
    """Return the spec of a table; keys are the fields of FormationSpec. PersonError, naming the key, if it is invalid.

    `where` names the table in the message. `path` may be one text, `points` one line or several.
    """
    if not isinstance(table, Mapping):
        raise PersonError(f"{where}: a table expected, not {type(table).__name__}")
    unknown = [str(key) for key in table if key not in _FIELDS or key == "counts_ahead"]
    if unknown:
        raise PersonError(
            f"{where}: unknown key {unknown[0][:60]!r} of a formation; there are: "
            + ", ".join(key for key in _FIELDS if key != "counts_ahead")
        )
    own = [key for key in _OWN_SHAPE if key in table and "like" in table]
    if own:
        raise PersonError(f"{where}: like and {own[0]}: leave one out; it has the places of {table['like']!r}")
    values = {key: _to_tuples(value) for key, value in table.items()}
    if isinstance(values.get("path"), str):
        values["path"] = (values["path"],)
    points = values.get("points")
    if isinstance(points, tuple) and points and _is_point(points[0]):
        values["points"] = (points,)
    into = values.get("into")
    if isinstance(into, tuple) and into and _is_point(into[0]):
        values["into"] = (into,)
    try:
        return FormationSpec(**values)
    except TypeError:  # nested in a way that no field accepts
        raise PersonError(f"{where}: a value has an unexpected nesting", "compare `live docs formations`") from None


def _to_tuples(value: Any) -> Any:
    """Convert lists to tuples, recursively."""
    return tuple(_to_tuples(each) for each in value) if isinstance(value, list | tuple) else value


def _is_point(value: object) -> bool:
    return isinstance(value, tuple) and len(value) > 0 and not isinstance(value[0], tuple)
