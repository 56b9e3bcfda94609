"""Skin weights after subdivision: muscles take their share, fingers bend at their joints only."""

from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.render.body.drawn_joints import DRAWN_NAMES
from live.render.body.fingers import FINGERS, PHALANGES
from live.render.body.muscles import MUSCLES

_SHARPNESS: Final = 2.6
"""Exponent of fingers' weights: a phalanx is a bone between two joints, and not a spring."""
_PHALANGES: Final = [
    DRAWN_NAMES.index(f"{side}{finger.name}{phalanx}")
    for side in ("left", "right") for finger in FINGERS for phalanx in PHALANGES
]  # fmt: skip


def settled_weights(points: Float64, weights: Float64) -> Float64:
    """Return the weights (V, J) of vertices (V, 3) in the rest pose, as they are drawn; rows sum to 1."""
    weights = weights.copy()
    fingers = weights[:, _PHALANGES]
    total = fingers.sum(axis=1, keepdims=True)
    sharp = (fingers / np.maximum(total, 1e-9)) ** _SHARPNESS
    weights[:, _PHALANGES] = total * sharp / np.maximum(sharp.sum(axis=1, keepdims=True), 1e-9)
    for muscle in MUSCLES:
        if muscle.centre is None:
            continue
        for side, sign in (("left", 1.0), ("right", -1.0)):
            away = (points * (sign, 1.0, 1.0) - muscle.centre) / muscle.radii
            share = muscle.share * np.maximum(1.0 - (away**2).sum(axis=1), 0.0) ** 2
            weights *= 1.0 - share[:, None]
            weights[:, DRAWN_NAMES.index(side + muscle.name)] += share
    return weights
