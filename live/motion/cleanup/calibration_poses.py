"""T-poses that performers hold at the beginning and end of a recording, while a suit is calibrated.

They are no dance: a measure that begins in one has its arms stretched out, and every join with it is a leap of the
arms. Texture (P020) leaves them out, too: a held pose trembles and is still cut into short fragments.
"""

from typing import Final

import numpy as np

from live.base.arrays import Bool, Float
from live.motion.cleanup.trim_start import MAX_ARM_SLOPE
from live.motion.clip import Clip, clip_part
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON

MAX_ARM_COSINE: Final = -0.8
"""Arms point away from each other while the dot product of their directions is below this; held arms sink a little, so
it is less than that of a T-pose which a converter adds."""
MAX_HAND_SPEED: Final = 0.3
"""Hands are still while they are slower than this [m/s]."""
MIN_POSE_S: Final = 0.5
"""A pose held for less than this [s] is part of the dance."""
MAX_EDGE_S: Final = 3.0
"""A pose that starts later than this [s] after the beginning, or ends earlier before the end, belongs to the dance."""
LOWERING_S: Final = 0.5
"""Time it takes to leave the pose [s]."""
_ARMS: Final = np.array([[SKELETON.index(side + name) for name in ("UpperArm", "Hand")] for side in ("left", "right")])


def calibration_ends(clip: Clip, within: float = MAX_EDGE_S) -> tuple[int, int]:
    """Return how many samples it takes until T-poses at the clip's beginning end, and the same from its end backwards.

    They are 0 where no T-pose begins `within` [s].
    """
    position, _ = forward_kinematics(clip.root_position, clip.rotation)
    hand = position[:, _ARMS[:, 1]]
    arm = hand - position[:, _ARMS[:, 0]]
    arm /= np.maximum(np.linalg.norm(arm, axis=-1, keepdims=True), 1e-6)
    level = (np.abs(arm[..., 1]) < MAX_ARM_SLOPE).all(axis=1)
    apart = (arm[:, 0] * arm[:, 1]).sum(axis=-1) < MAX_ARM_COSINE
    posed = level & apart & (_speed(hand, clip.sample_rate).max(axis=1) < MAX_HAND_SPEED)
    limits = (within * clip.sample_rate, MIN_POSE_S * clip.sample_rate)
    return _pose_end(posed, *limits), _pose_end(posed[::-1], *limits)


def danced_part(clip: Clip) -> tuple[int, int]:
    """Return the first sample after the T-pose at the clip's beginning and the first of the one at its end.

    Time to leave the first and to take the second is left out with them. They are 0 and `clip.sample_count` if there
    is no T-pose, or less than a second of anything else.
    """
    lowering = round(LOWERING_S * clip.sample_rate)
    begins, ends = (held + lowering if held else 0 for held in calibration_ends(clip))
    last = clip.sample_count - ends
    return (begins, last) if last - begins >= clip.sample_rate else (0, clip.sample_count)


def trim_calibration_poses(clip: Clip) -> Clip:
    """Return the clip without T-poses at its beginning and end; unchanged if it has none or nothing else."""
    first, last = danced_part(clip)
    return clip if (first, last) == (0, clip.sample_count) else clip_part(clip, first, last)


def _speed(position: Float, rate: float) -> Float:
    """Return the speed [m/s] (T, K) of joints at positions (T, K, 3), around each sample."""
    if len(position) < 2:
        return np.zeros(position.shape[:2])
    return np.asarray(np.linalg.norm(np.gradient(position, axis=0), axis=-1) * rate)


def _pose_end(posed: Bool, within: float, shortest: float) -> int:
    """Return the number of samples until the last pose of at least `shortest` that begins `within` another ends."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], posed, [False])).astype(np.int8)))
    first = 0
    for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if begin - first < within and end - begin >= shortest:
            first = end
    return first
