"""Mailbox: the latest value of each continuous control (faders, sensors, a dragged attractor)."""

from collections.abc import Hashable
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


class Mailbox(Generic[Key, Value]):
    """Keeps the last value per key, at most `capacity` keys; a value not yet read is overwritten.

    Thread: `post` from any thread, `collect` from the reader only. A flood on one fader costs one entry.
    """

    def __init__(self, capacity: int = 1024) -> None:
        self._values: dict[Key, Value] = {}
        self._capacity = capacity
        self.refused = 0

    def post(self, key: Key, value: Value) -> None:
        """Put the newest value of `key`; a new key beyond the capacity is refused and counted."""
        if key not in self._values and len(self._values) >= self._capacity:
            self.refused += 1
            return
        self._values[key] = value

    def collect(self) -> list[tuple[Key, Value]]:
        """Take all values posted since the last call, in the order their keys first came."""
        taken: list[tuple[Key, Value]] = []
        for key in list(self._values):
            taken.append((key, self._values.pop(key)))
        return taken
