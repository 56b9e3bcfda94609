"""Pages of the storyboard: a stage picture for each scene with its measures, counts, and what leads whom."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int32
from live.document.sheets.dancer_part import WAY_TOLERANCE, simplified
from live.document.sheets.page import FAINT, LEADING, MARGIN, SMALL, TEXT, Page, SceneArea, shortened, wrapped
from live.document.sheets.scenes import Scene, count_label, measures_words, scene_lines, scene_title
from live.document.sheets.sheet_book import FOOT, HEAD, SheetBook, add_feet, add_legend, add_notes, fit_pages, new_page
from live.document.sheets.stage_picture import NUMBER_RADIUS, StagePicture, mark_radius

GAP: Final = 16.0
"""Space between pictures [pt]."""
MAX_LINES: Final = 6
"""Most lines of words above a picture."""
MARKS_WIDTH: Final = 12.4
"""Distance of neighbours on paper from which on two pictures stand side by side [pt]."""
MOVED_M: Final = 0.5
"""Ways shorter than this have no arrow [m]: steps sway."""
TITLE: Final = 10.5
_READING: Final = (
    "A mark is where a dancer is when the scene ends, with a line to where she faces; an arrow leads there from where "
    "the scene begins. Counts are measure:count."
)


@dataclass(frozen=True, slots=True)
class _Cell:
    scene: Scene
    number: int
    title: str
    lines: tuple[str, ...]

    @property
    def head(self) -> float:
        """Height of its words [pt]."""
        return TITLE * LEADING + len(self.lines) * SMALL * LEADING + 4.0


def storyboard_pages(book: SheetBook, paper: str) -> list[Page]:
    """Return the pages of the storyboard, one at least."""
    page = new_page(paper, book, "Storyboard", book.facts)
    y = add_legend(page, book, MARGIN + HEAD - 8.0)
    y = add_notes(page, y, [_READING, *book.notes]) + 8.0
    pages, bottom = [page], page.height - MARGIN - FOOT
    columns = _columns(book, page.inner_width)
    column_width = (page.inner_width - (columns - 1) * GAP) / columns
    tallest = bottom - y - 80.0
    widest = min(column_width, (tallest - 20.0) * book.plan.size[0] / book.plan.size[1])
    cells = [_cell(book, scene, number, column_width) for number, scene in enumerate(book.scenes, 1)]
    rows = [cells[first : first + columns] for first in range(0, len(cells), columns)]
    heads = [max(cell.head for cell in row) for row in rows]
    top = MARGIN + HEAD

    def heights(factor: float) -> list[float]:
        return [head + book.plan.height_for(widest * factor) + GAP for head in heads]

    width = widest * fit_pages(heights, bottom + GAP - y, bottom + GAP - top)
    for row, head in zip(rows, heads, strict=True):
        height = head + book.plan.height_for(width)
        if y + height > bottom and y > top:
            page = new_page(paper, book, "Storyboard", book.facts)
            pages.append(page)
            y = top
        for column, cell in enumerate(row):
            _draw(page, book, cell, (MARGIN + column * (column_width + GAP), y), width, head)
        y += height + GAP
    add_feet(pages, f"{book.title} · storyboard")
    return pages


def _columns(book: SheetBook, width: float) -> int:
    """Return 2 if marks with numbers have room in pictures side by side, else 1."""
    record = book.record
    half = (width - GAP) / 2.0 / book.plan.size[0]
    near = []
    for scene in book.scenes:
        radius = mark_radius(_places(book, int(record.lines[scene.end]))[1], half, NUMBER_RADIUS)
        near.append(radius >= MARKS_WIDTH / 2.0)
    return 2 if np.mean(near) > 0.5 else 1


def _places(book: SheetBook, row: int) -> tuple[Int32, Float64]:
    """Return who is on the stage at a sample, and where [m], (D, 2)."""
    who = book.dancers[book.record.present[row, book.dancers]]
    return who, book.record.place[row, who].astype(np.float64)


def _cell(book: SheetBook, scene: Scene, number: int, width: float) -> _Cell:
    record = book.record
    title = f"{number} · {measures_words(record, scene)} · {scene_title(scene)}"
    counts = (scene.end - scene.first) * record.beats
    begin, over = scene.beats(record)
    span = f"{counts} counts, {count_label(record, begin)} to {count_label(record, over - 1.0)}"
    lines = [line for one in (span, *scene_lines(record, scene)) for line in wrapped(one, width, SMALL)]
    if len(lines) > MAX_LINES:
        lines = [*lines[: MAX_LINES - 1], f"… and {len(lines) - MAX_LINES + 1} lines more: see the score"]
    return _Cell(scene, number, shortened(title, width, TITLE, True), tuple(lines))


def _draw(page: Page, book: SheetBook, cell: _Cell, corner: tuple[float, float], width: float, head: float) -> None:
    x, y = corner
    page.areas.append(SceneArea(cell.number, corner, width, head + book.plan.height_for(width)))
    page.words((x, y + TITLE), cell.title, TITLE, bold=True)
    line_y = y + TITLE * LEADING
    for line in cell.lines:
        page.words((x, line_y + SMALL), line, SMALL, ink=FAINT)
        line_y += SMALL * LEADING
    picture = StagePicture(page, book.plan, (x, y + head), width)
    picture.floor()
    record = book.record
    rows, ways = record.rows(cell.scene.first, cell.scene.end), book.ways[cell.number - 1]
    who, places = _places(book, rows.stop - 1)
    radius = mark_radius(places, picture.scale)
    numbered = radius >= 0.82 * NUMBER_RADIUS
    for dancer in book.dancers.tolist():
        there = record.present[rows, dancer]
        if not there.any():
            continue
        way = simplified(ways[~np.isnan(ways[:, dancer, 0]), dancer], max(WAY_TOLERANCE, 1.5 / picture.scale))
        if float(np.hypot(*(way - way[-1]).T).max()) > MOVED_M:
            page.disc(picture.at(*way[0].tolist()), 1.3, FAINT, None)
            picture.way(way, short=radius * 1.2 if there[-1] else 0.0)
    marks = [book.marks[group] for group in record.group[cell.scene.end - 1, who].tolist()]
    for dancer, place, mark in zip(who.tolist(), places.tolist(), marks, strict=True):
        picture.mark(mark, (place[0], place[1]), radius, heading=float(record.heading[rows.stop - 1, dancer]))
    missing = 0
    for dancer, place, mark in zip(who.tolist(), places.tolist(), marks, strict=True):
        if numbered:
            picture.number_in(mark, (place[0], place[1]), str(dancer + 1))
        elif not picture.label((place[0], place[1]), str(dancer + 1), radius * 1.3 + 1.0):
            missing += 1
    if missing:
        words = f"{missing} of {len(who)} numbers have no room here: see the dancers' pages"
        page.words((x + width, y + head + picture.height + TEXT - 2.0), words, SMALL, ink=FAINT, anchor="r")
