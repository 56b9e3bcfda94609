"""The course of a score for sheets: repeats, waits, jumps and ends."""

from pathlib import Path

import pytest

from live.document.sheets.score_course import FREE_MEASURES, course_of
from live.show.loader import load_show
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import find_patch

GROUP = 'name = "x"\n[[group]]\nname = "a"\ndancers = 1\nsteps = ["groove"]\n'


def patch_of(tmp_path: Path, text: str) -> Patch:
    (tmp_path / "show.toml").write_text(GROUP + text)
    return load_show(tmp_path / "show.toml").patch


@pytest.mark.long
def test_sections_repeat_and_wait_once() -> None:
    course = course_of(load_show(find_patch("score")).patch)
    names = [(one.section, one.number, one.time) for one in course.measures]
    assert names[:5] == [*[("intro", number, 1) for number in (1, 2, 3, 4)], ("verse", 1, 1)]
    assert names[12] == ("verse", 1, 2)
    assert [one.section for one in course.measures if one.waits] == ["solo"]
    assert len(names) == 4 + 2 * 8 + 16 + 4
    assert course.ending == "After the last measure the score is over."
    assert course.label(12) == "verse 1"


def test_course_ends_where_a_section_comes_again(tmp_path: Path) -> None:
    text = '[[section]]\nname = "one"\nmeasures = 2\n[[section]]\nname = "two"\nmeasures = 3\nthen = "one"\n'
    course = course_of(patch_of(tmp_path, text))
    assert len(course.measures) == 5
    assert "goes on with 'one'" in course.ending


@pytest.mark.long
def test_score_without_sections_lasts_as_long_as_it_says(tmp_path: Path) -> None:
    assert len(course_of(patch_of(tmp_path, "")).measures) == FREE_MEASURES
    assert "no end" in course_of(patch_of(tmp_path, "")).ending
    text = '[[segment]]\nmeasure = 40\nmeasures = 4\nformation = "line"\n'
    assert len(course_of(patch_of(tmp_path, text)).measures) == 43
    assert len(course_of(patch_of(tmp_path, text), 10).measures) == 10
