"""Errors that a person can put right: one line that says what is wrong, and what to do about it."""

from collections.abc import Iterator
from contextlib import contextmanager

from live.base.printable import printable


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
