"""Motion beats against the music's beats, and against chance: the same motion beats with the music moved.

Dancers who stop often are near a beat often. What their beat alignment says is seen only beside the alignment of the
same stops with beats at any other phase.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.quality.metrics import beat_alignment, beat_offsets

SHIFTS: Final = 32
"""Shifts of the music, evenly over a beat."""


@dataclass(frozen=True, slots=True, eq=False)
class BeatFigures:
    """How near the dancers' motion beats are to the music's beats, and how near by chance."""

    offset: Float64
    """From each beat to the nearest motion beat [s], of all dancers, (n,)."""
    chance_offset: Float64
    """The same from the beats of all shifts, (SHIFTS n,)."""
    alignment: dict[str, float | None]
    """`music` and `kinematic`: `beat_alignment` of the music's beats and of the motion's, mean of the dancers;
    `music_chance`, `kinematic_chance`: the mean of the same over all shifts; `music_ratio`, `kinematic_ratio`: divided
    by it, 1 by chance. None where there is nothing to compare."""


def compare_with_chance(beats: Float64, motion: Sequence[Float64]) -> BeatFigures:
    """Compare the `motion` beats of each dancer, (m,) [s], with the music's `beats` (n,) [s], ascending.

    `kinematic` is the beat alignment score of AIST++ (Li et al. 2021, "AI Choreographer"), `music` that of Bailando
    (Siyao et al. 2022). At chance, `kinematic` is nearly sqrt(2 pi) σ / T for beats of T seconds: 0.25 at 120
    bpm. m stops at random phases then have a `kinematic_ratio` of 1 with a standard deviation of 1.35 / sqrt(m).
    Chance is None for fewer than two beats, or if no dancer has a motion beat.
    """
    known = len(beats) > 1 and any(len(own) for own in motion)
    shifted = [shift_beats(beats, (n + 0.5) / SHIFTS - 0.5) for n in range(SHIFTS)] if known else []
    every = np.concatenate(shifted) if known else np.zeros(0)
    music = _mean([beat_alignment(beats, own) for own in motion])
    music_chance = _mean([beat_alignment(every, own) for own in motion])
    kinematic = _mean([beat_alignment(own, beats) for own in motion])
    kinematic_chance = _mean([beat_alignment(own, each) for own in motion for each in shifted])
    return BeatFigures(
        offset=np.concatenate([np.zeros(0), *(beat_offsets(beats, own) for own in motion)]),
        chance_offset=np.concatenate([np.zeros(0), *(beat_offsets(every, own) for own in motion)]),
        alignment={
            "music": music,
            "music_chance": music_chance,
            "music_ratio": _ratio(music, music_chance),
            "kinematic": kinematic,
            "kinematic_chance": kinematic_chance,
            "kinematic_ratio": _ratio(kinematic, kinematic_chance),
        },
    )


def shift_beats(beats: Float64, phase: float) -> Float64:
    """Return at least two `beats` (n,) [s], ascending, moved by `phase` of a beat, -1 to 1: forwards a part of the way
    to the next beat, backwards to the one before; the first and last as far as their neighbours."""
    way = np.diff(beats)
    way = np.append(way, way[-1]) if phase > 0.0 else np.insert(way, 0, way[0])
    return np.asarray(beats + phase * way, np.float64)


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _ratio(found: float | None, chance: float | None) -> float | None:
    return found / chance if found is not None and chance else None
