"""Tests of the number kernel: bit for bit as Python's float, and never more numbers than the text contains."""

import struct

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from live.motion.formats.bvh_numbers import INEXACT_LIMIT, line_at, read_numbers
from live.motion.formats.file_error import MotionFileError

decimals = st.from_regex(r"[+-]?(\d{1,25}\.?\d{0,25}|\.\d{1,25})([eE][+-]?\d{1,3})?", fullmatch=True).filter(
    lambda word: word.isascii()
)
doubles = st.floats(-1e7, 1e7).map(repr) | st.floats(-1e7, 1e7).map(lambda x: f"{x:.17e}")
tiny = st.builds(lambda digits, power: f"{digits}e-{power}", st.integers(0, 10**19 - 1), st.integers(0, 50))


def bits(values: list[float]) -> list[bytes]:
    return [struct.pack("<d", value) for value in values]


@pytest.mark.long
@settings(max_examples=100)
@example(["9007199254740993", "9007199254740992.5", "-0.0", "0e999", "1e-45", "1e-44", "7e-324"])
@example(["1.00000000000000011102230246251565404", "9999999.9999999991", "2.2250738585072011e-308"])
@example([f"{m}e-{k}" for m in (2**53 + 1, 2**53 + 3, 10**19 - 1, 2**63) for k in range(13, 45)])
@given(st.lists(decimals | doubles | tiny, min_size=1, max_size=40))
def test_each_number_is_nearest_double(words: list[str]) -> None:
    words = [word for word in words if abs(float(word)) <= 1e7] or ["0"]
    values = read_numbers(" ".join(words).encode(), 0, len(words), 1, "x")
    assert bits(values[0].tolist()) == bits([float(word) for word in words])


def test_numbers_beyond_inexact_limit_are_exact() -> None:
    rng = np.random.default_rng(4)
    words = [f"{value:.25f}" for value in rng.uniform(-400, 400, INEXACT_LIMIT + 7)]
    values = read_numbers("\n".join(words).encode(), 0, 1, 3, "x")
    assert bits(values[:, 0].tolist()) == bits([float(word) for word in words])
    words[9000] = "1" + "0" * 30
    with pytest.raises(MotionFileError, match=r"line 9001: the number '10+' is not usable"):
        read_numbers("\n".join(words).encode(), 0, 1, 3, "x")


@pytest.mark.parametrize(
    "word",
    ["", "+", "-.", ".", "1e", "1e+", "e5", "--1", "1.2.3", "1,5", "0x1", "1_0", "nan", "inf", "1d3", "9" * 1001],
)
def test_non_decimal_words_are_refused_with_line(word: str) -> None:
    with pytest.raises(MotionFileError) as caught:
        read_numbers(f"1 2\n3 {word}\n4 5".encode(), 0, 2, 3, "x")
    assert caught.value.line == 2


@given(st.lists(st.lists(st.sampled_from(["1", "-2.5", "3e1"]), max_size=5), min_size=1, max_size=8), st.integers(1, 4))
def test_frames_end_at_line_ends(lines: list[list[str]], columns: int) -> None:
    """Against the same rules in Python: whole frames in every line, or each frame begins on a new line."""
    text = "\r\n".join(" ".join(line) for line in lines).encode()
    counts = [len(line) for line in lines if line]
    ends = set(np.cumsum(counts).tolist())
    total = sum(counts)
    whole = all(count % columns == 0 for count in counts)
    wrapped = total % columns == 0 and all(n in ends for n in range(columns, total + 1, columns))
    if total and (whole or wrapped):
        expected = [float(word) for line in lines for word in line]
        assert read_numbers(text, 0, columns, 1, "x").ravel().tolist() == expected
        return
    with pytest.raises(MotionFileError) as caught:
        read_numbers(text, 0, columns, 1, "x")
    if total:
        place = next(n for n, line in enumerate(lines) if len(line) % columns)
        assert caught.value.line == place + 1
        assert caught.value.problem.startswith(f"{len(lines[place])} numbers in this line")
        assert ("cut off" in caught.value.problem) == (not any(lines[place + 1 :]))


def test_lines_end_at_lf_cr_or_crlf() -> None:
    assert [line_at(b"a\nb\r\nc\rd", place) for place in (0, 2, 5, 7)] == [1, 2, 3, 4]


def test_numbers_are_split_at_any_whitespace() -> None:
    assert read_numbers(b"HEAD 1\t2\x0b3\x0c\n\n 4  5 6 ", 5, 3, 9, "x").tolist() == [[1, 2, 3], [4, 5, 6]]
