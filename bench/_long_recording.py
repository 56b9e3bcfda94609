"""A long recording with known repeats: stretches of real recordings, one after another, varied, at one tempo."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench._recorded_measures import varied
from live.base.arrays import Bool, Float, Int32
from live.motion import quaternion
from live.motion.clip import Clip, read_clip
from live.motion.step_clip import StepClip

RATE = 60.0
_Y = np.array((0.0, 1.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class LongRecording:
    """One clip whose measures are known."""

    clip: Clip
    bpm: float
    identity: Int32
    """Which measure of the recordings each of its measures is, negative if mirrored, (M,)."""


def long_recording(dances: Sequence[Sequence[StepClip]], measures: int, bpm: float, seed: int = 1) -> LongRecording:
    """Return `measures` measures at `bpm`: stretches of 3 to 8 measures of `dances` (each the measures of one).

    Every measure is timed and held a little differently, some stretches are mirrored; each continues where the last
    ended, facing as it did.
    """
    chance = np.random.default_rng(seed)
    first = np.cumsum([0, *map(len, dances)])
    samples = round(240.0 / bpm * RATE)
    bpm = 240.0 / samples * RATE  # a whole number of samples, so that the tempo is exact
    parts: list[tuple[Float, Float, Bool]] = []
    identity: list[int] = []
    place, yaw = np.zeros(3), 0.0
    while len(parts) < measures:
        dance = int(chance.integers(len(dances)))
        size = min(int(chance.integers(3, 9)), len(dances[dance]), measures - len(parts))
        begin, mirrored = int(chance.integers(len(dances[dance]) - size + 1)), bool(chance.random() < 0.3)
        for n in range(begin, begin + size):
            step = varied(dances[dance][n], chance, mirrored)
            at = step.first + np.arange(samples + 1) * (step.samples_per_measure / samples)
            root, rotation, contact = read_clip(step.clip, np.minimum(at, step.clip.sample_count - 1.0))
            turn = quaternion.from_axis_angle(_Y, np.asarray(yaw - _heading(rotation[0, 0])))
            root = quaternion.rotate(turn, root - root[0] * (1.0, 0.0, 1.0)) + place
            rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
            place, yaw = root[-1] * (1.0, 0.0, 1.0), _heading(rotation[-1, 0])
            parts.append((root[:-1], rotation[:-1], contact[:-1]))
            identity.append((1 + first[dance] + n) * (-1 if mirrored else 1))
    root, rotation, contact = (np.concatenate(part) for part in zip(*parts, strict=True))
    rotation = quaternion.align_signs(rotation)
    clip = Clip("long", root.astype(np.float32), np.ascontiguousarray(rotation, np.float32), RATE, contact)
    return LongRecording(clip, bpm, np.array(identity, np.int32))


def _heading(rotation: np.ndarray) -> float:
    x, _, z = quaternion.rotate(rotation, np.array((0.0, 0.0, 1.0)))
    return float(np.arctan2(x, z))
