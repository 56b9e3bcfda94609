"""Circuit breakers for render passes: a pass that fails repeatedly is left out.

Similar to `live/show/circuit_breakers.py` for the stages of a tick, but not part of the show's state, because drawing
does not affect the dance.
"""

from collections.abc import Iterable, Iterator
from typing import Final, TypeVar

IN_A_ROW: Final = 2
"""A pass is left out after so many frames in a row have failed in it."""
PASS: Final = "pass "
"""Prefix of a pass's name in lists that also have stages of a tick."""

Drawn = TypeVar("Drawn", bound=object)


class PassFaults:
    """Circuit breakers of one pipeline. Thread: the one that draws."""

    def __init__(self) -> None:
        self.out: dict[str, str] = {}
        """Passes that are left out, and why, by name."""
        self._running = ""
        self._last = ""
        self._count = 0

    def may(self, name: str) -> bool:
        """Begin an optional pass; return whether to draw it."""
        self._running = name
        return name not in self.out

    def each(self, passes: Iterable[Drawn]) -> Iterator[Drawn]:
        """Iterate over passes; an error during an iteration is attributed to that pass."""
        for one in passes:
            self._running = name_of(one)
            yield one
        self._running = ""

    def essential(self) -> None:
        """Begin a pass that cannot be left out."""
        self._running = ""

    def failed(self, error: Exception) -> None:
        """Record that the frame could not be drawn."""
        self._count = self._count + 1 if self._last == self._running else 1
        self._last = self._running
        if self._running and self._count >= IN_A_ROW:
            self.out[self._running] = f"{type(error).__name__}: {error}"[:200]

    def drawn(self) -> None:
        """Record that the frame was drawn completely."""
        self._count = 0

    def reset(self, name: str) -> None:
        """Enable a pass again, by its name as in `words`; empty: all."""
        if not name:
            self.out.clear()
        self.out.pop(name.removeprefix(PASS), None)

    def words(self) -> list[str]:
        """Return messages about passes that are left out, for the operator."""
        return [
            f'{PASS}{name} is left out ({why}); /dance/breaker/reset "{PASS}{name}" draws it again'
            for name, why in self.out.items()
        ]


def name_of(drawn: object) -> str:
    """Return the name of a scene pass, which is that of its class."""
    return type(drawn).__name__.removesuffix("Pass").lower()
