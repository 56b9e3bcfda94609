"""Rhythm patterns written as text, and random ones weighted by the metrical hierarchy."""

from collections.abc import Mapping
from random import Random

from training.music.piece import Metre

LEVELS = {"X": 1.0, "x": 0.82, "o": 0.62, "-": 0.36, ".": 0.0}

Pattern = list[tuple[float, float]]
"""Hits of one bar or more: position in beats, strength 0..1."""


def parse(text: str, beats: float) -> Pattern:
    """The hits of a line of steps that fill so many beats: X accent, x normal, o soft, - ghost, . none."""
    text = text.replace(" ", "").replace("|", "")
    step = beats / len(text)
    return [(index * step, LEVELS[mark]) for index, mark in enumerate(text) if mark != "."]


def rotate(pattern: Pattern, by: float, beats: float) -> Pattern:
    """The pattern begun elsewhere."""
    return sorted(((position + by) % beats, strength) for position, strength in pattern)


def weave(rng: Random, metre: Metre, density: float, fineness: int = 2, bias: float = 1.0) -> Pattern:
    """A random bar: each place of the grid sounds with a chance and strength by its metrical weight.

    `density` 0..1; `fineness` steps per part of the beat; `bias` 1 follows the metre, 0 ignores it, -1 goes against it.
    """
    steps = metre.beats * metre.div * (fineness if fineness > 1 else 1)
    hits = []
    for step in range(steps):
        position = step * metre.beats / steps
        weight = metre.strength(position) / 4
        chance = density * (1 - abs(bias) + abs(bias) * (weight if bias > 0 else 1 - weight) * 1.6)
        if rng.random() < chance:
            hits.append((position, 0.45 + 0.35 * weight * max(0.0, bias) + 0.2 * rng.random()))
    return hits or [(0.0, 0.8)]


def vary(rng: Random, pattern: Pattern, drop: float = 0.06, strong: float = 0.0) -> Pattern:
    """The pattern with some of its weaker hits left out."""
    return [(at, level) for at, level in pattern if rng.random() > (drop if level < 0.9 else strong)]


def bar_of(pattern: Pattern, bar: int, bars: int, beats: int) -> Pattern:
    """One bar's hits of a pattern that lasts several."""
    start = (bar % bars) * beats
    return [(at - start, level) for at, level in pattern if start - 1e-6 <= at < start + beats - 1e-6]


Lanes = Mapping[str, str]
"""Drum (or pitch) name to its line of steps."""
