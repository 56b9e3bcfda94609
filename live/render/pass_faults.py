"""PassFaults: a pass that cannot be drawn costs one frame, then it is left out and the picture goes on without it.

A circuit breaker for each pass, as `live/show/circuit_breakers.py` has them for the stages of a tick. It is no part of
the show's state: what is drawn changes nothing in the dance.
"""

from collections.abc import Iterable, Iterator
from typing import Final, TypeVar

IN_A_ROW: Final = 2
"""So many frames in a row end in the same pass until it is left out."""
PASS: Final = "pass "
"""Before the name of a pass where it stands beside the stages of a tick."""

Drawn = TypeVar("Drawn", bound=object)


class PassFaults:
    """Of one pipeline. Thread: the one that draws."""

    def __init__(self) -> None:
        self.out: dict[str, str] = {}
        """Why each pass that is left out is, by its name."""
        self._running = ""
        self._last = ""
        self._count = 0

    def may(self, name: str) -> bool:
        """A pass begins that can be left out: whether it is drawn."""
        self._running = name
        return name not in self.out

    def each(self, passes: Iterable[Drawn]) -> Iterator[Drawn]:
        """Passes one after the other; what fails until the next one is asked for is this one's fault."""
        for one in passes:
            self._running = name_of(one)
            yield one
        self._running = ""

    def essential(self) -> None:
        """What is drawn now cannot be left out."""
        self._running = ""

    def failed(self, error: Exception) -> None:
        """The frame could not be drawn."""
        self._count = self._count + 1 if self._last == self._running else 1
        self._last = self._running
        if self._running and self._count >= IN_A_ROW:
            self.out[self._running] = f"{type(error).__name__}: {error}"[:200]

    def drawn(self) -> None:
        """The frame was drawn to its end."""
        self._count = 0

    def reset(self, name: str) -> None:
        """Draw a pass again, as it is called in `words`; empty: all."""
        if not name:
            self.out.clear()
        self.out.pop(name.removeprefix(PASS), None)

    def words(self) -> list[str]:
        """What is left out, for the operator."""
        return [
            f'{PASS}{name} is left out ({why}); /dance/breaker/reset "{PASS}{name}" draws it again'
            for name, why in self.out.items()
        ]


def name_of(drawn: object) -> str:
    """The name of a pass of the scene: that of its class."""
    return type(drawn).__name__.removesuffix("Pass").lower()
