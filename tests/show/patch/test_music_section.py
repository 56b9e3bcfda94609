"""Measure lines in a patch: in order, and what they say of the music's beginning."""

import pytest

from live.base.errors import PersonError
from live.show.patch.patch_reader import parse_patch

HEAD = 'name = "x"\n[[group]]\nname = "a"\ndancers = 2\nsteps = ["groove"]\n'
LINES = "[[music.line]]\ntime_s = 2.5\nmeasure = 1\n[[music.line]]\ntime_s = {}\nmeasure = {}\nbeats = 3\n"


def test_lines_are_a_map_and_give_the_first_downbeat_and_tempo() -> None:
    music = parse_patch(HEAD + LINES.format(4.5, 2) + '[[music.phrase]]\nmeasure = 1\nname = "A"\n', "x").music
    assert music.measures is not None
    assert [(line.time_s, line.beats) for line in music.measures.lines] == [(2.5, 4), (4.5, 3)]
    assert music.measures.phrases[0].name == "A"
    assert (music.first_downbeat, music.known_tempo) == (2.5, pytest.approx(120.0))
    given = parse_patch(HEAD + "[music]\none_at_s = 1.0\nbpm = 90\n", "x").music
    assert (given.first_downbeat, given.known_tempo, given.measures) == (1.0, 90.0, None)


@pytest.mark.parametrize(
    ("time", "measure", "words"),
    [(2.0, 2, "line 10: music.line.2.time_s: 2 s after a line at 2.5 s"), (4.5, 3, "line 11: music.line.2.measure")],
)
def test_lines_that_go_back_are_refused_at_their_place(time: float, measure: int, words: str) -> None:
    with pytest.raises(PersonError) as caught:
        parse_patch(HEAD + LINES.format(time, measure), "x")
    assert words in str(caught.value)
