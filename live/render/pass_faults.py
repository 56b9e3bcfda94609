"""Circuit breakers for render passes: a pass that fails repeatedly is left out.

Similar to `live/show/circuit_breakers.py` for the stages of a tick, but not part of the show's state, because drawing
does not affect the dance.
"""

from collections.abc import Iterable, Iterator
from typing import Final, TypeVar

FAILURE_LIMIT: Final = 2
"""A pass is left out after so many frames in a row have failed in it."""
PASS_PREFIX: Final = "pass "
"""Prefix of a pass's name in lists that also have stages of a tick."""

AnyPass = TypeVar("AnyPass", bound=object)


class PassFaults:
    """Circuit breakers of one pipeline. Thread: the one that draws."""

    def __init__(self) -> None:
        self.disabled: dict[str, str] = {}
        """Passes that are left out, and why, by name."""
        self._running = ""
        self._last = ""
        self._count = 0

    def begin(self, name: str) -> bool:
        """Begin an optional pass; return whether to draw it."""
        self._running = name
        return name not in self.disabled

    def iterate(self, passes: Iterable[AnyPass]) -> Iterator[AnyPass]:
        """Iterate over passes; an error during an iteration is attributed to that pass."""
        for one in passes:
            self._running = pass_name(one)
            yield one
        self._running = ""

    def begin_essential(self) -> None:
        """Begin a pass that cannot be left out."""
        self._running = ""

    def record_failure(self, error: Exception) -> None:
        """Record that the frame could not be drawn."""
        self._count = self._count + 1 if self._last == self._running else 1
        self._last = self._running
        if self._running and self._count >= FAILURE_LIMIT:
            self.disabled[self._running] = f"{type(error).__name__}: {error}"[:200]

    def record_success(self) -> None:
        """Record that the frame was drawn completely."""
        self._count = 0

    def reset(self, name: str) -> None:
        """Enable a pass again, by its name as in `pass_name`; empty: all."""
        if not name:
            self.disabled.clear()
        self.disabled.pop(name.removeprefix(PASS_PREFIX), None)

    def messages(self) -> list[str]:
        """Return messages about passes that are left out, for the operator."""
        return [
            f'{PASS_PREFIX}{name} is left out ({why}); /dance/breaker/reset "{PASS_PREFIX}{name}" draws it again'
            for name, why in self.disabled.items()
        ]


def pass_name(scene_pass: object) -> str:
    """Return the name of a scene pass, which is that of its class."""
    return type(scene_pass).__name__.removesuffix("Pass").lower()
