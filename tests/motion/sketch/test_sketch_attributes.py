"""Tests of step attributes in sketches: every clip has them, mirrored where necessary."""

import pytest

from live.motion.editing.tempo_forms import double_time, half_time
from live.motion.mirror import mirror_step, swap_sides
from live.motion.sketch.sketch_clips import step_clips
from live.motion.sketch.sketch_file import SketchError, parse_sketch

COURU = """name = "couru"
leading_foot = "left"
begin_pose = "plié, left foot in front"
end_pose = "Sous-sus"
weight_transfer = true
author = "Ana"
style = "soft"
tags = ["ballet", "slow"]
"""


def test_clips_have_attributes_and_mirror_swaps_sides():
    own, mirrored = step_clips(parse_sketch(COURU, "couru.toml"))
    assert (own.leading_foot, own.begin_pose, own.end_pose) == ("left", "plié, left foot in front", "Sous-sus")
    assert (mirrored.leading_foot, mirrored.begin_pose) == ("right", "plié, right foot in front")
    for step in (own, mirrored):
        assert (step.weight_transfer, step.author, step.style) == (True, "Ana", "soft")
        assert step.tags == ("ballet", "slow")
        assert step.end_pose == "Sous-sus"


def test_missing_attributes_have_empty_defaults():
    (step, _) = step_clips(parse_sketch('name = "still"', "still.toml"))
    assert (step.leading_foot, step.begin_pose, step.end_pose, step.weight_transfer) == ("", "", "", False)
    assert (step.author, step.style, step.tags) == ("", "", ())


@pytest.mark.parametrize("words", ["Left knee over the RIGHT", "upright, leftover", "long left", ""])
def test_sides_are_swapped_as_whole_words(words):
    assert swap_sides(swap_sides(words)) == words
    assert (swap_sides(words) != words) == any(side in words.casefold().split() for side in ("left", "right"))


def test_mirroring_twice_restores_attributes():
    own, _ = step_clips(parse_sketch(COURU, "couru.toml"))
    again = mirror_step(mirror_step(own))
    for name in ("leading_foot", "begin_pose", "end_pose", "direction", "mirrored", "weight_transfer", "tags"):
        assert getattr(again, name) == getattr(own, name)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('leading_foot = "both"', 'read \'both\'; write "left" or "right"'),
        ("leading_foot = [1]", 'write "left" or "right"'),
        ("weight_transfer = 1", "read 1; true or false is needed"),
        ("begin_pose = 3", "read 3; a text of 1 to 64 characters is needed"),
        ('end_pose = " "', "a text of 1 to 64 characters is needed"),
        (f'author = "{"a" * 65}"', "a text of 1 to 64 characters is needed"),
        ('style = "a\\nb"', "a text of 1 to 64 characters is needed"),
        ('tags = "slow"', 'write at most 64 words in brackets: tags = ["slow", "low"]'),
        ("tags = [1]", "write at most 64 words in brackets"),
        ('style_of = "soft"', "weight_transfer, begin_pose, end_pose, author, style, tags"),
    ],
)
def test_attribute_error_names_line_and_remedy(line, says):
    with pytest.raises(SketchError) as caught:
        parse_sketch(f'name = "x"\n{line}\n', "x.toml")
    assert str(caught.value).startswith(f"x.toml:2: {line.split()[0]}: ")
    assert says in str(caught.value)


HANDS = """name = "wave"
beats = 8
hand_shape = [{ beat = 1, both = "fist" }, { beat = 3, left = "open" }, { beat = 6.5, both = "auto" }]
"""


def test_hand_shapes_change_on_beats_and_are_mirrored():
    own, mirrored = step_clips(parse_sketch(HANDS, "wave.toml"))
    assert own.hands == ((0.0, "fist", "fist"), (2.0, "open", "fist"), (5.5, "", ""))
    assert mirrored.hands == ((0.0, "fist", "fist"), (2.0, "fist", "open"), (5.5, "", ""))
    assert mirror_step(mirrored).hands == own.hands


def test_one_hand_shape_is_that_of_both_hands_for_all_of_the_step():
    (own, *_) = step_clips(parse_sketch('name = "x"\nhand_shape = "ballet"\n', "x.toml"))
    assert own.hands == ((0.0, "ballet", "ballet"),)


def test_alternate_sketch_has_its_hand_shapes_again_on_the_other_side():
    text = 'name = "x"\nalternate = true\nhand_shape = [{ beat = 1, left = "fist" }, { beat = 2, left = "open" }]\n'
    (own, *_) = step_clips(parse_sketch(text, "x.toml"))
    assert own.hands == ((0.0, "fist", ""), (1.0, "open", ""), (2.0, "", "fist"), (3.0, "", "open"))


def test_takes_have_the_hand_shapes_of_their_measures():
    text = HANDS + "[[take]]\nmeasures = [2, 2]\n[[take]]\nmeasures = [1, 1]\n"
    second, first = (clip for clip in step_clips(parse_sketch(text, "x.toml")) if not clip.mirrored)
    assert second.hands == ((0.0, "open", "fist"), (1.5, "", ""))
    assert first.hands == ((0.0, "fist", "fist"), (2.0, "open", "fist"))


def test_forms_of_another_tempo_move_hand_shapes_with_their_beats():
    (own, *_) = step_clips(parse_sketch(HANDS, "wave.toml"))
    assert half_time(own).hands == ((0.0, "fist", "fist"), (4.0, "open", "fist"), (11.0, "", ""))
    assert double_time(own).hands == ((0.0, "fist", "fist"), (1.0, "open", "fist"), (2.75, "", ""))


@pytest.mark.parametrize(
    "shape",
    ['"mitten"', "3", '[{ beat = 0, both = "fist" }]', '[{ beat = 2, both = "fist" }, { beat = 2, both = "open" }]',
     '[{ beat = 1, nose = "fist" }]', '[{ beat = "one", both = "fist" }]', '[{ left = "mitten" }]', '["fist"]'],
)  # fmt: skip
def test_wrong_hand_shape_is_refused_with_its_line_and_what_there_is(shape):
    with pytest.raises(SketchError) as refused:
        parse_sketch(f'name = "x"\nhand_shape = {shape}\n', "x.toml")
    assert str(refused.value).startswith("x.toml:2: hand_shape: ")
    assert "ballet" in str(refused.value)
