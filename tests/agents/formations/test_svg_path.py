"""SVG paths against svgpathtools, to the last bit."""

import warnings

import numpy as np
import pytest
import svgpathtools

from live.agents.formations.svg_path import read_path

ARGUMENTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "Z": 0, "A": 7}
SHARES = [number / 24 for number in range(1, 25)]


def random_path(draw: np.random.Generator) -> str:
    words = ["M 1 2"]
    for letter in draw.choice(list("MLHVCSQTAmlhvcsqtaZ"), draw.integers(1, 9)):
        words.append(letter)
        if words[-2] == "Z":
            words.insert(-1, "M 3 -1")
        for _ in range(draw.integers(1, 3) if letter != "Z" else 0):
            numbers = [f"{number:.3g}" for number in draw.normal(0.0, 4.0, ARGUMENTS[letter.upper()])]
            if letter in "Aa":
                numbers[3:5] = map(str, draw.integers(0, 2, 2))
            words += numbers
    return " ".join(words)


def same_points(d: str) -> int:
    """Compare both readings of a path; return the number of its segments."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        expected = svgpathtools.parse_path(d)
        segments = read_path(d)
        assert len(segments) == len(expected)
        for segment, other in zip(segments, expected, strict=True):
            assert (segment.start, segment.end) == (other.start, other.end), d
            assert (segment.point is None) == isinstance(other, svgpathtools.Line)
            if segment.point is not None:
                assert [segment.point(share) for share in SHARES] == [other.point(share) for share in SHARES], d
    return len(segments)


def test_random_paths_have_the_same_points():
    draw = np.random.default_rng(7)
    assert sum(same_points(random_path(draw)) for _ in range(400)) > 1500


@pytest.mark.parametrize(
    "d",
    [
        "M -2 0 A 2 2 0 0 1 2 0 A 2 2 0 0 1 -2 0 Z",
        "M0,0 1,1-1.5.5l1e1-2",
        "M0 0a1 1 0 01.5.5 2 2 30 11 1 0",
        "M 0 0 A 0 3 0 0 1 2 0",
        "M 0 0 A 1 1 45 1 0 9 3",
        "m 1 1 2 0 0 2 z m 5 5 h 1 v 1 z",
        "M 0 0 T 3 0 5 5 S 1 1 2 2 T 0 1",
    ],
)
def test_notations_are_read_in_the_same_way(d):
    assert same_points(d)


@pytest.mark.parametrize(
    ("d", "words"),
    [
        ("1 2", "without a command"),
        ("M 1", "M takes 2 numbers, not 1"),
        ("M 0 0 L", "L takes 2 numbers, not 0"),
        ("M 0 0 L 1 2 3", "L takes 2 numbers, not 3"),
        ("M 0 0 C 1 2 3 4", "C takes 6"),
        ("M 0 0 Z 1 1", "numbers after Z"),
        ("Z", "closed before"),
        ("M 1 1 A 1 1 0 0 0 1 1", "ends where it starts"),
    ],
)
def test_what_is_no_path_is_refused(d, words):
    with pytest.raises(ValueError, match=words):
        read_path(d)
