"""Warnings of `live check` on playable but doubtful scores, and scores without warnings."""

import pytest

from live.rehearse.lint import MAX_WARNINGS, camera_warnings, lint_show, span_warnings
from live.show.patch.patch_reader import parse_patch, read_patch
from live.show.patch_checks.call_response_check import call_response_warnings
from tests.show.made_show import PATCH, PATCH_WITHOUT_CAMERA, made_show

SECTIONS = '[[section]]\nname = "a"\nmeasures = 8\n[[section]]\nname = "b"\nmeasures = 4\n[[section]]\nname = "c"\n'
SECTIONS += "measures = 8\n{}\n"


def patch_of(extra):
    return parse_patch(PATCH + extra, "made.toml")


def assert_warning(notes, words):
    assert len(notes) == (words is not None), notes
    assert words is None or words in notes[0]


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ('section = "b"\nmeasure = 3\nmeasures = 4', "measures = 2 ends it there"),
        ('section = "b"\nmeasure = 3', "(measures is left out)"),
        ('section = "b"\nmeasure = 3\nmeasures = 2', None),
        ("measure = 6\nmeasures = 5", None),  # into b, as it is written
        ("measure = 11\nmeasures = 4", "section 'b' ends with measure 12"),  # b repeats
        ("measure = 18\nmeasures = 4", "ends with measure 20"),
    ],
)
@pytest.mark.parametrize("kind", ["[[segment]]", '[[element]]\nkind = "spread"'])
def test_span_beyond_its_section_is_warned_about(kind, entry, words):
    sections = SECTIONS.replace('name = "b"', 'name = "b"\nrepeat = 2').format('then = "end"')
    assert_warning(span_warnings(patch_of(f"{sections}{kind}\n{entry}\n")), words)


def test_span_beyond_loop_is_warned_about_without_sections():
    entry = '[[element]]\nkind = "spread"\nmeasure = 7\nmeasures = 4\n'
    assert_warning(
        span_warnings(parse_patch("loop_measures = 8\n" + PATCH + entry, "made.toml")),
        "but the score ends with measure",
    )
    assert_warning(span_warnings(patch_of(entry)), None)


def test_number_of_span_warnings_is_limited():
    many = '[[element]]\nkind = "spread"\nsection = "b"\nmeasure = 4\n' * (MAX_WARNINGS + 3)
    notes = span_warnings(patch_of(SECTIONS.format("") + many))
    assert len(notes) == MAX_WARNINGS + 1
    assert notes[-1].startswith("... and 3 more")


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        ("[camera]\neye = [0, -2, 9]\n", "[camera]: the camera's eye is 2 m below the floor"),
        ('[[view]]\nname = "x"\neye = [0, -0.5, 9]\n', "view 'x'"),
        ('[[scene]]\nname = "x"\n[scene.set]\n"/dance/camera/eye" = [0, -1, 9]\n', "scene 'x'"),
        ('[[at]]\nmeasure = 1\ncall = "/dance/camera/eye"\nvalues = [0, -1, 9]\n', "at 1, call"),
        ("[camera]\neye = [0, 0.0, 9]\ntarget = [0, -1, 0]\n", None),
    ],
)
def test_camera_below_floor_is_warned_about(extra, words):
    assert_warning(camera_warnings(parse_patch(PATCH_WITHOUT_CAMERA + extra, "made.toml")), words)


def improvise(front, back):
    return f'[[improvise]]\ngroup = "front"\n{front}\n[[improvise]]\ngroup = "back"\n{back}\n'


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        (improvise('answers = "back"', 'answers = "front"'), "answer each other"),
        (improvise('answers = "back"\nmeasures = 8', 'answers = "front"\nmeasure = 9\nmeasures = 8'), None),
        (improvise("phrase = 3", 'answers = "front"\nphrase = 4'), "phrase = 3 for both"),
        (improvise("phrase = 2", 'answers = "front"\nphrase = 4'), None),
        (improvise("", 'answers = "front"\nphrase = 3'), None),  # a caller without phrases of its own
        (improvise("", 'answers = "front"\nmeasures = 12'), "the call of its last 4 has no answer"),
        (improvise("", 'answers = "front"\nmeasures = 16'), None),
        ('[[improvise]]\nanswers = "front"\n', "answers itself"),
    ],
)
def test_mismatched_calls_and_answers_are_warned_about(extra, words):
    assert_warning(call_response_warnings(patch_of(extra)), words)


@pytest.mark.parametrize("name", ["score", "cues", "formations", "pairs"])
def test_included_shows_have_no_warnings(name):
    from live.show.patch.patch_search_path import find_patch

    patch = read_patch(find_patch(name))
    assert [*span_warnings(patch), *camera_warnings(patch), *call_response_warnings(patch)] == []


def test_lint_groups_warnings_by_kind():
    show = made_show('[camera]\neye = [0, -2, 9]\n[[cue]]\nname = "x"\nthen = "auto"\n')
    doubts = {one.name: one for one in lint_show(show)}
    assert [name for name, one in doubts.items() if one.warnings] == ["cues", "cameras"]
    assert doubts["cues"].count_text == "1 cues"
    assert doubts["ways"].count_text == "0 segments"
