"""Tests of step attributes in sketches: every clip has them, mirrored where necessary."""

import pytest

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
