"""Release of OpenGL objects."""

from typing import Protocol


class Releasable(Protocol):
    """An owner of OpenGL objects."""

    def release(self) -> None:
        """Free them."""


def release_all(*things: Releasable) -> None:
    """Free all of them, in order."""
    for thing in things:
        thing.release()
