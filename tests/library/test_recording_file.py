"""Error messages for invalid fields of a recording, in plain words for every field and kind of value."""

import re

import pytest
from pydantic import ValidationError

from live.library.recording_file import Recording, expected_text, problem_text

RIGHT = {"file": "a.bvh", "name": "a", "bpm": 120, "first_beat_s": 0}
WRONG = (None, "", "x" * 2000, 0, -1, 10**12, 1.5, float("nan"), float("inf"), True, [], [1], ["a"] * 100, {}, {"a": 1})
FOREIGN = re.compile(r"input|valid|should|type|pydantic|literal|finite|instance|None", re.IGNORECASE)


@pytest.mark.parametrize("field", list(Recording.model_fields))
def test_every_invalid_value_has_plain_message(field: str) -> None:
    told = 0
    for value in WRONG:
        try:
            Recording.model_validate(RIGHT | {field: value})
        except ValidationError as error:
            for problem in error.errors(include_url=False):
                words = problem_text(problem)
                assert not FOREIGN.search(words.replace("NoneType", "")), words
                assert " expected, found " in words
                assert len(words) < 250
                told += 1
    assert told >= 8


@pytest.mark.parametrize("field", list(Recording.model_fields))
def test_reported_bounds_match_validation(field: str) -> None:
    """The reported bounds are valid, and the values just outside them are refused."""
    bounds = re.fullmatch(r"a (?:whole )?number from ([\d,]+) to ([\d,]+)", expected_text(field))
    if bounds is None:
        return  # a text, a switch, or a number with an open bound: see below
    low, high = (int(number.replace(",", "")) for number in bounds.groups())
    for value in (low, high):
        assert getattr(Recording.model_validate(RIGHT | {field: value}), field) == value
    for value in (low - 1, high + 1):
        with pytest.raises(ValidationError):
            Recording.model_validate(RIGHT | {field: value})


@pytest.mark.parametrize(
    ("field", "words"),
    [
        ("bpm", "a number from 20 to 400"),
        ("measures", "a whole number from 1 to 10,000"),
        ("name", "a text in quotes of 1 to 64 characters"),
        ("leading_foot", '"left" or "right"'),
        ("mirror", "true or false"),
        ("unit_m", "a number above 0 and up to 10"),
        ("up", '"Y" or "Z"'),
        ("direction", "a text in quotes"),
        ("tags", 'a list of at most 64 texts, like ["slow", "low"],'),
    ],
)
def test_expected_text_describes_field(field: str, words: str) -> None:
    assert expected_text(field) == words


def test_unknown_and_missing_keys_are_reported() -> None:
    with pytest.raises(ValidationError) as caught:
        Recording.model_validate({"file": "a.bvh", "name": "a", "bmp": 120})
    words = {problem["loc"][0]: problem_text(problem) for problem in caught.value.errors()}
    assert words["bmp"].startswith("unknown key; did you mean 'bpm'? allowed are file, name")
    assert words["bpm"].startswith("missing; it must be given, as in file =")
