"""Tests of reading sketch files: valid content, and errors that name the file, the line, the field and a remedy."""

import pytest

from live.motion.sketch.sketch_file import MAX_KEYS, Key, Sketch, SketchError, parse_sketch

PLAIN = """name = "plain"

[pelvis]
"1 2" = "down 6"
"1" = "left 3"
"1&" = "up 1"
[feet]
"1" = "home"
"""


def beats_of(keys: tuple[Key, ...]) -> list[float]:
    return [key.beat for key in keys]


def test_missing_fields_have_defaults() -> None:
    sketch = parse_sketch('name = "still"', "still.toml")
    assert sketch == Sketch("still", "still.toml", lines=sketch.lines)
    assert (sketch.beats, sketch.bpm, sketch.mirror, sketch.cyclic, sketch.travels) == (4, 112.0, True, True, False)


def test_keys_are_sorted_with_one_per_count() -> None:
    keys = parse_sketch(PLAIN, "plain.toml").parts["pelvis"]
    assert beats_of(keys) == [0.0, 0.5, 1.0]
    assert keys[0].amounts == {"up": pytest.approx(-0.06), "left": pytest.approx(0.03)}


def test_paired_parts_set_both_sides() -> None:
    parts = parse_sketch(PLAIN, "plain.toml").parts
    assert beats_of(parts["left_foot"]) == beats_of(parts["right_foot"]) == [0.0]


def test_alternate_sketch_mirrors_first_half() -> None:
    text = """name = "two"
    alternate = true
    [pelvis]
    "1" = "left 5, down 3, turn right 10"
    [left_hand]
    "2" = "out 20, left 0"
    """.replace(", left 0", "")
    parts = parse_sketch(text, "two.toml").parts
    first, second = parts["pelvis"]
    assert second.beat == 2.0
    assert second.amounts == {"left": -first.amounts["left"], "up": first.amounts["up"], "turn": -first.amounts["turn"]}
    assert beats_of(parts["left_hand"]) == [1.0]
    assert beats_of(parts["right_hand"]) == [3.0]
    assert parts["right_hand"][0].amounts == parts["left_hand"][0].amounts


@pytest.mark.parametrize(
    ("text", "line", "field", "says"),
    [
        ("", 1, "name", "give the step a name"),
        ("name = 3", 1, "name", "give the step a name"),
        ("name = ", 1, "TOML", "word = value"),
        ('name = "a"\n[pelvis]\n"1" = "up 1"\n"1" = "up 2"', 4, "TOML", "twice"),
        ('name = "a"\nbeats = 5', 2, "beats", "multiple"),
        ('name = "a"\nbeats = 80', 2, "beats", "64"),
        ('name = "a"\nbeats = 4.0', 2, "beats", "whole"),
        ('name = "a"\nbpm = nan', 2, "bpm", "300"),
        ('name = "a"\nbpm = "fast"', 2, "bpm", "300"),
        ('name = "a"\ntravels = 1', 2, "travels", "true or false"),
        ('name = "a"\ntempo = 100', 2, "tempo", "fields"),
        ('name = "a"\n\n[elbow]\n"1" = "up 3"', 3, "elbow", "parts"),
        ('name = "a"\npelvis = "down 3"', 2, "pelvis", "[pelvis]"),
        ('name = "a"\n[pelvis]\n"1" = 3', 3, "pelvis.1", "quotes"),
        ('name = "a"\n[pelvis]\n"1" = "up 3"\n"6&" = "up 3"', 4, 'pelvis."6&"', "counts"),
        ('name = "a"\n[pelvis]\n"1" = "higher 3"', 3, "pelvis.1", "words"),
        ('name = "a"\n[feet]\n"1" = "left 3"', 3, "feet.1", "words"),
        ('name = "a"\n[pelvis]\n"1 2" = "up 3"\n"2" = "down 3"', 4, "pelvis.2", "one of the two"),
        ('name = "a"\n[feet]\n"1" = "home"\n[left_foot]\n"1" = "out 3"', 5, "left_foot.1", "one of the two"),
        ('name = "a"\n[feet]\n"1" = "home"\n"1.01" = "out 3"', 4, "left_foot", "leave one"),
        ('name = "a"\n[feet]\n"1" = "home"\n"4.97" = "out 3"', 3, "left_foot", "leave one"),
        ('name = "a"\n[body]\n"1" = "turn left 90"', 3, "body", "after count 1"),
        ('name = "a"\nalternate = true\n[body]\n"2" = "turn left 90"', 3, "body", "pelvis"),
        ('name = "a"\nalternate = true\n[pelvis]\n"3" = "up 3"', 4, "pelvis.3", "counts"),
        ('name = "a"\ncyclic = false\n[pelvis]\n"4.9" = "up 3"', 4, "pelvis", "1e"),
        ('name = "a"\ncyclic = false\n[pelvis]\n"1" = "up 3"', 4, "pelvis", "4a"),
        ('name = "a"\ntravels = true', 2, "travels", "lift"),
        ('name = "a"\ntravels = true\ncyclic = false', 3, "cyclic", "leave out"),
        (
            'name = "a"\ntravels = true\n[body]\n"3" = "turn left 90"\n[feet]\n"1" = "home, lift 3"',
            4,
            "body",
            "360",
        ),
    ],
)
def test_each_error_names_line_field_and_remedy(text: str, line: int, field: str, says: str) -> None:
    with pytest.raises(SketchError) as caught:
        parse_sketch(text, "steps/bad.toml")
    error = caught.value
    assert (error.line, error.field) == (line, field)
    assert says in error.remedy or says in error.problem
    assert str(error) == f"steps/bad.toml:{line}: {field}: {error.problem}; {error.remedy}"
    assert "\n" not in str(error)


def test_too_many_keys_and_overlong_files_are_refused() -> None:
    counts = " ".join(f"{1 + number / 10:.1f}" for number in range(MAX_KEYS + 1))
    with pytest.raises(SketchError, match="fewer counts"):
        parse_sketch(f'name = "a"\nbeats = 16\n[pelvis]\n"{counts}" = "up 1"', "long.toml")
    with pytest.raises(SketchError, match="characters"):
        parse_sketch("#" * 300_000, "long.toml")
