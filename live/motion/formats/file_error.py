"""The error that all motion file readers raise, and helpers to read numbers and to count lines of text files."""

import math
import re
from typing import Final

MAGNITUDE_LIMIT: Final = 1e7
"""Largest allowed offset, position or angle; larger values indicate a broken file and would overflow later."""
NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)


class MotionFileError(ValueError):
    """A motion file that cannot be used; the message is one line with file, line, problem and expected content.

    `line` counts from 1; it is None for binary files.
    """

    def __init__(self, file: str, line: int | None, problem: str, expected: str) -> None:
        self.file, self.line, self.problem, self.expected = file, line, problem, expected
        place = file if line is None else f"{file}, line {line}"
        super().__init__(f"{place}: {problem}; {expected}")


def quoted(text: str) -> str:
    """Return the text quoted and shortened for a one-line message."""
    return ascii(text if len(text) <= 40 else text[:37] + "...")


def read_number(text: str, file: str, line: int, what: str) -> float:
    """Return a finite number of at most MAGNITUDE_LIMIT; raises MotionFileError otherwise."""
    if not NUMBER.fullmatch(text):
        raise MotionFileError(file, line, f"{quoted(text)} as {what} is not a number", "a decimal number expected")
    value = float(text)
    if not math.isfinite(value) or abs(value) > MAGNITUDE_LIMIT:
        raise MotionFileError(file, line, f"{what} {quoted(text)} is out of range", "at most 1e7 expected")
    return value


def count_line_ends(data: bytes, start: int, end: int) -> int:
    """Return how many lines end in data[start:end], with LF, CR or both; the range must not split a CR LF."""
    ends = data.count(b"\n", start, end) + data.count(b"\r", start, end)
    return ends - data.count(b"\r\n", start, end)
