"""Pages of sheets: what they say, and that it can be read: inside the margins, not too small, nothing on another."""

import math
from itertools import combinations, pairwise

import numpy as np
import pytest

from live.document.sheets.dancer_pages import dancer_pages, dancer_rows
from live.document.sheets.group_marks import marks_of, tint
from live.document.sheets.page import MARGIN, PAPERS, SMALL, Page, Words, known_letters, text_width, wrapped
from live.document.sheets.sheet_book import SheetBook
from live.document.sheets.stage_words import direction_words, facing_words, place_numbers, place_words, side_words
from live.document.sheets.storyboard_pages import storyboard_pages
from tests.fixtures.mostly_long import mostly_long

pytestmark = pytest.mark.xdist_group("sheets")


def words_of(page: Page) -> list[Words]:
    return [item for item in page.items if isinstance(item, Words)]


def box(item: Words) -> tuple[float, float, float, float]:
    width = text_width(item.words, item.size, item.bold)
    left = item.at[0] - {"l": 0.0, "m": 0.5, "r": 1.0}[item.anchor] * width
    return left, item.at[1] - 0.7 * item.size, left + width, item.at[1]


@mostly_long("paper", PAPERS, quick=[1])
def test_words_can_be_read(book: SheetBook, paper: str) -> None:
    sheets = [storyboard_pages(book, paper), *(dancer_pages(book, dancer, paper) for dancer in book.dancers.tolist())]
    for page in (page for sheet in sheets for page in sheet):
        found = words_of(page)
        assert min(item.size for item in found) >= SMALL
        for item in found:
            left, top, right, bottom = box(item)
            assert left >= MARGIN - 1.0, item
            assert right <= page.width - MARGIN + 1.0, item
            assert top >= MARGIN - 1.0, item
            assert bottom <= page.height - MARGIN + 1.0, item
        for one, other in combinations(found, 2):
            a, b = box(one), box(other)
            apart = a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
            assert apart, f"{one.words!r} is on {other.words!r}"


def test_storyboard_tells_scenes_waits_and_front(book: SheetBook) -> None:
    said = [item.words for page in storyboard_pages(book, "a4") for item in words_of(page)]
    assert "1 · cross, measures 1–3 · there, back" in said
    assert "ember: to there, there at 4:1" in said
    assert any("'wait' repeats and waits for GO" in words for words in said)
    assert "After the last measure the score is over." in said
    assert said.count("audience") == len(book.scenes)
    assert "ember: 1–3, 6" in said
    assert "Zwei Reihen, ça va" in said


def test_part_tells_who_passes_on_which_side(book: SheetBook) -> None:
    record, pairs = book.record, 0
    for dancer in (0, 1, 2):
        for part in book.part(dancer):
            for one in part.passings:
                pairs += one.other in (3, 4)
                row = int(np.abs(record.danced - one.beat).argmin())
                apart = record.place[row, one.other] - record.place[row, dancer]
                assert math.hypot(*apart) == pytest.approx(one.distance, abs=0.35)
                if one.other in (3, 4):
                    assert apart[1] < 0.0  # tide goes behind ember, who faces the audience
                    assert one.side in ("behind you", "on your left", "on your right")
    assert pairs >= 4
    for dancer in (3, 4):
        assert all(one.other not in (3, 4) for part in book.part(dancer) for one in part.passings)  # not her partner


def test_part_tells_entrance_partner_and_wait(book: SheetBook) -> None:
    entering = [dict(row.lines) for row in dancer_rows(book, 5)]
    assert entering[0]["Enter"] == "2:1, gate 'door' (stage left)"
    assert "Partner" not in entering[0]
    assert entering[0]["Steps"] == "1–3 walk"
    beside = [dict(row.lines) for row in dancer_rows(book, 3)]
    assert {row["Partner"] for row in beside} == {"5 (tide), beside"}
    assert ["Wait" in row for row in beside] == [False, False, True, False]
    free = [dict(row.lines) for row in dancer_rows(book, 0)]
    assert "free" in free[-1]["Note"]


def test_scenes_are_the_whole_show(book: SheetBook) -> None:
    assert book.scenes[0].first == 0
    assert book.scenes[-1].end == book.record.measures
    assert all(before.end == after.first for before, after in pairwise(book.scenes))


def test_words_of_the_stage_are_the_dancers() -> None:
    assert place_words(2.5, 1.0) == "2.5 m left of centre, 1.0 m down stage"
    assert place_words(-0.01, -3.0) == "on the centre line, 3.0 m up stage"
    assert place_numbers(-2.46, 0.01) == "x −2.5, z 0.0"
    assert direction_words(1.0, 0.0) == "stage left"
    assert direction_words(-1.0, -1.0) == "up stage right"
    assert facing_words(0.0) == "the audience"
    assert facing_words(-math.pi / 2) == "stage right"
    assert side_words(0.0, 1.0, 0.0) == "on your left"
    assert side_words(math.pi, 1.0, 0.0) == "on your right"
    assert side_words(math.pi / 2, 1.0, 0.0) == "in front of you"


def test_groups_differ_without_colour() -> None:
    red = [(0.9, 0.1, 0.1)] * 16
    seen = {(mark.shape, round(sum(np.multiply(mark.fill, (0.299, 0.587, 0.114))), 2)) for mark in marks_of(red)}
    assert len(seen) == 16
    for colour in ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (0.2, 0.4, 0.9)):
        assert np.dot(tint(colour, 0.5), (0.299, 0.587, 0.114)) == pytest.approx(0.5, abs=1e-6)


def test_letters_without_glyph_are_replaced() -> None:
    assert known_letters("Ω – ű 舞\n") == "Ω – u ??"
    assert all(text_width(line, 8.0) <= 60.0 for line in wrapped("a very-long-word-without-any-space in it", 60.0, 8.0))
