"""Tests of the sketch notation: counts and phrases."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.sketch.sketch_notation import PARTS, NotationError, read_counts, read_phrases


@pytest.mark.parametrize(
    ("text", "beats"),
    [
        ("1", [0.0]),
        ("4", [3.0]),
        ("2&", [1.5]),
        ("1e", [0.25]),
        ("3a", [2.75]),
        ("2.33", [1.33]),
        ("1 2 3& 4a", [0.0, 1.0, 2.5, 3.75]),
        ("1, 2,3", [0.0, 1.0, 2.0]),
    ],
)
def test_counts_are_read_as_beats(text: str, beats: list[float]) -> None:
    assert read_counts(text, 4.0) == pytest.approx(beats)


@pytest.mark.parametrize("text", ["", "0", "5", "1b", "&", "-1", "1..5", "nan", "1e5", "one", "4.99999999999", "1 x"])
def test_invalid_counts_are_refused(text: str) -> None:
    with pytest.raises(NotationError):
        read_counts(text, 4.0)


def test_sides_are_relative_to_dancer() -> None:
    assert read_phrases("left 10", "left_foot", PARTS["left_foot"]) == {"out": pytest.approx(0.1)}
    assert read_phrases("left 10", "right_foot", PARTS["right_foot"]) == {"out": pytest.approx(-0.1)}
    assert read_phrases("out 10", "right_foot", PARTS["right_foot"]) == {"out": pytest.approx(0.1)}
    assert read_phrases("right 4", "pelvis", PARTS["pelvis"]) == {"left": pytest.approx(-0.04)}


def test_phrases_are_converted_to_meters_and_radians() -> None:
    amounts = read_phrases("down 6,  turn left 90 ,lean back 4.5", "pelvis", PARTS["pelvis"])
    assert amounts == {
        "up": pytest.approx(-0.06),
        "turn": pytest.approx(math.pi / 2),
        "lean": pytest.approx(math.radians(-4.5)),
    }


def test_flags_take_no_number() -> None:
    assert read_phrases("home, lift 3", "left_foot", PARTS["left_foot"]) == {"home": 1.0, "lift": pytest.approx(0.03)}


@pytest.mark.parametrize(
    ("text", "part", "says"),
    [
        ("don 6", "pelvis", "down"),
        ("down", "pelvis", "how much"),
        ("down x", "pelvis", "number"),
        ("down nan", "pelvis", "number"),
        ("down inf", "pelvis", "number"),
        ("down 1e9", "pelvis", "number"),
        ("down 301", "pelvis", "300"),
        ("turn left 181", "pelvis", "180"),
        ("turn left 1081", "body", "1080"),
        ("up 3, down 2", "pelvis", "one of the two"),
        ("", "pelvis", "words"),
        ("up 3,", "pelvis", "words"),
        ("heel 3", "left_hand", "words"),
        ("home 3", "left_foot", "words"),
        ("rest, up 3", "left_hand", "leave out"),
        ("home, out 3", "left_foot", "leave out"),
        ("up -3", "left_foot", "from 0"),
        ("up 3, touch", "left_foot", "one of them"),
        ("heel 3, toe 2", "left_foot", "one of them"),
    ],
)
def test_each_phrase_error_names_remedy(text: str, part: str, says: str) -> None:
    with pytest.raises(NotationError) as caught:
        read_phrases(text, part, PARTS[part])
    assert says in caught.value.remedy
    assert caught.value.problem


@given(st.sampled_from(sorted(PARTS)), st.text(max_size=30))
def test_any_text_is_read_or_refused(part: str, text: str) -> None:
    try:
        amounts = read_phrases(text, part, PARTS[part])
    except NotationError:
        return
    assert all(math.isfinite(amount) for amount in amounts.values())
