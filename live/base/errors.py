"""Errors that a person can put right: one line that says what is wrong, and what to do about it.

Words from files and networks as they may be printed: what a terminal would obey, or nobody sees, is spelled out.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

_OBEYED: Final = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""Control characters but for tab and line end, marks that turn the direction of writing, and halves of characters."""


def printable(text: str) -> str:
    """The text with each of those as a Python string would show it: the escape character as the four of `\\x1b`."""
    return _OBEYED.sub(lambda found: ascii(found.group())[1:-1], text)


class PersonError(Exception):
    """What the command line shows in place of a traceback (exit code 2).

    `message` is one line: what was read and what is allowed. `remedy`, if there is one, is what to type or change.
    What a terminal would obey is spelled out in both.
    `place` are the keys under which it stands in what was read, ("segment", 3, "formation"), for whoever knows lines.
    """

    def __init__(self, message: str, remedy: str | None = None, place: tuple[str | int, ...] = ()) -> None:
        super().__init__(message)
        self.message = printable(message)
        self.remedy = None if remedy is None else printable(remedy)
        self.place = place

    def __str__(self) -> str:
        return self.message if self.remedy is None else f"{self.message} ({self.remedy})"


@contextmanager
def named(where: str, place: tuple[str | int, ...] = ()) -> Iterator[None]:
    """Whatever a person is told from within begins with where it is; `place` are the keys that lead there."""
    try:
        yield
    except PersonError as error:
        raise PersonError(f"{where}: {error.message}", error.remedy, (*place, *error.place)) from None
