"""Occasions: what is heard in the music as signals by name: it becomes louder, a build-up begins, a drop (T016)."""

from collections.abc import Iterable
from typing import Final

from live.control.events.events import MusicHeard
from live.show.patch.score import SignalSection
from live.show.score.mood import level_of

MUCH: Final = 0.75
LITTLE: Final = 0.25
BUILDING: Final = 0.5
BACK: Final = 0.1
"""A level that was passed counts again once it has been left by so much; a build-up by three times as much."""
_HEARD: Final = {
    "build": ("build", True, BUILDING),
    "loud": ("loudness", True, MUCH),
    "quiet": ("loudness", False, LITTLE),
    "dense": ("density", True, MUCH),
    "sparse": ("density", False, LITTLE),
    "bright": ("brightness", True, MUCH),
    "dark": ("brightness", False, LITTLE),
}


class Occasions:
    """Takes MusicHeard in order. Thread: the show's."""

    def __init__(self, signals: Iterable[SignalSection]) -> None:
        self._signals = [signal for signal in signals if signal.on is not None]
        self._there = [False] * len(self._signals)

    def take_patch(self, fresh: "Occasions") -> None:
        """Listen for the signals of another patch."""
        known = dict(zip(self._signals, self._there, strict=True))
        self._signals = fresh._signals
        self._there = [known.get(signal, False) for signal in self._signals]

    def hear(self, event: MusicHeard) -> list[str]:
        """The names of the signals that one beat of the music gives."""
        names = []
        for index, signal in enumerate(self._signals):
            if signal.on == "drop":
                comes = event.drop
            else:
                name, high, level = _HEARD[signal.on or "build"]
                level = level if signal.level is None else signal.level
                heard = level_of(event, name)
                back = 3.0 * BACK if name == "build" else BACK
                if self._there[index]:
                    is_there = heard > level - back if high else heard < level + back
                else:
                    is_there = heard >= level if high else heard <= level
                comes = is_there and not self._there[index]
                self._there[index] = is_there
            if comes:
                names.append(signal.name)
        return names
