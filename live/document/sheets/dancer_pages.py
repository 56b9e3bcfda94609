"""Pages of one dancer: for each scene where she stands, her way, counts, steps, and whom she passes."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.document.sheets.dancer_part import PartScene
from live.document.sheets.group_marks import draw_mark
from live.document.sheets.page import (
    BLACK,
    FAINT,
    LEADING,
    MARGIN,
    SMALL,
    TEXT,
    WHITE,
    Ink,
    Page,
    SceneArea,
    grey,
    shortened,
    wrapped,
)
from live.document.sheets.scenes import arrival_label, count_label, measures_words, scene_title
from live.document.sheets.sheet_book import FOOT, HEAD, SheetBook, add_feet, add_notes, fit_pages, new_page
from live.document.sheets.stage_picture import StagePicture, mark_radius
from live.document.sheets.stage_words import direction_words, facing_words, place_numbers, place_words

PICTURE_SHARE: Final = 0.38
"""Width of a picture, as a share of the page's."""
TALLEST: Final = 150.0
"""Greatest height of a picture [pt]."""
GAP: Final = 14.0
TITLE: Final = 10.0
OTHERS: Final = grey(0.45)
YOU_RADIUS: Final = 7.4
"""Radius of her own mark [pt]."""
NEIGHBOUR_M: Final = 3.0
"""Others farther away than this have no number [m]."""
FLAT: Final = 0.2
"""A way that is longer than the straight line by more than this share is told, too."""


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a page: the words beside a scene's picture."""

    part: PartScene
    title: str
    lines: tuple[tuple[str, str], ...]
    """What a line is about, and its words."""


def dancer_pages(book: SheetBook, dancer: int, paper: str) -> list[Page]:
    """Return the pages of a dancer (index)."""
    group = book.groups[int(book.record.group[0, dancer])]
    heading = f"Dancer {dancer + 1} · {group}"
    page = new_page(paper, book, heading, book.facts)
    draw_mark(page, book.marks[int(book.record.group[0, dancer])], (MARGIN + 8.0, MARGIN + HEAD), YOU_RADIUS, width=1.8)
    words = (
        "you: the mark with a thick edge. A dot with a number is where you are on a count; others are where they end."
    )
    page.words((MARGIN + 20.0, MARGIN + HEAD + 3.0), words, SMALL, ink=FAINT)
    y, top = add_notes(page, MARGIN + HEAD + 9.0, book.notes) + 8.0, MARGIN + HEAD - 4.0
    pages, bottom = [page], page.height - MARGIN - FOOT
    rows = dancer_rows(book, dancer)
    widest = min(page.inner_width * PICTURE_SHARE, TALLEST * book.plan.size[0] / book.plan.size[1])

    def heights(factor: float) -> list[float]:
        beside = page.inner_width - widest * factor - GAP
        picture = book.plan.height_for(widest * factor)
        return [max(TITLE * LEADING + 2.0 + len(_wrapped(row, beside)) * TEXT * LEADING, picture) + GAP for row in rows]

    factor = fit_pages(heights, bottom + GAP - y, bottom + GAP - top)
    width = widest * factor
    for number, (row, height) in enumerate(zip(rows, heights(factor), strict=True), 1):
        if y + height - GAP > bottom and y > MARGIN + HEAD:
            page = new_page(paper, book, heading, book.facts)
            pages.append(page)
            y = top
        page.areas.append(SceneArea(number, (MARGIN, y), page.inner_width, height - GAP))
        _draw_part(page, book, dancer, row.part, (MARGIN, y), width)
        lines = _wrapped(row, page.inner_width - width - GAP)
        _draw_words(page, row.title, lines, (MARGIN + width + GAP, y))
        y += height
        page.stroke([(MARGIN, y - GAP / 2.0), (page.width - MARGIN, y - GAP / 2.0)], 0.4, grey(0.8))
    add_feet(pages, f"{book.title} · dancer {dancer + 1} ({group})")
    return pages


def dancer_rows(book: SheetBook, dancer: int) -> list[Row]:
    """Return what a dancer's pages say, scene by scene."""
    return [
        Row(part, f"{number} · {measures_words(book.record, part.scene)} · {_title(part)}", tuple(_lines(book, part)))
        for number, part in enumerate(book.part(dancer), 1)
    ]


def _title(part: PartScene) -> str:
    if not any(part.there) and part.entrance is None:
        return "off the stage"
    names = list(dict.fromkeys(led.words for led in part.led if led.measure >= part.scene.first))
    if names:
        return ", ".join(names)
    if part.led:
        return f"{part.led[0].words}, going on"
    if part.free:
        return "free: " + ", ".join(part.free)
    return "steps on the spot" if part.stays else scene_title(part.scene) if part.scene.led else "steps"


def _lines(book: SheetBook, part: PartScene) -> list[tuple[str, str]]:
    record = book.record
    if not any(part.there) and part.entrance is None:
        return [
            ("Where", f"off the stage, from {count_label(record, part.scene.beats(record)[0])} on"),
            *_notes(book, part),
        ]
    lines = []
    if part.entrance is not None:
        lines.append(("Enter", f"{count_label(record, part.entrance)}, {book.gate(part.start)}"))
    lines.append(
        ("Start", f"{place_words(*part.start)} ({place_numbers(*part.start)}), facing {facing_words(part.heading[0])}")
    )
    lines += _way_lines(book, part)
    if part.exit is not None:
        lines.append(("Exit", f"{count_label(record, part.exit)}, {book.gate(part.end)}"))
    lines.append(("Steps", _steps_words(book, part)))
    if part.partner >= 0:
        how = book.partner_words[part.group]
        lines.append(("Partner", f"{book.name(part.partner)}{', ' + how if how else ''}"))
    passed = [
        f"{book.name(one.other)} {one.side} at {count_label(record, one.beat)}, {one.distance:.1f} m"
        for one in part.passings
    ]
    if part.more_passings:
        passed.append(f"and {part.more_passings} more, farther away")
    if passed:
        lines.append(("Pass", "; ".join(passed)))
    return [*lines, *_notes(book, part)]


def _steps_words(book: SheetBook, part: PartScene) -> str:
    """Return what she dances by measures: `1–2 groove, 3 turn`."""
    words, measure = [], part.scene.first
    for name, times in part.steps:
        first, last = (book.record.course.measures[one].number for one in (measure, measure + times - 1))
        words.append(f"{first}–{last} {name}" if times > 1 else f"{first} {name}")
        measure += times
    return ", ".join(words)


def _way_lines(book: SheetBook, part: PartScene) -> list[tuple[str, str]]:
    record = book.record
    if part.stays:
        return [("Go", "stay there")]
    dx, dz = part.end[0] - part.start[0], part.end[1] - part.start[1]
    straight = float(np.hypot(dx, dz))
    where = f"{straight:.1f} m {direction_words(dx, dz)}" if straight >= 0.3 else "away and back to the same place"
    longer = f" (way {part.length:.1f} m)" if part.length > (1.0 + FLAT) * straight + 0.2 else ""
    when = f"off at {count_label(record, part.off)}, there at {count_label(record, part.arrived)}"
    planned = [led.end for led in part.led if led.end <= part.scene.end * record.beats + 1e-6]
    when += f" (by the score at {arrival_label(record, max(planned))})" if planned else ""
    arrive = f"{place_words(*part.end)} ({place_numbers(*part.end)}), facing {facing_words(part.heading[1])}"
    return [("Go", f"{where}{longer}, {when}"), ("End", arrive)]


def _notes(book: SheetBook, part: PartScene) -> list[tuple[str, str]]:
    record = book.record
    notes = []
    for led in part.led:
        if led.end > part.scene.end * record.beats + 1e-6:
            notes.append(("Note", f"{led.words} goes on until {arrival_label(record, led.end)}"))
    if not part.led and part.free:
        notes.append(("Note", "free: no planned way; this is the run with the show's seed"))
    one = record.course.measures[part.scene.end - 1]
    if one.waits:
        notes.append(("Wait", f"{one.section!r} repeats and waits for GO or a cue: then counts start again"))
    return notes


def _wrapped(row: Row, width: float) -> list[tuple[str, str]]:
    found = []
    for about, words in row.lines:
        for index, line in enumerate(wrapped(words, width - 40.0, TEXT)):
            found.append((about if index == 0 else "", line))
    return found


def _draw_words(page: Page, title: str, lines: list[tuple[str, str]], corner: tuple[float, float]) -> None:
    x, y = corner
    page.words((x, y + TITLE), shortened(title, page.width - MARGIN - x, TITLE, True), TITLE, bold=True)
    y += TITLE * LEADING + 2.0
    for about, line in lines:
        page.words((x, y + TEXT), about, SMALL, ink=FAINT)
        page.words((x + 40.0, y + TEXT), line, TEXT)
        y += TEXT * LEADING


def _draw_part(
    page: Page, book: SheetBook, dancer: int, part: PartScene, corner: tuple[float, float], width: float
) -> None:
    picture = StagePicture(page, book.plan, corner, width)
    picture.floor()
    record = book.record
    row = int(record.lines[part.scene.end])
    others = [other for other in book.dancers[record.present[row, book.dancers]].tolist() if other != dancer]
    places = record.place[row].astype(np.float64)
    radius = min(mark_radius(places[others], picture.scale, 4.0), 4.0)
    for other in others:
        x, z = places[other].tolist()
        picture.mark(book.marks[int(record.group[part.scene.end - 1, other])], (x, z), radius, ink=OTHERS, width=0.4)
    if any(part.there) or part.entrance is not None:
        _draw_way(page, book, dancer, part, picture)
    near = _by_distance(places, part, others)
    passed = {one.other for one in part.passings}
    for other, distance in near:
        if distance < NEIGHBOUR_M or other in passed:
            x, z = places[other].tolist()
            picture.label((x, z), str(other + 1), radius + 1.6, ink=OTHERS)


def _by_distance(places: Float64, part: PartScene, others: list[int]) -> list[tuple[int, float]]:
    """Return the others with their distances from her last place [m], nearest first."""
    apart = [(other, float(np.hypot(*(places[other] - part.end)))) for other in others]
    return sorted(apart, key=lambda one: (one[1], one[0]))


def _draw_way(page: Page, book: SheetBook, dancer: int, part: PartScene, picture: StagePicture) -> None:
    mark = book.marks[part.group]
    beats, first = book.record.beats, part.scene.first
    if not part.stays:
        page.disc(picture.at(*part.start), 2.6, WHITE, BLACK, 1.0)
        picture.way(part.way, ink=BLACK, width=1.3, short=YOU_RADIUS * 1.25 if part.there[1] else 0.0)
        picture.keep_free(part.way, part.start)
    if part.there[1]:
        picture.mark(mark, part.end, YOU_RADIUS, heading=part.heading[1], width=1.8)
        picture.number_in(mark, part.end, str(dancer + 1))
    if part.stays:
        return
    last: tuple[float, float] = part.start
    for beat, place in enumerate(part.beat_places.tolist()[:-1]):
        at = picture.at(place[0], place[1])
        if beat == 0 or not np.isfinite(at).all() or _apart(at, picture.at(*part.end)) < YOU_RADIUS + 2.0:
            continue
        if _apart(at, picture.at(*last)) < 2.5:
            continue
        last = (place[0], place[1])
        one = beat % beats == 0
        ink: Ink = BLACK
        page.disc(at, 1.9 if one else 1.2, ink, WHITE, 0.4)
        if one or beats * (part.scene.end - first) <= 8:
            picture.label(last, count_label(book.record, float(first * beats + beat)), 3.4, bold=one)


def _apart(a: tuple[float, float], b: tuple[float, float]) -> float:
    return float(np.hypot(a[0] - b[0], a[1] - b[1]))
