"""Long work in pieces: generators that yield after each piece and return the result, so that no frame waits."""

from collections.abc import Generator
from typing import TypeVar

Result = TypeVar("Result")
Pieces = Generator[None, None, Result]


def at_once(pieces: Pieces[Result]) -> Result:
    """Do all pieces; the result."""
    while True:
        try:
            next(pieces)
        except StopIteration as stop:
            result: Result = stop.value
            return result
