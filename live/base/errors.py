"""Errors that a user can correct: one line with the fault and a remedy.

Text from files and networks is made safe to print: control characters and invisible characters are escaped.
"""

import re
from typing import Final

_UNPRINTABLE: Final = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""Control characters except tab and line end, bidirectional marks, and surrogates."""


def printable(text: str) -> str:
    """Return the text with those characters escaped as in a Python string: the escape character as the four of
    `\\x1b`."""
    return _UNPRINTABLE.sub(lambda found: ascii(found.group())[1:-1], text)


class PersonError(Exception):
    """An error that the command line shows without a traceback (exit code 2).

    `message` is one line: the value read and the values allowed. `remedy`, if any, is what to type or change.
    Control characters are escaped in both.
    `key_path` are the keys that lead to the value, ("segment", 3, "formation"), from which callers can find its line.
    `faults`, if there are several, are those of which the message tells in one line; a terminal lists them.
    """

    def __init__(
        self,
        message: str,
        remedy: str | None = None,
        key_path: tuple[str | int, ...] = (),
        faults: tuple[str, ...] = (),
    ) -> None:
        super().__init__(message)
        self.message = printable(message)
        self.remedy = None if remedy is None else printable(remedy)
        self.key_path = key_path
        self.faults = tuple(map(printable, faults))

    def __str__(self) -> str:
        return self.message if self.remedy is None else f"{self.message} ({self.remedy})"


class _ErrorContext:
    """Context manager of `error_context`; as a class it costs a third of a generator, and long scores enter many."""

    __slots__ = ("_key_path", "_where")

    def __init__(self, where: str, key_path: tuple[str | int, ...]) -> None:
        self._where, self._key_path = where, key_path

    def __enter__(self) -> None:
        pass

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        if isinstance(error, PersonError):
            message, key_path = f"{self._where}: {error.message}", (*self._key_path, *error.key_path)
            faults = tuple(f"{self._where}: {fault}" for fault in error.faults)
            raise PersonError(message, error.remedy, key_path, faults) from None


def error_context(where: str, key_path: tuple[str | int, ...] = ()) -> _ErrorContext:
    """Prefix the messages of errors raised in a `with` block with `where`; `key_path` are the keys that lead there."""
    return _ErrorContext(where, key_path)
