"""Leash: who walks along a path stays near it in place and time, so that she ends where it ends (H019).

Units are laid on the path as whole strides; where it rests, or ends, within one, she would go on by the rest of it.
"""

from dataclasses import replace
from typing import Final

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from live.motion.clip import Clip
from live.motion.partner.cloud import Cloud

NEAR: Final = 0.12
"""So far [m] she may be from where the path is."""
EASES: Final = 0.12
"""Standard deviation [s] of how what is mended comes and goes."""


def leashed(clip: Clip, path: Cloud, near: float = NEAR) -> Clip:
    """The clip with its hips no farther than about `near` [m] from the middle of `path`'s points, at the same rate."""
    count = min(clip.sample_count, path.count)
    middle = path.floor.mean(axis=1)
    middle = np.concatenate((middle[:count], np.full(clip.sample_count - count, middle[count - 1])))
    away = clip.root_position[:, 2].astype(np.float64) + 1j * clip.root_position[:, 0] - middle
    size = np.abs(away)
    share = np.maximum(1.0 - near / np.maximum(size, near), 0.0)
    if not share.any():
        return clip
    width = EASES * clip.sample_rate
    share = gaussian_filter1d(maximum_filter1d(share, 2 * round(2.0 * width) + 1), width, mode="nearest")
    root = clip.root_position.copy()
    root[:, 0] -= (share * away.imag).astype(np.float32)
    root[:, 2] -= (share * away.real).astype(np.float32)
    return replace(clip, root_position=root)
