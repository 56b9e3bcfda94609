"""The amounts of a sketch's keys as smooth functions of musical time."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.curve import hermite, monotone_slopes, repeated, smoothed, through
from live.motion.sketch.sketch_file import Key, Sketch

Float = npt.NDArray[np.floating]

SAMPLES_PER_BEAT: Final = 32
_SOFT: Final = 0.05 * SAMPLES_PER_BEAT
"""Rounds the accelerations of a key without moving it in time (standard deviation, in samples)."""


class Channels:
    """The amounts of one part at `beats` (T,), by channel; a channel that no line names is all zero."""

    def __init__(self, sketch: Sketch, part: str, beats: Float) -> None:
        self.keys = sketch.parts.get(part, ())
        self.sketch = sketch
        self.beats = beats
        self.named = {name for key in self.keys for name in key.amounts} - {"neutral"}

    def __getitem__(self, channel: str) -> Float:
        if channel not in self.named:
            return np.zeros(len(self.beats))
        keys = [(key.beat, key.amounts.get(channel, 0.0)) for key in self.keys if _says(key, channel)]
        times, values = closed(self.sketch, keys, self.beats)
        return smoothed(through(times, values, self.beats), _SOFT)


def _says(key: Key, channel: str) -> bool:
    return channel in key.amounts or "neutral" in key.amounts


def closed(sketch: Sketch, keys: list[tuple[float, float]], beats: Float) -> tuple[Float, Float]:
    """Times and values of keys (beat, amount) repeated over `beats`, or led from zero and back if not cyclic."""
    if sketch.cyclic:
        table = np.array(keys)
        return repeated(table[:, 0], table[:, 1], sketch.beats, 0.0, beats)
    table = np.array([(0.0, 0.0), *keys, (float(sketch.beats), 0.0)])
    return table[:, 0], table[:, 1]


def facing_keys(sketch: Sketch) -> tuple[Float, float]:
    """Keys (K, 2) of the whole body's facing (beat, rad), and how far it has turned after the step."""
    keys = [(key.beat, key.amounts["turn"]) for key in sketch.parts.get("body", ()) if "turn" in key.amounts]
    if not keys or keys[0][0] > 0.0:
        keys.insert(0, (0.0, 0.0))
    return np.array(keys), keys[-1][1] - keys[0][1]


def facing(sketch: Sketch, at: Float) -> Float:
    """Facing of the whole body [rad] at the beats `at` (K,), going on from one repetition to the next."""
    keys, turned = facing_keys(sketch)
    if len(keys) == 1:
        return np.full(len(at), keys[0, 1])
    if not sketch.cyclic:
        return through(keys[:, 0], keys[:, 1], at)
    span = np.array((min(at.min(), 0.0), max(at.max(), 0.0)))
    times, values = repeated(keys[:, 0], keys[:, 1], sketch.beats, turned, span)
    return hermite(times, values, monotone_slopes(times, values), at)
