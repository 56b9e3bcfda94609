"""A small show for tests of sheets: two groups that pass, an entrance, a wait, an element, a pair."""

from functools import cache
from pathlib import Path

import numpy as np

from live.document.sheets.score_course import course_of
from live.document.sheets.sheet_book import SheetBook, book_of
from live.document.sheets.show_record import record_show
from live.show.loader import LoadedShow, load_show, make_scene

TEXT = """name = "Zwei Reihen, ça va"
reserve = 1
[clock]
bpm = 120
[[gate]]
name = "door"
at = [5.0, 0.0]
[stage]
width = 10.0
depth = 7.0
[[group]]
name = "ember"
dancers = 3
steps = ["walk"]
centre = [-2.5, 0.3]
size = [2.0, 2.0]
formation = "line"
[[group]]
name = "tide"
dancers = 2
partners = "beside"
steps = ["side step"]
centre = [2.5, -0.6]
size = [2.0, 1.0]
[[section]]
name = "cross"
measures = 4
[[section]]
name = "wait"
measures = 2
wait = true
then = "last"
[[section]]
name = "last"
measures = 2
then = "end"
[[formation]]
name = "there"
shape = "line"
centre = [2.8, 0.3]
size = [2.0, 1.0]
[[formation]]
name = "back"
shape = "line"
centre = [-2.6, -0.6]
size = [2.0, 1.0]
[[segment]]
section = "cross"
measure = 1
measures = 3
group = "ember"
formation = "there"
[[segment]]
section = "cross"
measure = 1
measures = 3
group = "tide"
formation = "back"
[[at]]
section = "cross"
measure = 1
beat = 2.0
call = "/dance/enter"
values = [1]
[[element]]
kind = "attract"
section = "last"
measure = 1
measures = 2
group = "ember"
at = [0.0, 0.0]
"""


@cache
def loaded_small(folder: Path) -> LoadedShow:
    path = folder / "show.toml"
    path.write_text(TEXT)
    return load_show(path)


@cache
def small_book(folder: Path) -> SheetBook:
    return make_book(loaded_small(folder))


def make_book(loaded: LoadedShow, measures: int | None = None) -> SheetBook:
    record = record_show(loaded.start(), course_of(loaded.patch, measures))
    assert np.isfinite(record.place).all()
    return book_of(loaded.patch, record, make_scene(loaded.patch).group_colours)
