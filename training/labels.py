"""What a network should say of each frame of a recording: beat, downbeat, and where in the beat and measure it lies."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.tracking.beat_network import DELAY
from live.clock.tracking.features import HOP
from training.features import Item

Floats = npt.NDArray[np.float32]

ATTACK: Final = 0.020
"""A beat's sound rises steepest in the frame that ends so long after it [s]: a stretch turns about this point."""

WIDTH: Final = 2.0
"""Frames over which a beat's label falls to 0 on either side."""

IGNORED: Final = 0.3
"""How much frames count that nobody can name beats in (stops): there the network should say nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Labels:
    """Targets of frames, T of them."""

    classes: Floats
    """Shares of nothing, beat (no downbeat) and downbeat, sum 1, shape (T, 3)."""
    phases: Floats
    """Cosine and sine of the phase in the beat, then in the measure, shape (T, 4)."""
    known: Floats
    """How well beats, downbeats, beat phase and measure phase are known, 0 to 1, shape (T, 4)."""


def measures(item: Item) -> npt.NDArray[np.float64]:
    """Each beat's position counted in measures (a downbeat is a whole number), shape (n,); NaN where unknown."""
    places = item.places.astype(np.float64)
    position = np.full(places.size, np.nan)
    downbeats = np.flatnonzero(places == 1)
    if downbeats.size == 0 or (places <= 0).any() or not item.facts.get("has_downbeat", True):
        return position
    lengths = np.diff(downbeats)
    first = lengths[0] if lengths.size else int(places.max())
    last = lengths[-1] if lengths.size else int(places.max())
    for beat in range(places.size):
        index = int(np.searchsorted(downbeats, beat, side="right")) - 1
        if index < 0:
            position[beat] = (beat - downbeats[0]) / max(first, int(places.max()))
        elif index >= lengths.size:
            position[beat] = index + (beat - downbeats[index]) / last
        else:
            position[beat] = index + (beat - downbeats[index]) / lengths[index]
    return position


def label(item: Item, first: float, step: float, count: int) -> Labels:
    """Targets of `count` frames that lie at first, first + step … in the recording's own frames.

    `step` is how much faster the music goes than it was recorded.
    """
    classes = np.zeros((count, 3), np.float32)
    phases = np.zeros((count, 4), np.float32)
    known = np.zeros((count, 4), np.float32)
    beats = item.beats
    if beats.size < 2:
        classes[:, 0] = 1.0
        known[:, :2] = 1.0
        return Labels(classes, phases, known)
    late = (DELAY - ATTACK) / HOP
    at = ((beats + ATTACK) / HOP - 1.0 - first) / step + late  # the frame that speaks of each beat
    downbeat = item.places == 1
    for centre, down in zip(at, downbeat, strict=True):
        low, high = max(int(np.ceil(centre - WIDTH)), 0), min(int(np.floor(centre + WIDTH)) + 1, count)
        if low < high:
            share = 1.0 - np.abs(np.arange(low, high) - centre) / WIDTH
            column = 2 if down else 1
            classes[low:high, column] = np.maximum(classes[low:high, column], share)
    classes[:, 1] = np.minimum(classes[:, 1], 1.0 - classes[:, 2])
    classes[:, 0] = 1.0 - classes[:, 1] - classes[:, 2]
    frames = np.arange(count, dtype=np.float64)
    number = np.interp(frames, at, np.arange(beats.size))
    inside = (frames >= at[0]) & (frames <= at[-1])
    known[:, 0] = 1.0
    known[:, 2] = inside
    position = measures(item)
    if np.isfinite(position).all():
        known[:, 1] = known[:, 0]
        known[:, 3] = inside
        measure = np.interp(frames, at, position)
        phases[:, 2] = np.cos(2 * np.pi * measure)
        phases[:, 3] = np.sin(2 * np.pi * measure)
    phases[:, 0] = np.cos(2 * np.pi * number)
    phases[:, 1] = np.sin(2 * np.pi * number)
    for low, high in item.facts.get("ignore", []):
        low_at, high_at = ((edge / HOP - 1.0 - first) / step + late for edge in (low, high))
        stopped = (frames > low_at) & (frames < high_at)
        known[stopped, :2] *= IGNORED
        known[stopped, 2:] = 0.0
    return Labels(classes, phases, known)
