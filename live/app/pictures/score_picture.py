"""SVG drawing of a score: measures as boxes, in systems of some measures below each other."""

from typing import TYPE_CHECKING, Final

from live.app.pictures import svg

if TYPE_CHECKING:
    from live.show.score.score_sheet import Box, Sheet, Track

WIDTH: Final = 64
"""Width of a measure [pixels]."""
HEIGHT: Final = 20
LEFT: Final = 110
GAP: Final = 26
INDENT: Final = 12
"""Indent of a part below its group [pixels]."""
MAX_LETTERS: Final = 18
"""Maximum length of a name; of a part less."""
NO_GROUP: Final = "#cfcfcf"
"""Colour of what belongs to several groups."""
FILLS: Final = {
    "section": "#d9d4c7", "signal": "#f2d36b", "sequence": "", "improvised": "", "own": "#f2f2f0",
    "segment": "#b8cfe0", "element": "#d7e3c4", "regroup": "#e3c9dc", "call": "#f0dcc8",
}  # fmt: skip


def score_picture(sheet: "Sheet", colours: list[str], *, per_row: int = 16) -> str:
    """Return the sheet as SVG; `colours`: of the groups as #rrggbb."""
    systems = [(first, min(first + per_row, sheet.measures)) for first in range(0, sheet.measures, per_row)]
    parts, top = [], 44.0
    for first, end in systems:
        drawn, height = _system(sheet, first, end, top, colours)
        parts += drawn
        top += height + GAP
    title = svg.text(12, 26, sheet.title, font_size=16)
    return svg.drawing(LEFT + per_row * WIDTH + 20, top, [title, *parts], font_size=11)


def _system(sheet: "Sheet", first: int, end: int, top: float, colours: list[str]) -> tuple[list[str], float]:
    """Draw measures `first` to before `end`, `top` [pixels] below the edge; return the elements and their height."""
    parts = [svg.text(_x(measure, first) + 2, top + 11, str(measure + 1), fill="#888") for measure in range(first, end)]
    y = top + 16.0
    for track in sheet.tracks:
        boxes = [box for box in track.boxes if box.first < end and box.last >= first]
        if not boxes:
            continue
        lanes = _lanes(boxes)
        name = svg.text(INDENT * track.depth + 4, y + 14, track.name[: MAX_LETTERS - 2 * track.depth])
        parts.append(name)
        for lane, box in lanes:
            parts += _box(box, track, first, end, y + lane * HEIGHT, colours)
        y += HEIGHT * (max(lane for lane, _ in lanes) + 1) + 4
    lines = [
        svg.element("line", x1=_x(measure, first), y1=top + 13, x2=_x(measure, first), y2=y, stroke="#bbb")
        for measure in range(first, end + 1)
    ]
    return lines + parts, y - top


def _x(measure: int, first: int) -> int:
    return LEFT + (measure - first) * WIDTH


def _lanes(boxes: "list[Box]") -> "list[tuple[int, Box]]":
    """Assign overlapping boxes to lanes below each other."""
    free: list[int] = []
    placed = []
    for box in sorted(boxes, key=lambda each: each.first):
        lane = next((index for index, last in enumerate(free) if last < box.first), len(free))
        free[lane : lane + 1] = [box.last]
        placed.append((lane, box))
    return placed


def _box(box: "Box", track: "Track", first: int, end: int, y: float, colours: list[str]) -> list[str]:
    left, right = _x(max(box.first, first), first), _x(min(box.last + 1, end), first)
    fill = FILLS[box.kind] or (colours[track.group] if track.group >= 0 else NO_GROUP)
    improvised = box.kind == "improvised"
    most = max(1, int((right - left - 6) / 5.6))
    words = box.label if len(box.label) <= most else box.label[: max(1, most - 1)] + "…"
    title = svg.element("title", svg.plain(f"{box.label}: {box.first + 1} to {box.last + 1}"))
    size = {"x": left + 1, "y": y + 1, "width": right - left - 2, "height": HEIGHT - 2, "rx": 3}
    dash, opacity = ("3 2", 0.45) if improvised else (None, 0.75)
    rect = svg.element(
        "rect", title, **size, fill=fill, stroke="#666", stroke_width=0.6, stroke_dasharray=dash, fill_opacity=opacity
    )
    return [rect, svg.text(left + 5, y + 14, words)]
