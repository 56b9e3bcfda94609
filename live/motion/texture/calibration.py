"""T-poses that are held for calibration at either end of a recording: nobody dances them, so nothing is made of them.

The paper only rejects fragments that last too long; a held pose trembles, and is cut in short ones all the same.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON

Float = npt.NDArray[np.floating]

LEVEL: Final = 0.35
"""An arm is level while its direction rises or falls by less than this."""
OPPOSITE: Final = -0.8
"""Arms point away from each other while the product of their directions is below this."""
STILL: Final = 0.3
"""Hands are still while they are slower than this [m/s]."""
HELD_S: Final = 0.5
"""A pose held shorter than this [s] is part of a dance."""
EDGE_S: Final = 3.0
"""A pose taken later than this [s] after the beginning, or left so long before the end, is a dance's own."""
LOWERED_S: Final = 0.5
"""How long it takes to leave it [s]."""
_ARMS: Final = tuple((SKELETON.index(s + "UpperArm"), SKELETON.index(s + "Hand")) for s in ("left", "right"))


def without_calibration(clip: Clip) -> Clip:
    """The clip without T-poses at its beginning and its end; as it is where there are none, or nothing else."""
    position, _ = forward_kinematics(clip.root_position, clip.rotation)
    arms = [position[:, hand] - position[:, shoulder] for shoulder, hand in _ARMS]
    arms = [arm / np.maximum(np.linalg.norm(arm, axis=-1, keepdims=True), 1e-6) for arm in arms]
    level = np.maximum(np.abs(arms[0][:, 1]), np.abs(arms[1][:, 1])) < LEVEL
    still = np.max([_speed(position[:, hand], clip.sample_rate) for _, hand in _ARMS], axis=0) < STILL
    posed = level & still & (np.sum(arms[0] * arms[1], axis=-1) < OPPOSITE)
    first, last = _held(posed, clip.sample_rate), clip.sample_count - _held(posed[::-1], clip.sample_rate)
    if (first, last) == (0, clip.sample_count) or last - first < clip.sample_rate:
        return clip
    part = slice(first, last)
    root, rotation = np.ascontiguousarray(clip.root_position[part]), np.ascontiguousarray(clip.rotation[part])
    return Clip(clip.name, root, rotation, clip.sample_rate, np.ascontiguousarray(clip.contact[part]))


def _speed(position: Float, rate: float) -> Float:
    """Speed [m/s] of a joint at (T, 3), about each sample."""
    if len(position) < 2:
        return np.zeros(len(position))
    return np.asarray(np.linalg.norm(np.gradient(position, axis=0), axis=-1) * rate)


def _held(posed: npt.NDArray[np.bool_], rate: float) -> int:
    """Samples at the beginning until the last pose held there is left; 0 if none is."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], posed, [False])).astype(np.int8)))
    first = 0
    for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if begin - first < EDGE_S * rate and end - begin >= HELD_S * rate:
            first = end
    return 0 if first == 0 else min(len(posed), first + round(LOWERED_S * rate))
