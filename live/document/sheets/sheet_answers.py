"""Answers about sheets: their pages as values that a browser draws, and all of them as one PDF.

The run of a show that the sheets need is kept, also a run that was interrupted, until the show changes.
"""

from collections.abc import Callable, Iterator
from typing import Any

from live.base.errors import PersonError
from live.document.sheets.dancer_pages import dancer_pages
from live.document.sheets.drawn_pages import page_values, pdf_of
from live.document.sheets.page import Page
from live.document.sheets.scenes import measures_words, scene_title
from live.document.sheets.score_course import course_of
from live.document.sheets.sheet_book import SheetBook, book_of
from live.document.sheets.show_record import ShowRecorder
from live.document.sheets.storyboard_pages import storyboard_pages
from live.show.loader import LoadedShow, make_scene
from live.show.patch.patch import Patch


class SheetRun:
    """The run of one patch for its sheets. An exception of `on_tick` interrupts it; the next call goes on."""

    def __init__(self, loaded: LoadedShow, *, seed: int | None) -> None:
        """PersonError if the show does not start."""
        self.patch: Patch = loaded.patch
        self._recorder = ShowRecorder(loaded.start(seed=seed), course_of(loaded.patch))
        self._ticks: Iterator[int] = self._recorder.run()
        self._book: SheetBook | None = None

    @property
    def measures(self) -> int:
        """Number of measures that are simulated."""
        return self._recorder.measures

    def book(self, on_tick: Callable[[], None]) -> SheetBook:
        """Return the book of sheets; `on_tick` is called after each simulated tick."""
        if self._book is None:
            for _ in self._ticks:
                on_tick()
            self._book = book_of(self.patch, self._recorder.record(), make_scene(self.patch).group_colours)
        return self._book


def sheet_values(book: SheetBook, paper: str, dancer: int | None) -> dict[str, Any]:
    """Return the pages of the storyboard, or of a dancer (from 1), with the scenes that they show. PersonError for a
    dancer who is never on the stage."""
    record = book.record
    pages = storyboard_pages(book, paper) if dancer is None else dancer_pages(book, _index(book, dancer), paper)
    scenes = []
    for scene in book.scenes:
        first = record.course.measures[scene.first]
        place = {"section": first.section, "measure": first.number, "measures": scene.end - scene.first}
        scenes.append({"words": f"{measures_words(record, scene)} · {scene_title(scene)}", **place})
    return {
        "kind": "sheets", "paper": paper, "dancer": dancer, "dancers": (book.dancers + 1).tolist(), "scenes": scenes,
        "pages": [page_values(page) for page in pages],
    }  # fmt: skip


def _index(book: SheetBook, dancer: int) -> int:
    if dancer - 1 not in book.dancers:
        raise PersonError(f"dancer {dancer} is never on the stage", "a number of `dancers` of the storyboard's answer")
    return dancer - 1


def sheets_pdf(book: SheetBook, paper: str, on_document: Callable[[], None]) -> bytes:
    """Return the storyboard and the sheets of all dancers as one PDF; `on_document` is called before each of them."""
    pages: list[Page] = storyboard_pages(book, paper)
    for dancer in book.dancers.tolist():
        on_document()
        pages += dancer_pages(book, dancer, paper)
    on_document()
    return pdf_of(pages, f"{book.title} · sheets")
