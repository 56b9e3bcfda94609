"""Invalid scores are refused before they play: file, line, field, found value and remedy."""

from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import read_sources
from tests.show.made_show import GRAPH, PATCH

SECTIONS = '[[section]]\nname = "verse"\nmeasures = 8\n[[section]]\nname = "solo"\nmeasures = 4\n'
CUE = '[[cue]]\nname = "go"\n'
ON = '[[cue]]\nname = "on"\nwhen = "beat"\n'
REACT = '[[react]]\non = "drop"\n'
IMPROVISE = "[[improvise]]\n"
FIRST = len(PATCH.split("\n"))
"""The line of the first text after PATCH."""


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
    ('[[sequence]]\ngroup = "choir"\nsteps = ["sway"]', 1, "sequence.1.group", "there are: all, back"),
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
    (CUE + 'calls = [["/dance/formation", "wegde"]]', 2, "cue.1.calls.1", "unknown formation 'wegde'"),
    (CUE + 'calls = [["/dance/section", "bridge"]]', 2, "cue.1.calls.1", "no section is called 'bridge'"),
    (CUE + 'calls = [["/dance/formation/define", "mine", "line"], ["/dance/formation", "Mine"]]', 0, "", None),
    (REACT + 'call = "/dance/step"\nvalues = ["moonwalk"]', 3, "react.1.values", "no step is called 'moonwalk'"),
    (REACT + 'call = "/dance/sequence"\nvalues = ["spin, moonwalk"]', 3, "react.1.values", "entry 2 of the sequence"),
    (
        '[[midi.map]]\nnote = 3\ncontrol = "/dance/step"\nvalues = {name = "moonwalk"}',
        3,
        "midi.map.1.values",
        "no step is called 'moonwalk'",
    ),
    ('[[react]]\nto = "low"\nsets = "larger"\ngroup = "choir"', 3, "react.1.group", "there are: all, back"),
    (CUE + 'calls = [["/dance/scene", "mine"]]', 2, "cue.1.calls.1", "no scene is called 'mine' (there are: start)"),
    (CUE + 'calls = [["/dance/scene/store", "mine"], ["/dance/scene", "Mine"], ["/dance/look", "start"]]', 0, "", None),
    (CUE + 'calls = [["/dance/look", "dusk"]]', 2, "cue.1.calls.1", "no look is called 'dusk'"),
    (CUE + 'calls = [["/dance/camera", "sideways"]]', 2, "cue.1.calls.1", "no view is called 'sideways'"),
    (CUE + 'calls = [["/dance/signal", "hit"]]', 2, "cue.1.calls.1", "no signal is called 'hit' (there are: build, dr"),
    (CUE + 'calls = [["/dance/facing", "upwards"]]', 2, "cue.1.calls.1", "facing 'upwards' means nothing"),
    (CUE + 'calls = [["/dance/enter", 1, "front", "trap door"]]', 2, "cue.1.calls.1", "there are: left, right, back"),
    (CUE + 'calls = [["/dance/enter", 1, "front", "Left"], ["/dance/signal", "drop"]]', 0, "", None),
    (
        SECTIONS + CUE + 'calls = [["/dance/section", "solo", "measure", 5]]',
        8,
        "cue.1.calls.1",
        "has no measure 5 (it has 4)",
    ),
    (SECTIONS + CUE + 'calls = [["/dance/advance", "soon"]]', 8, "cue.1.calls.1", "there are: measure, section"),
    (SECTIONS + CUE + 'calls = [["/dance/practice", 9, 13]]', 8, "cue.1.calls.1", "no measure 13 (it has 12)"),
    (SECTIONS + CUE + 'section = "bridge"', 8, "cue.1.section", "there are: verse, solo"),
    # cues that come back to themselves
    (CUE + 'calls = [["/dance/spread"], ["/dance/cue", "Go"]]', 2, "cue.1.calls.2", "calls itself"),
    (CUE + 'number = 4\ncalls = [["/dance/cue", "4"]]', 3, "cue.1.calls.1", "calls itself"),
    (
        CUE + 'when = "now"\ncalls = [["/dance/cue", "on"]]\n'
        '[[cue]]\nname = "on"\nwhen = "now"\ncalls = [["/dance/cue", "go"]]',
        3,
        "cue.1.calls.1",
        "back to itself within 0 beats",
    ),
    (
        CUE + 'when = "now"\ncalls = [["/dance/signal", "s"]]\n[[signal]]\nname = "s"\n'
        '[[react]]\non = "S"\nwhen = "now"\ncall = "/dance/cue"\nvalues = ["go"]',
        3,
        "cue.1.calls.1",
        "back to itself",
    ),
    (CUE + 'calls = [["/dance/standby", "go"]]', 0, "", None),
    (CUE + 'when = "beat"\ncalls = [["/dance/cue", "on"]]\n' + ON + 'calls = [["/dance/cue", "go"]]', 0, "", None),
    (CUE + 'then = "auto"\n' + ON + 'calls = [["/dance/cue", "go"]]', 0, "", None),
    (CUE + "number = 12\n[[cue]]\nname = '12'", 4, "cue.2.name", "is called as cue 'go' is numbered"),
    (CUE + "number = 12\n[[cue]]\nname = '13'\nnumber = 13", 0, "", None),
    # what a patch begins with
    ('[[scene]]\nname = "Start"', 1, "scene.1.name", "names the start of the patch"),
    ('[[view]]\nname = "start"', 1, "view.1.name", "names the start of the patch"),
    ('[[looks]]\nname = "start"', 1, "looks.1.name", "names the start of the patch"),
    (
        '[[scene]]\nname = "a"\n[scene.set]\n"/dance/camera/eye" = [0, 2, 3]\n"/dance/camera/target" = [0, 2, 3]',
        0,
        "scene.1",
        "the camera looks nowhere",
    ),
    # call and response
    (
        IMPROVISE + 'group = "front"\nanswers = "back"\nlistening = "sway"\n'
        '[[improvise]]\ngroup = "back"\nanswers = "front"\nlistening = "glide"',
        6,
        "improvise.2.answers",
        "nobody calls: 'front' and 'back'",
    ),
    (IMPROVISE + 'answers = "back"\nlistening = "sway"', 1, "improvise.1.answers", "so does that group itself"),
    (IMPROVISE + 'group = "front"\nanswers = "back"\nmeasures = 4', 0, "improvise.1.phrase", "2 at most"),
    (
        SECTIONS + IMPROVISE + 'section = "solo"\ngroup = "front"\nanswers = "back"\nphrase = 3\nmeasure = 2',
        10,
        "improvise.1.phrase",
        "it ends after 3 measures: 1 at most",
    ),
    (
        IMPROVISE + 'group = "front"\nanswers = "back"\n[[improvise]]\ngroup = "back"\nanswers = "front"',
        0,
        "",
        None,
    ),
    # measures are told as they are counted where they are written
    (
        SECTIONS + "[[segment]]\nmeasure = 9\nmeasures = 3\n[[segment]]\nmeasure = 10",
        10,
        "segment.2.measure",
        "segment 2 begins in measure 10 with dancers whom segment 1 has until the end of measure 11",
    ),
    (
        SECTIONS + '[[segment]]\nmeasure = 9\nmeasures = 3\n[[segment]]\nsection = "solo"\nmeasure = 2',
        11,
        "segment.2.measure",
        "begins in measure 2 of section 'solo' with dancers whom segment 1 (measure 9 of the whole score) has until "
        "the end of measure 3",
    ),
    (
        SECTIONS + '[[sequence]]\nmeasure = 9\nsteps = ["sway x3"]\n[[sequence]]\nmeasure = 10\nsteps = ["spin"]',
        10,
        "sequence.2.measure",
        "begins in measure 10, and sequence 1 of the same group lasts until the end of measure 11",
    ),
    (
        SECTIONS + '[[sequence]]\nmeasure = 10\nmeasures = 6\nsteps = ["sway"]',
        8,
        "sequence.1.measures",
        "it goes on to measure 15, and its section ends with 12 (measures = 3)",
    ),
    (SECTIONS + IMPROVISE + "measure = 7\nmeasures = 4", 8, "improvise.1.measures", "its section ends with 8"),
    (
        SECTIONS + IMPROVISE + 'measure = 9\n[[improvise]]\nsection = "solo"\ngroup = "back"',
        8,
        "improvise.2.measure",
        "improvises already there, as improvise 1 says",
    ),
]


@pytest.mark.parametrize(
    ("extra", "line", "field", "words"), BAD, ids=[f"{field}-{n}" for n, (_, _, field, _) in enumerate(BAD)]
)
def test_invalid_score_is_refused_with_line_and_field(tmp_path, extra, line, field, words):
    if words is None:
        start(tmp_path, extra)
        return
    with pytest.raises(PersonError) as caught:
        start(tmp_path, extra)
    told = str(caught.value)
    assert f"show.toml, line {FIRST + line}: {field}" in told
    assert words in told


def test_loop_measures_with_sections_is_refused(tmp_path):
    path = tmp_path / "show.toml"
    path.write_text("loop_measures = 4\n" + PATCH + SECTIONS)
    with pytest.raises(PersonError, match="loop_measures"):
        read_sources(path)


def test_entries_in_different_places_do_not_overlap(tmp_path):
    start(
        tmp_path,
        SECTIONS
        + '[[sequence]]\nsection = "verse"\nmeasures = 8\nsteps = ["sway"]\n'
        + '[[sequence]]\nsection = "solo"\nsteps = ["spin", "sway"]\n[[sequence]]\nsection = "solo"\nmeasure = 3\n'
        + 'steps = ["phrase"]\n[[segment]]\nsection = "verse"\nmeasure = 1\n[[segment]]\nmeasure = 5\ngroup = "front"\n'
        + '[[segment]]\nmeasure = 5\ngroup = "back"\n[[segment]]\nmeasure = 5\ngroup = "left"\n',
    )
