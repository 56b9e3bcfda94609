"""The text of a TOML file as plain values, whoever wrote it: what `tomllib` stumbles over is no valid TOML either."""

import re
import tomllib
from collections.abc import Iterator
from typing import Any, Final

MOST_KEYS: Final = 32
"""Keys joined by dots at most: `tomllib` takes the square of their number, and who walks the tables goes as deep."""
_JOINED: Final = re.compile(
    r"""(?<![\w.'"-])(?:(?:"[^"\n]*"|'[^'\n]*'|[A-Za-z0-9_-]++)[ \t]*+\.[ \t]*+){""" + str(MOST_KEYS) + "}"
)
_DIGITS: Final = re.compile(r"[0-9][0-9_]{3999}|0[xob][0-9A-Fa-f_]{17}")
"""A number that `int` refuses to read, or one that it refuses to write again."""


def toml_values(text: str) -> dict[str, Any]:
    """What a text says; tomllib.TOMLDecodeError, with the line in its message, for all that cannot be used.

    RecursionError for brackets in brackets without end.
    """
    joined = _JOINED.search(text)
    if joined is not None:
        raise _error(f"More than {MOST_KEYS} keys joined by dots", text, joined)
    number = _DIGITS.search(text)
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:  # int() takes no more than 4,300 digits
        raise _error("Number with too many digits", text, number) from None
    if number is not None and any(abs(each) >> 64 for each in _whole_numbers(values)):
        raise _error("Number with too many digits", text, number)
    return values


def _whole_numbers(values: object) -> Iterator[int]:
    """All whole numbers within tables and lists."""
    waiting = [values]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
        elif isinstance(value, int):
            yield value


def _error(words: str, text: str, found: re.Match[str] | None) -> tomllib.TOMLDecodeError:
    line = 1 if found is None else text.count("\n", 0, found.start()) + 1
    return tomllib.TOMLDecodeError(f"{words} (at line {line}, column 1)")
