"""A book of sheets: everything that the pages of a show say, and the parts that all pages share."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.agents.entrances.gate import Gate
from live.base.arrays import Float64, Int32
from live.document.sheets.dancer_part import PartScene, part_scene
from live.document.sheets.group_marks import GroupMark, draw_mark, marks_of
from live.document.sheets.page import FAINT, LEADING, MARGIN, SMALL, TEXT, Page, shortened, text_width, wrapped
from live.document.sheets.scenes import Scene, calm_ways, scenes_of
from live.document.sheets.show_record import ShowRecord
from live.document.sheets.stage_picture import StagePlan
from live.document.sheets.stage_words import direction_words
from live.show.group.stage_area import gates_of
from live.show.patch.patch import Patch

SIDES_NOTE: Final = (
    "Left, right, up and down stage are those of a dancer who faces the audience, who are below in all pictures. "
    "x is metres to the left of centre (right: −), z metres down stage (up: −)."
)
HEAD: Final = 46.0
"""Height of a page's head [pt]."""
FOOT: Final = 26.0
"""Height of a page's foot [pt]."""
SMALLER: Final = (1.0, 0.97, 0.94, 0.91, 0.88, 0.85, 0.82, 0.79)
"""Factors by which pictures may become smaller so that fewer pages are needed."""


@dataclass(frozen=True, slots=True, eq=False)
class SheetBook:
    """The sheets of a show before layout."""

    title: str
    record: ShowRecord
    scenes: tuple[Scene, ...]
    ways: tuple[Float64, ...]
    """The calm ways of each scene, (T, A, 2) [m]."""
    sway: float
    """Distance of the hips from these ways [m]; 99 of 100 samples are nearer."""
    dancers: Int32
    """Indices of those who are ever on the stage, ascending."""
    groups: tuple[str, ...]
    partner_words: tuple[str, ...]
    """Of each group, how its pairs dance; empty for none."""
    marks: tuple[GroupMark, ...]
    plan: StagePlan
    gates: tuple[Gate, ...]

    def part(self, dancer: int) -> list[PartScene]:
        """Return the part of a dancer (index)."""
        scenes = zip(self.scenes, self.ways, strict=True)
        return [part_scene(self.record, dancer, scene, ways) for scene, ways in scenes]

    @property
    def notes(self) -> list[str]:
        """What the pages say about themselves."""
        sway = math.ceil(100.0 * self.sway)
        run = (
            "Places at the beginning and end of a scene are where the hips are in a run of the show with its seed "
            f"and without input. Ways and dots leave out the sway of the steps: less than {sway} cm, 99 of 100 times."
        )
        return [SIDES_NOTE, run, self.record.course.ending]

    def name(self, dancer: int) -> str:
        """Return a dancer's number and group, `7 (sun)`."""
        return f"{dancer + 1} ({self.groups[int(self.record.group[0, dancer])]})"

    def gate(self, place: tuple[float, float]) -> str:
        """Return the name of the gate next to a place [m], and its side of the stage."""
        near = min(self.gates, key=lambda one: math.hypot(one.x - place[0], one.z - place[1]))
        return f"gate {near.name!r} ({direction_words(near.out_x, near.out_z)})"

    @property
    def facts(self) -> str:
        """Dancers, measures and tempo in a line."""
        record = self.record
        people = f"{len(self.dancers)} dancer{'s' if len(self.dancers) != 1 else ''}"
        counts = f"{record.measures} measures of {record.beats} counts"
        return f"{people} · {counts} · {round(record.tempo, 1):g} bpm"


def book_of(patch: Patch, record: ShowRecord, colours: Sequence[tuple[float, float, float]]) -> SheetBook:
    """Return the book of a show. `colours`: of its groups, sRGB."""
    seen, scenes = record.present, scenes_of(record)
    ways = [calm_ways(record, scene) for scene in scenes]
    gates = gates_of(patch, patch.stage.width / 2.0, patch.stage.depth / 2.0)
    return SheetBook(
        patch.name,
        record,
        tuple(scenes),
        tuple(ways),
        _sway(record, scenes, ways),
        np.flatnonzero(seen.any(axis=0)).astype(np.int32),
        tuple(group.name for group in patch.group),
        tuple(group.partners or "" for group in patch.group),
        tuple(marks_of(colours)),
        StagePlan.of(patch, _scene_places(record)),
        gates,
    )


def _sway(record: ShowRecord, scenes: list[Scene], ways: list[Float64]) -> float:
    """Return the distance that 99 of 100 places of the hips are nearer to the calm ways [m]; 0 for an empty stage."""
    apart = [
        np.hypot(*np.moveaxis(record.place[record.rows(scene.first, scene.end)] - way, 2, 0))
        for scene, way in zip(scenes, ways, strict=True)
    ]
    all_of_them = np.concatenate([one[np.isfinite(one)] for one in apart]) if apart else np.zeros(0)
    return float(np.percentile(all_of_them, 99.0)) if len(all_of_them) else 0.0


def _scene_places(record: ShowRecord) -> Float64:
    """Return all places of dancers on the stage at the lines, (P, 2) [m]."""
    place = record.place[record.lines].astype(np.float64)
    return np.asarray(place[record.present[record.lines]])


def new_page(paper: str, book: SheetBook, heading: str, facts: str) -> Page:
    """Return a page with its head: the show's name and what the page is."""
    page = Page.of(paper)
    right = text_width(heading, 13.0, True)
    page.words(
        (MARGIN, MARGIN + 12.0), shortened(book.title, page.inner_width - right - 20.0, 13.0, True), 13.0, bold=True
    )
    page.words((page.width - MARGIN, MARGIN + 12.0), heading, 13.0, bold=True, anchor="r")
    page.words((MARGIN, MARGIN + 25.0), shortened(facts, page.inner_width, TEXT), TEXT, ink=FAINT)
    page.stroke([(MARGIN, MARGIN + 31.0), (page.width - MARGIN, MARGIN + 31.0)], 0.8)
    return page


def add_feet(pages: Sequence[Page], words: str) -> None:
    """Write the foot of each page: what it is, and its number."""
    for number, page in enumerate(pages, 1):
        y = page.height - MARGIN
        page.words((page.width - MARGIN, y), f"page {number} of {len(pages)}", SMALL, ink=FAINT, anchor="r")
        page.words((MARGIN, y), shortened(words, page.inner_width - 80.0, SMALL), SMALL, ink=FAINT)


def fit_pages(heights: Callable[[float], list[float]], first: float, later: float) -> float:
    """Return by how much pictures become smaller so that rows need the fewest pages: the least reduction of these.

    `heights` returns the rows' heights for a factor; `first` and `later` are the heights of the first page and others.
    """
    return min(SMALLER, key=lambda factor: (_page_count(heights(factor), first, later), -factor))


def _page_count(rows: list[float], first: float, later: float) -> int:
    pages, room = 1, first
    for row in rows:
        if row > room:
            pages, room = pages + 1, later
        room -= row
    return pages


def add_notes(page: Page, y: float, notes: Sequence[str]) -> float:
    """Write notes across the page from `y` on; return where they end."""
    for note in notes:
        for line in wrapped(note, page.inner_width, SMALL):
            page.words((MARGIN, y + SMALL), line, SMALL, ink=FAINT)
            y += SMALL * LEADING
    return y


def add_legend(page: Page, book: SheetBook, y: float) -> float:
    """Draw the groups' marks with their names and numbers from `y` on; return where they end."""
    x, group = MARGIN, book.record.group[0]
    for index, name in enumerate(book.groups):
        members = book.dancers[group[book.dancers] == index] + 1
        if not len(members):
            continue
        words = f"{name}: {_ranges(members)}"
        width = text_width(words, TEXT) + 30.0
        if x > MARGIN and x + width > page.width - MARGIN:
            x, y = MARGIN, y + 15.0
        draw_mark(page, book.marks[index], (x + 6.0, y + 6.0), 5.0)
        page.words((x + 15.0, y + 9.0), shortened(words, page.inner_width - 20.0, TEXT), TEXT)
        x += width
    return y + 17.0


def _ranges(numbers: Int32) -> str:
    """Return ascending numbers as `1-8, 12`."""
    parts: list[list[int]] = []
    for number in numbers.tolist():
        if parts and parts[-1][1] == number - 1:
            parts[-1][1] = number
        else:
            parts.append([number, number])
    return ", ".join(str(low) if low == high else f"{low}–{high}" for low, high in parts)
