"""Scores that cannot be are named before they play: file, line, field, what was read and what would do."""

from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.show.load import LoadedShow
from live.show.patch_file import read_sources
from tests.show.made_show import GRAPH, PATCH

SECTIONS = '[[section]]\nname = "verse"\nmeasures = 8\n[[section]]\nname = "solo"\nmeasures = 4\n'
CUE = '[[cue]]\nname = "go"\n'
FIRST = len(PATCH.split("\n"))
"""The line on which what is put after PATCH begins."""


def start(tmp_path: Path, extra: str) -> None:
    path = tmp_path / "show.toml"
    path.write_text(PATCH + extra)
    patch, sources = read_sources(path)
    LoadedShow(path, patch, GRAPH, sources=sources).start()


BAD = [
    # sections
    (
        '[[section]]\nname = "a"\nmeasures = 2\n[[section]]\nname = "A"\nmeasures = 2',
        4,
        "section.2.name",
        "two sections",
    ),
    ('[[section]]\nname = "a"\nmeasures = 2\nthen = "b"', 3, "section.1.then", "there are: end, a"),
    ('[[section]]\nname = "a"\nmeasures = -2', 2, "section.1.measures", "greater than or equal to 1, found -2"),
    ('[[section]]\nname = "end"\nmeasures = 2', 0, "section.1", "can be called 'end'"),
    ('[[section]]\nname = "a"\nmeasures = 2\nwait = true\nrepeat = 3', 0, "section.1", "leave one out"),
    # places
    (SECTIONS + '[[element]]\nkind = "spread"\nsection = "bridge"\nmeasure = 1', 8, "element.1.section", "verse, solo"),
    (
        SECTIONS + '[[element]]\nkind = "spread"\nsection = "solo"\nmeasure = 5',
        9,
        "element.1.measure",
        "has 4 measures",
    ),
    (SECTIONS + "[[segment]]\nmeasure = 13", 7, "segment.1.measure", "the score has 12 measures"),
    (SECTIONS + '[[at]]\nmeasure = 2\nbeat = 5.5\nsignal = "x"', 8, "at.1.beat", "less than 5"),
    ("[[sequence]]\nmeasure = 1\nsteps = []", 2, "sequence.1.steps", "at least 1"),
    ('[[sequence]]\nmeasure = 0\nsteps = ["sway"]', 1, "sequence.1.measure", "greater than or equal to 1"),
    ('[[sequence]]\ngroup = "choir"\nsteps = ["sway"]', 1, "sequence.1.group", "there are: front, back"),
    # a score that overlaps itself
    (
        '[[sequence]]\nmeasures = 4\nsteps = ["sway"]\n[[sequence]]\ngroup = "back"\nmeasure = 4\nsteps = ["spin"]',
        5,
        "sequence.2.measure",
        "measures = 3 for that one",
    ),
    ('[[sequence]]\nmeasures = 3\nsteps = ["sway", "phrase", "phrase"]', 1, "sequence.1.measures", None),
    ('[[sequence]]\nmeasures = 2\nsteps = ["sway", "phrase"]', 1, "sequence.1.measures", "only 1 of the 2 are left"),
    (
        SECTIONS + '[[sequence]]\nsection = "solo"\nmeasure = 3\nsteps = ["sway x3"]',
        6,
        "sequence.1.measures",
        "it goes on to measure 5, and its section has 4",
    ),
    (
        '[[segment]]\nmeasure = 2\nmeasures = 4\ngroup = "front"\n[[segment]]\nmeasure = 4\ngroup = "1-2"',
        5,
        "segment.2.measure",
        "until the end of measure 5",
    ),
    ('[[segment]]\nmeasure = 2\n[[segment]]\nmeasure = 5\ngroup = "back"', 3, "segment.2.measure", "measures = 3"),
    (
        '[[regroup]]\nmeasure = 3\ndancers = "1-3"\ngroup = "back"\n'
        '[[regroup]]\nmeasure = 3\ndancers = "front"\ngroup = "front"',
        6,
        "regroup.2.dancers",
        "both claim dancer 1",
    ),
    (
        '[[improvise]]\ngroup = "front"\nmeasures = 4\n[[improvise]]\nmeasure = 3',
        4,
        "improvise.2.measure",
        "improvises already there",
    ),
    (
        SECTIONS + '[[improvise]]\nsection = "solo"\nmeasures = 5',
        8,
        "improvise.1.measures",
        "its section ends with 4",
    ),
    # calls to nowhere
    (
        '[[at]]\nmeasure = 1\ncall = "/dance/section"\nvalues = ["coda"]',
        3,
        "at.1.values",
        "no section is called 'coda'",
    ),
    (
        '[[at]]\nmeasure = 1\ncall = "/dance/step"\nvalues = ["moonwalk"]',
        3,
        "at.1.values",
        "no step is called 'moonwalk'",
    ),
    ('[[at]]\nmeasure = 1\ncall = "/dance/nothing"', 0, "at.1", "/dance/nothing"),
    ('[[at]]\nmeasure = 1\ncall = "/dance/attract"\nvalues = [1e9, 0]', 0, "at.1", "/dance/attract"),
    ("[[at]]\nmeasure = 1", 0, "at.1", "one of call, scene and signal"),
    ('[[react]]\non = "hit"\ncall = "/dance/spread"', 1, "react.1.on", "name it in a [[signal]]"),
    (
        '[[signal]]\nname = "a"\n[[signal]]\nname = "b"\n'
        '[[react]]\non = "a"\nwhen = "now"\ncall = "/dance/signal"\nvalues = ["b"]\n'
        '[[react]]\non = "b"\nwhen = "beat"\ncall = "/dance/signal"\nvalues = ["a"]',
        13,
        "react.2.values",
        "would give itself again and again",
    ),
    ('[[improvise]]\ngroup = "front"\nanswers = "choir"', 2, "improvise.1.answers", "there are: front, back"),
    ('[[improvise]]\ngroup = "front"\nanswers = "front"', 0, "improvise.1", "cannot answer itself"),
    ("[[improvise]]\nsteps = {moonwalk = 1}", 0, "improvise.1", "no step is called 'moonwalk'"),
    ("[[improvise]]\nsteps = {sway = 0}", 0, "improvise.1", "all weights are 0"),
    ("[[improvise]]\nat_least = 3", 0, "improvise.1", "is more than most 2"),
    ('[[improvise]]\nmotion = [{call = "/dance/nothing"}]', 1, "improvise.1.motion.1", "/dance/nothing"),
    ("[[improvise]]\n[[improvise.rule]]\nof = 'low'\nfavours = {sway = 2}", 1, "improvise.1.rule.1", "above or below"),
    # calls of cues, and of motion that is improvised
    (CUE + 'calls = [["/dance/step", "moonwalk"]]', 2, "cue.1.calls.1", "no step is called 'moonwalk'"),
    (CUE + 'calls = [["/dance/spread"], ["/dance/spread", 2, "embers"]]', 2, "cue.1.calls.2", "'embers'"),
    (CUE + 'calls = [["/dance/formation", "wegde"]]', 2, "cue.1.calls.1", "'wegde' is no formation"),
    (CUE + 'calls = [["/dance/section", "bridge"]]', 2, "cue.1.calls.1", "no section is called 'bridge'"),
    (CUE + 'calls = [["/dance/formation/define", "mine", "line"], ["/dance/formation", "Mine"]]', 0, "", None),
]


@pytest.mark.parametrize(
    ("extra", "line", "field", "words"), BAD, ids=[f"{field}-{n}" for n, (_, _, field, _) in enumerate(BAD)]
)
def test_what_cannot_be_is_named_with_file_line_and_field(tmp_path, extra, line, field, words):
    if words is None:
        start(tmp_path, extra)
        return
    with pytest.raises(PersonError) as caught:
        start(tmp_path, extra)
    told = str(caught.value)
    assert f"show.toml, line {FIRST + line}: {field}" in told
    assert words in told


def test_loop_measures_and_sections_do_not_go_together(tmp_path):
    path = tmp_path / "show.toml"
    path.write_text("loop_measures = 4\n" + PATCH + SECTIONS)
    with pytest.raises(PersonError, match="loop_measures"):
        read_sources(path)


def test_the_same_words_elsewhere_are_no_overlap(tmp_path):
    start(
        tmp_path,
        SECTIONS
        + '[[sequence]]\nsection = "verse"\nmeasures = 8\nsteps = ["sway"]\n'
        + '[[sequence]]\nsection = "solo"\nsteps = ["spin", "sway"]\n[[sequence]]\nsection = "solo"\nmeasure = 3\n'
        + 'steps = ["phrase"]\n[[segment]]\nsection = "verse"\nmeasure = 1\n[[segment]]\nmeasure = 5\ngroup = "front"\n'
        + '[[segment]]\nmeasure = 5\ngroup = "back"\n[[segment]]\nmeasure = 5\ngroup = "left"\n',
    )
