"""Warnings on doubtful scores, and no warnings on sound ones."""

import pytest

from live.rehearse.score_lint import cue_warnings, formation_warnings, section_warnings, sequence_warnings
from live.show.patch.patch_reader import parse_patch
from tests.show.desk.desk_show import DESK
from tests.show.made_show import PATCH, made_show

SECTIONS = """
[[section]]
name = "a"
measures = 4
then = "c"
[[section]]
name = "b"
measures = 4
[[section]]
name = "c"
measures = 4
then = "end"
"""
SCENES = """
[[scene]]
name = "low"
measures = 4
[scene.set]
"/dance/light/level" = 0.2
[[scene]]
name = "high"
[scene.set]
"/dance/light/level" = 1.0
[[scene]]
name = "haze"
[scene.set]
"/dance/light/haze" = 0.1
"""


def patch_of(extra):
    return parse_patch(PATCH + extra, "made.toml")


def test_unreachable_section_is_warned_about():
    assert [note.split("'")[1] for note in section_warnings(patch_of(SECTIONS))] == ["b"]
    assert section_warnings(patch_of("")) == []
    assert section_warnings(patch_of(DESK)) == []


def sequence_show(measures, steps):
    written = f"""
[[sequence]]
group = "front"
measures = {measures}
steps = {steps}
"""
    return made_show(written)


def test_sequence_shorter_than_its_steps_is_warned_about():
    assert sequence_warnings(sequence_show(3, '["glide", "spin x2"]')) == []
    assert sequence_warnings(sequence_show(4, '["glide", "spin"]')) == []  # danced again: nothing is left out
    assert "before 'spin'" in sequence_warnings(sequence_show(2, '["glide", "spin x2"]'))[0]


@pytest.mark.parametrize(
    "leads",
    [
        '[[cue]]\nname = "x"\nsection = "B"\n',
        '[[cue]]\nname = "x"\ncalls = [["/dance/section", "b"]]\n',
        '[[at]]\nmeasure = 1\ncall = "/dance/section"\nvalues = ["b"]\n',
        '[[react]]\non = "drop"\ncall = "/dance/section"\nvalues = ["b"]\n',
    ],
)
def test_section_reached_by_cue_or_call_has_no_warning(leads):
    assert section_warnings(patch_of(SECTIONS + leads)) == []


def cues_toml(first, second):
    return f'{SCENES}[[cue]]\nname = "one"\n{first}\n[[cue]]\nname = "two"\n{second}\n'


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        ('scene = "low"\nthen = "auto"\nafter = 2', 'scene = "high"', "never ends"),
        ('then = "auto"\nafter = 1', "count_in = 8", "later than that"),
        ('scene = "low"\nthen = "auto"\nafter = 4', 'scene = "high"', None),
        ("", 'then = "auto"', "'two' is the last one"),
        ('then = "auto"\nafter = 7', 'calls = [["/dance/cue", "one"]]', "comes again every 8 measures"),
        ('calls = [["/dance/standby", "two"]]', 'calls = [["/dance/standby", "one"]]', None),
        ('scene = "low"\nthen = "auto"\nafter = 2', 'scene = "haze"', None),
        ('scene = "low"', 'scene = "high"\ncount_in = 8', None),
        ('scene = "low"\nmeasures = 1\nthen = "auto"\nafter = 2', 'scene = "high"', None),
    ],
)
def test_colliding_cues_are_warned_about(first, second, words):
    notes = cue_warnings(patch_of(cues_toml(first, second)))
    assert len(notes) == (words is not None)
    assert words is None or words in notes[0]


def scene_at(measure, scene, beat=1):
    return f'[[at]]\nmeasure = {measure}\nbeat = {beat}\nscene = "{scene}"\n'


@pytest.mark.parametrize(
    ("entries", "count"),
    [
        (scene_at(2, "low") + scene_at(4, "high", 2), 1),
        (scene_at(2, "low") + scene_at(6, "high"), 0),
        (scene_at(2, "low") + scene_at(4, "haze"), 0),
        (scene_at(2, "high") + scene_at(2, "low"), 1),
    ],
)
def test_overlapping_scene_fades_are_warned_about(entries, count):
    assert len(cue_warnings(patch_of(SCENES + entries))) == count


def test_tight_formation_is_warned_about_with_its_distance():
    tight = '[[formation]]\nname = "dot"\nshape = "line"\nsize = [1.0, 1.0]\n'
    wide = tight.replace("[1.0, 1.0]", "[8.0, 1.0]").replace("dot", "row")
    segments = '[[segment]]\nmeasure = {}\nmeasures = 2\nformation = "{}"\n'
    notes = formation_warnings(made_show(tight + wide + segments.format(1, "dot") + segments.format(5, "row")))
    assert len(notes) == 1
    assert "dot for 9 dancers" in notes[0]
    assert "0.12 m apart" in notes[0]
