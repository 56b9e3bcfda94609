"""The sound of each channel beyond its program: level, tuning, filter, vibrato: what a mixing desk and hands change."""

from random import Random
from typing import NamedTuple

COARSE, FINE, CUTOFF, ATTENUATION = 51, 52, 8, 48
"""Numbers of SoundFont generators."""


class Control(NamedTuple):
    """A controller (`cc`) or an offset of a SoundFont generator (`gen`) of a channel."""

    kind: str
    channel: int
    number: int
    value: float


def tone(rng: Random, channels: list[int]) -> list[Control]:
    """Controls for a piece: a mix for all, a tuning of the whole, darker or detuned sounds for some."""
    found = []
    tuning = rng.gauss(0, 12) if rng.random() < 0.7 else rng.uniform(-50, 50)
    for channel in sorted(set(channels)):
        found.append(Control("cc", channel, 7, min(127, max(50, round(rng.gauss(100, 13))))))
        if channel == 9:
            if rng.random() < 0.6:
                found.append(Control("gen", channel, COARSE, rng.choice([-5, -4, -3, -2, -1, 1, 2, 3])))
                found.append(Control("gen", channel, FINE, rng.uniform(-50, 50)))
        else:
            found.append(Control("gen", channel, FINE, tuning + rng.gauss(0, 3)))
            if rng.random() < 0.2:
                found.append(Control("cc", channel, 1, rng.randrange(10, 80)))
        if rng.random() < 0.2:
            found.append(Control("gen", channel, CUTOFF, -rng.uniform(500, 5500)))
    return found
