"""What of a score does not fit its music is named at its place."""

import pytest

from live.rehearse.music_lint import MAX_WARNINGS, music_notes, music_warnings
from live.show.patch.patch_reader import parse_patch

GROUP = 'name = "x"\n[[group]]\nname = "all"\ndancers = 3\nsteps = ["groove"]\n'


def lines(beats: list[int], phrases: str = "") -> str:
    rows = [f"[[music.line]]\ntime_s = {2.0 * k}\nmeasure = {k + 1}\nbeats = {n}\n" for k, n in enumerate(beats)]
    return "".join(rows) + phrases


def notes(text: str) -> list[tuple[str, tuple[str | int, ...], int | None]]:
    return [(one.what, one.key_path, one.measure) for one in music_notes(parse_patch(GROUP + text, "test.toml"))]


def segment(measure: float, section: str = "") -> str:
    where = f'section = "{section}"\n' if section else ""
    return f'[[segment]]\nformation = "line"\nmeasure = {measure}\n{where}'


def test_music_that_fits_has_no_notes() -> None:
    assert notes(segment(9)) == []  # measures are unknown
    assert notes(lines([4] * 8) + segment(8)) == []
    sections = '[[section]]\nname = "a"\nmeasures = 2\nrepeat = 3\n[[section]]\nname = "b"\nmeasures = 2\n'
    assert notes(lines([4] * 8) + sections + segment(2, "b")) == []


def test_entries_and_sections_after_the_end_are_named() -> None:
    sections = '[[section]]\nname = "a"\nmeasures = 2\nrepeat = 2\n[[section]]\nname = "b"\nmeasures = 4\n'
    score = sections + segment(1, "b") + segment(3, "b") + segment(6)  # measure 6 as written: the fourth of b
    assert notes(lines([4] * 6) + score) == [
        ("section 'b' lasts from measure 5 to 8 of the music, which has 6", ("section", 1), 7),
        ("segment 2 of section 'b' begins in measure 7, after the music's last measure 6", ("segment", 1), 7),
        ("segment 3 begins in measure 8, after the music's last measure 6", ("segment", 2), 8),
    ]
    assert notes(lines([4] * 10) + sections) == [
        ("the score ends with measure 8, and the music has 10", ("section", 1), 9)
    ]


def test_nothing_is_said_of_what_follows_a_section_that_waits() -> None:
    sections = '[[section]]\nname = "a"\nmeasures = 2\nrepeat = 0\n[[section]]\nname = "b"\nmeasures = 40\n'
    assert notes(lines([4] * 6) + sections + segment(30, "b")) == []


def test_other_metres_are_named_unless_the_show_follows_them() -> None:
    metre = lines([4, 4, 3, 3, 4, 5])
    assert notes(metre) == [
        ("measures 3 to 4 have 3 beats, and the show dances measures of 4", ("music", "line", 2), 3),
        ("measure 6 has 5 beats, and the show dances measures of 4", ("music", "line", 5), 6),
    ]
    follows = "[clock]\nfollow_metre = true\n" + metre
    at = '[[at]]\nmeasure = {}\nbeat = {}\nsignal = "hit"\n'
    assert notes(follows + at.format(3, 4.5) + at.format(2, 4.5) + at.format(6, 4.9)) == [
        ("at 1 is at beat 4.5 of measure 3, which has 3", ("at", 0, "beat"), 3)
    ]


def test_sections_that_begin_within_a_phrase_are_named() -> None:
    phrases = "".join(
        f'[[music.phrase]]\nmeasure = {measure}\nname = "{name}"\n' for measure, name in ((1, "A"), (5, "B"))
    )
    sections = "".join(
        f'[[section]]\nname = "{name}"\nmeasures = {size}\n' for name, size in (("a", 4), ("b", 2), ("c", 2))
    )
    assert notes(lines([4] * 8, phrases) + sections) == [
        ("section 'c' begins in measure 7, within the phrase 'B' that begins in measure 5", ("section", 2), 7)
    ]


def test_words_are_limited() -> None:
    text = lines([4] * 4) + "".join(segment(measure) for measure in range(5, 25))
    words = music_warnings(parse_patch(GROUP + text, "test.toml"))
    assert len(words) == MAX_WARNINGS + 1
    assert words[-1] == "... and 14 more that do not fit the music"


@pytest.mark.parametrize("text", ["", "[music]\nbpm = 100\none_at_s = 1.0\n"])
def test_music_without_lines_is_not_judged(text: str) -> None:
    assert notes(text + segment(900)) == []
