"""MotionFileError: what every reader of motion files raises, and what it says of broken numbers."""

import math
import re
from typing import Final

MAGNITUDE_LIMIT: Final = 1e7
"""Largest offset, position or angle that a file may hold; more is a broken file, and would overflow later."""
NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)


class MotionFileError(ValueError):
    """A motion file that cannot be used; the message is one line with file, line, problem and what is expected.

    `line` counts from 1; it is None where the file is not a text.
    """

    def __init__(self, file: str, line: int | None, problem: str, expected: str) -> None:
        self.file, self.line, self.problem, self.expected = file, line, problem, expected
        place = file if line is None else f"{file}, line {line}"
        super().__init__(f"{place}: {problem}; {expected}")


def shown(text: str) -> str:
    """What was read, in quotes and short enough for a message of one line."""
    return ascii(text if len(text) <= 40 else text[:37] + "...")


def read_number(text: str, file: str, line: int, what: str) -> float:
    """A finite number of reasonable size; raises MotionFileError otherwise."""
    if not NUMBER.fullmatch(text):
        raise MotionFileError(file, line, f"{shown(text)} as {what} is not a number", "a decimal number expected")
    value = float(text)
    if not math.isfinite(value) or abs(value) > MAGNITUDE_LIMIT:
        raise MotionFileError(file, line, f"{what} {shown(text)} is out of range", "at most 1e7 expected")
    return value
