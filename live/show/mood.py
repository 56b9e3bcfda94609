"""Mood: what the music has been like over the last beats, for whoever improvises to it."""

import math
from typing import Final

from live.control.events import MusicHeard

DENSE: Final = 6.0
"""Onsets per beat that count as 1."""
BEATS: Final = 4.0
"""Beats over which it is smoothed."""
NAMES: Final = ("loudness", "density", "brightness", "low", "build")


def level_of(event: MusicHeard, name: str) -> float:
    """What is heard by this name of `NAMES`, 0 to 1."""
    return min(event.density / DENSE, 1.0) if name == "density" else float(getattr(event, name))


class Mood:
    """Takes MusicHeard in order. Before any is heard, or once nothing is, it is in the middle: 0.5, and no build-up."""

    def __init__(self) -> None:
        self._values = {**dict.fromkeys(NAMES, 0.5), "build": 0.0}
        self._heard = False

    def hear(self, event: MusicHeard) -> None:
        """One beat of the music."""
        share = 1.0 - math.exp(-1.0 / BEATS) if self._heard else 1.0
        self._heard = True
        for name in NAMES:
            self._values[name] += share * (level_of(event, name) - self._values[name])

    def of(self, name: str) -> float:
        """What is heard by this name, 0 to 1; `energy` is the mean of loudness and density."""
        if name == "energy":
            return 0.5 * (self._values["loudness"] + self._values["density"])
        return self._values[name]
