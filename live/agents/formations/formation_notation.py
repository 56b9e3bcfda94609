"""Short notation for formations: "circle", "star:6 poisson", "text:LIVE" (for the command line and live calls)."""

from typing import Any, Final

from live.agents.formations.formation_spec import INSIDE_PATTERNS, SHAPES, FormationSpec, spec_from_table
from live.base.errors import PersonError

_POLYGONS: Final = {"triangle": 3, "pentagon": 5, "hexagon": 6, "octagon": 8}
_ARGUMENT_FIELDS: Final = {"text": "text", "path": "path", "star": "corners", "polygon": "corners", "spiral": "turns"}
EXAMPLES: Final = "circle, line, grid, star, star:6, triangle, spiral, text:LIVE, 'circle poisson', 'star inside'"


def parse_formation(notation: str) -> FormationSpec:
    """Return the spec of a shape followed by inside, on, or a pattern. PersonError with examples if it is invalid.

    A colon introduces the shape's argument: text:LIVE, star:6 (points), spiral:3 (turns), path:D. The argument of
    "text:" and "path:" is the rest of the string.
    """
    first, _, after = notation.strip().partition(":")
    if first in ("text", "path") and after:
        return spec_from_table(
            {"shape": first, _ARGUMENT_FIELDS[first]: after, "name": notation[:64]}, repr(notation[:60])
        )
    parts = notation.split()
    if not parts:
        raise PersonError("a formation expected", f"such as {EXAMPLES}")
    table: dict[str, Any] = {**_parse_shape(parts[0]), "name": notation[:64]}
    for part in parts[1:]:
        if part in ("inside", "on"):
            table["dancers"] = part
        elif part in INSIDE_PATTERNS or part == "even":
            table["pattern"] = part
        else:
            raise PersonError(
                f"unknown pattern {part[:60]!r}; there are: even, {', '.join(INSIDE_PATTERNS)}, inside, on",
                f"such as {EXAMPLES}",
            )
    return spec_from_table(table, repr(notation[:60]))


def _parse_shape(word: str) -> dict[str, Any]:
    shape, _, number = word.partition(":")
    if shape in _POLYGONS and not number:
        return {"shape": "polygon", "corners": _POLYGONS[shape]}
    if shape not in SHAPES:
        raise PersonError(f"unknown formation {word[:60]!r}", f"such as {EXAMPLES}")
    if not number:
        return {"shape": shape}
    if shape not in _ARGUMENT_FIELDS:
        raise PersonError(f"{word[:60]!r}: {shape!r} takes no argument", f"such as {EXAMPLES}")
    try:
        return {"shape": shape, _ARGUMENT_FIELDS[shape]: float(number) if shape == "spiral" else int(number)}
    except ValueError:
        raise PersonError(f"{word[:60]!r}: a number expected after the colon", f"such as {EXAMPLES}") from None
