"""Giving GL objects back."""

from typing import Protocol


class Releasable(Protocol):
    """Anything that holds GL objects."""

    def release(self) -> None:
        """Free them."""


def release_all(*things: Releasable) -> None:
    """Free all of them, in order."""
    for thing in things:
        thing.release()
