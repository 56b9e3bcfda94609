"""Sheets as answers to questions of pages: values that a browser draws, a PDF, and a run that is interrupted."""

import json

import pytest

from live.document.preview_answers import open_answers
from live.document.sheets.drawn_pages import page_values
from live.document.sheets.page import Words
from live.document.sheets.sheet_answers import SheetRun
from live.document.sheets.sheet_book import SheetBook
from live.document.sheets.storyboard_pages import storyboard_pages
from live.show.loader import LoadedShow
from live.show.view.stage_frames import DOCUMENT

pytestmark = pytest.mark.xdist_group("sheets")


@pytest.mark.long
def test_pages_are_those_of_the_sheets(loaded: LoadedShow, book: SheetBook) -> None:
    answers = open_answers(loaded)
    told = json.loads(next(iter(answers.answer({"id": 1, "sheets": "a4"}))))
    pages = storyboard_pages(book, "a4")
    assert told["pages"] == json.loads(json.dumps([page_values(page) for page in pages]))
    assert [area[0] for page in told["pages"] for area in page["areas"]] == list(range(1, len(book.scenes) + 1))
    assert (told["scenes"][0]["section"], told["scenes"][0]["measure"]) == ("cross", 1)
    assert sum(scene["measures"] for scene in told["scenes"]) == book.record.measures
    words = [item.words for page in pages for item in page.items if isinstance(item, Words)]
    assert [item[5] for page in told["pages"] for item in page["items"] if item[0] == "words"] == words
    hers = json.loads(next(iter(answers.answer({"sheets": "letter", "dancer": 2}))))
    assert (hers["dancer"], hers["pages"][0]["width"]) == (2, 612.0)
    frame = next(iter(answers.answer({"sheets": "a4", "pdf": True})))
    assert isinstance(frame, bytes)
    assert (frame[0], int.from_bytes(frame[4:8], "little"), frame[8:13]) == (DOCUMENT, len(frame) - 8, b"%PDF-")
    refused = json.loads(next(iter(answers.answer({"sheets": "a4", "dancer": 99}))))
    assert refused["refused"][0]["what"] == "dancer 99 is never on the stage"


class _Enough(Exception):
    pass


def test_an_interrupted_run_goes_on(loaded: LoadedShow, book: SheetBook) -> None:
    run, ticks = SheetRun(loaded, seed=None), 0

    def stop() -> None:
        nonlocal ticks
        ticks += 1
        if ticks == 300:
            raise _Enough

    with pytest.raises(_Enough):
        run.book(stop)
    assert 0 < run.measures < book.record.measures
    again = run.book(stop)
    assert (again.record.place == book.record.place).all()
    assert run.book(stop) is again
