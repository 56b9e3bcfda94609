"""Tests of sequence text: parsed into entries; invalid text is reported with its entry and the nearest names."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.errors import PersonError
from live.graph.search.sequence import parse_sequence
from live.graph.search.sequence_spec import MAX_MEASURES, SequenceEntry, leading_foot_fits, specify
from live.graph.step_library import build_library
from tests.fixtures.made_steps import made_clip, made_steps


@pytest.fixture(scope="module")
def library():
    return build_library(
        [
            *made_steps(),  # sway, glide in five directions, spin, phrase of two measures
            made_clip("Échappé"),
            made_clip("wave x2"),
            made_clip("both"),
            made_clip("both", measures=2),
        ]
    )


def test_sequence_text_is_parsed(library):
    sway, glide, phrase, echappe = (library.steps.index(name) for name in ("sway", "glide", "phrase", "Échappé"))
    assert parse_sequence("sway, echappe x2,*, PHRASE,Glide long_left x 2", library) == [
        SequenceEntry(sway), SequenceEntry(echappe), SequenceEntry(echappe), SequenceEntry(None),
        SequenceEntry(phrase, 2), SequenceEntry(glide, direction="long left"),
        SequenceEntry(glide, direction="long left"),
    ]  # fmt: skip
    assert parse_sequence("wave x2, wave x2 ×3", library) == [SequenceEntry(library.steps.index("wave x2"))] * 4
    assert parse_sequence("glide left, both:2, both : 1", library) == [
        SequenceEntry(glide, direction="left"), SequenceEntry(library.steps.index("both"), 2),
        SequenceEntry(library.steps.index("both"), 1),
    ]  # fmt: skip
    assert (
        parse_sequence("glide short back", library)[0].direction == "short back"
    )  # no such clip: reported by the search


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sway,gilde", r"entry 2 of the sequence: there is no step 'gilde' \(glide"),
        ("phrses x3", r"entry 1 .* there is no step 'phrses' \(phrase\)"),
        ("zzzzz", r"there is no step 'zzzzz' \(the steps are sway, glide, spin"),
        ("", "entry 1 of the sequence is empty"),
        ("sway,,sway", "entry 2 of the sequence is empty"),
        ("sway x0", r"'sway x0': 1 to 100000 measures in all expected \(leave the entry out\)"),
        ("sway x99999999999999", r"entry 1 .*'sway x99999999999999': 1 to 100000 .* \(fewer repeats\)"),
        ("sway x99999,sway x2", "entry 2 of the sequence, 'sway x2': 1 to 100000"),
        ("both", r"variations of 'both' are 1 or 2 measures long: say which \(both:1\)"),
        ("both:4", r"'both' is 1 or 2 measures long, not 4 \(both:1\)"),
        ("sway:3", r"'sway' is 1 measure long, not 3 \(sway:1\)"),
        ("x" * 500, "there is no step 'xxx"),
        ("sway\x00", "there is no step"),
        ("* left", r"there is no step '\*'"),
    ],
)
def test_invalid_sequence_text_is_reported(library, text, message):
    with pytest.raises(PersonError, match=message) as error:
        parse_sequence(text, library)
    assert len(str(error.value)) < 400
    assert "\n" not in error.value.message


def test_accents_distinguish_otherwise_equal_names():
    library = build_library([made_clip("péte"), made_clip("pete")])
    assert [entry.step for entry in parse_sequence("pete, péte", library)] == [1, 0]


def test_measures_are_specified_by_name_and_number(library):
    spec = specify(library, parse_sequence("phrase,*,glide left,both:2", library))
    assert spec.measures == 6
    names = [[library.describe(node) for node in np.flatnonzero(spec.at(n))] for n in range(6)]
    assert names[:2] == [["phrase 1/2"], ["phrase 2/2"]]
    assert names[2] == [library.describe(node) for node in range(library.node_count)]
    assert names[3:] == [["glide long left"], ["both 1/2"], ["both 2/2"]]
    assert spec.entry_index.tolist() == [0, 0, 1, 2, 3, 3]
    last = specify(library, [SequenceEntry(None)])
    assert (last.at(0) == spec.leaves).all()  # a dance ends with the end of a step


def test_empty_or_overlong_sequence_is_refused(library):
    for wanted in ([], [SequenceEntry(0)] * (MAX_MEASURES + 1)):
        with pytest.raises(PersonError, match="1 to 100000 expected"):
            specify(library, wanted)


def test_right_foot_leads_travel_to_left():
    """T134: a travelling couru goes left only if the right foot leads, and the other way round."""
    rows = [("short left", "left"), ("long left", "right"), ("long right", "right"), ("short right", "left")]
    rows += [("long left", ""), ("in place", "left"), ("long forward", "right")]
    clips = [replace(made_clip("couru", direction=way), leading_foot=foot) for way, foot in rows]
    assert [leading_foot_fits(clip) for clip in clips] == [False, True, False, True, True, True, True]
    library = build_library(clips)
    assert specify(library, [SequenceEntry(0)]).at(0).all()
    assert specify(library, [SequenceEntry(0)], foot_rule=True).at(0).tolist() == [
        leading_foot_fits(clip) for clip in clips
    ]
    left = specify(library, [SequenceEntry(0, direction="left")], foot_rule=True)
    assert np.flatnonzero(left.at(0)).tolist() == [1, 4]
