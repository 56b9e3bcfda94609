"""SVG drawing of a score: measures as boxes, in systems of some measures below each other."""

from html import escape
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from live.show.score.score_sheet import Box, Sheet, Track

WIDTH: Final = 64
"""Width of a measure [pixels]."""
HEIGHT: Final = 20
LEFT: Final = 110
GAP: Final = 26
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
    width = LEFT + per_row * WIDTH + 20
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{top:.0f}" '
            'font-family="Helvetica, Arial, sans-serif" font-size="11">',
            f'<rect width="{width}" height="{top:.0f}" fill="white"/>',
            f'<text x="12" y="26" font-size="16">{escape(sheet.title)}</text>',
            *parts,
            "</svg>",
            "",
        ]
    )


def _system(sheet: "Sheet", first: int, end: int, top: float, colours: list[str]) -> tuple[list[str], float]:
    """Draw measures `first` to before `end`, `top` [pixels] below the edge; return the elements and their height."""
    parts = [
        f'<text x="{_x(measure, first) + 2}" y="{top + 11:.0f}" fill="#888">{measure + 1}</text>'
        for measure in range(first, end)
    ]
    y = top + 16.0
    for track in sheet.tracks:
        boxes = [box for box in track.boxes if box.first < end and box.last >= first]
        if not boxes:
            continue
        lanes = _lanes(boxes)
        parts.append(f'<text x="{LEFT - 8}" y="{y + 14:.0f}" text-anchor="end">{escape(track.name[:16])}</text>')
        for lane, box in lanes:
            parts += _box(box, track, first, end, y + lane * HEIGHT, colours)
        y += HEIGHT * (max(lane for lane, _ in lanes) + 1) + 4
    lines = [
        f'<line x1="{_x(measure, first)}" y1="{top + 13:.0f}" x2="{_x(measure, first)}" y2="{y:.0f}" stroke="#bbb"/>'
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
    fill = FILLS[box.kind] or colours[track.group]
    style = ' stroke-dasharray="3 2" fill-opacity="0.45"' if box.kind == "improvised" else ' fill-opacity="0.75"'
    most = max(1, int((right - left - 6) / 5.6))
    words = box.label if len(box.label) <= most else box.label[: max(1, most - 1)] + "…"
    return [
        f'<rect x="{left + 1}" y="{y + 1:.0f}" width="{right - left - 2}" height="{HEIGHT - 2}" rx="3" fill="{fill}" '
        f'stroke="#666" stroke-width="0.6"{style}><title>{escape(box.label)}: {box.first + 1} to {box.last + 1}'
        "</title></rect>",
        f'<text x="{left + 5}" y="{y + 14:.0f}">{escape(words)}</text>',
    ]
