"""Tests of takes of a sketched phrase, and of the directions in which a step is danced."""

import numpy as np
import pytest

from live.motion.sketch.sketch_clips import step_clip, step_clips
from live.motion.sketch.sketch_file import SketchError, parse_sketch
from live.motion.step_clip import DIRECTIONS

PHRASE = """
name = "rise"
beats = 8
begin_pose = "low"
end_pose = "low"
[pelvis]
"1" = "down 20"
"5" = "up 0"
[right_foot]
"2" = "home, lift 3"
[left_foot]
"6" = "home, lift 3"
[[take]]
measures = 1
end_pose = "left high"
[[take]]
measures = [2, 2]
begin_pose = "left high"
"""
TRAVELS = 'travels = true\nlong = 0.3\ndirections = ["long left", "in place"]\n'


def test_take_is_part_of_phrase():
    sketch = parse_sketch(PHRASE, "rise.toml")
    whole, takes = step_clip(sketch), step_clips(sketch)
    assert [(t.begin_pose, t.end_pose, t.mirrored) for t in takes] == [
        ("low", "left high", False), ("left high", "low", False),
        ("low", "right high", True), ("right high", "low", True),
    ]  # fmt: skip
    for number, take in enumerate(takes[:2]):
        assert (take.step, take.measures, take.first) == ("rise", 1, 128.0)
        part = slice(number * 128, number * 128 + take.clip.sample_count)
        assert np.array_equal(take.clip.rotation, whole.clip.rotation[part])
        assert np.array_equal(take.clip.contact, whole.clip.contact[part])
        assert np.allclose(take.clip.root_position[128, [0, 2]], 0.0)
        assert np.allclose(np.diff(take.clip.root_position, axis=0), np.diff(whole.clip.root_position[part], axis=0))
    # the end of the one is the beginning of the other
    assert np.allclose(takes[0].clip.rotation[256], takes[1].clip.rotation[128], atol=1e-6)
    assert takes[0].clip.root_position[256, 1] - takes[0].clip.root_position[128, 1] > 0.1


def test_step_travels_only_in_listed_directions():
    steps = step_clips(parse_sketch(TRAVELS + PHRASE, "rise.toml"))
    own = [step.direction for step in steps if not step.mirrored]
    assert own == ["in place", "long left"] * 2
    assert [step.direction for step in steps if step.mirrored] == ["in place", "long right"] * 2
    way = np.array([step.clip.root_position[256, 0] - step.clip.root_position[128, 0] for step in steps])
    # the feet step once in each measure, not evenly; both measures together go the whole way
    assert np.allclose(way.reshape(2, 2, 2).sum(axis=1), [[0.0, 0.6], [0.0, -0.6]], atol=1e-4)


def test_missing_directions_default_to_all_nine():
    assert parse_sketch('name = "a"', "a.toml").directions == DIRECTIONS


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        (PHRASE.replace("[2, 2]", "[2, 3]"), 17, "from 1 to 2"),
        (PHRASE.replace("[2, 2]", "true"), 17, "from 1 to 2"),
        (PHRASE.replace("[2, 2]", "[2, 1]"), 17, "from 1 to 2"),
        (PHRASE + "mesures = 1", 19, "fields of a take"),
        (PHRASE + "weight_transfer = 3", 19, "true or false"),
        ("cyclic = false\n" + PHRASE, 14, "does not repeat"),
        (PHRASE + '[body]\n"2" = "turn left 90"', 19, "a file for each"),
        ("take = 3\n" + PHRASE.split("[[take]]")[0], 1, r"\[\[take\]\]"),
        ('directions = ["in place"]\n' + PHRASE, 1, "travels = true"),
        ('travels = true\ndirections = ["up"]\n' + PHRASE, 2, "long forward"),
    ],
)
def test_each_take_error_names_line_and_remedy(text, line, says):
    with pytest.raises(SketchError, match=says) as caught:
        parse_sketch(text, "rise.toml")
    assert caught.value.line == line
