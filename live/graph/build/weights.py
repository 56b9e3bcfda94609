"""Metric: what counts how much when two point clouds are compared, per joint and along the window (T032, K002)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.skeleton import SKELETON

Float64 = npt.NDArray[np.float64]

WINDOW_SAMPLES: Final = 12
"""Poses in a window; the cloud has 12 · J points."""
EMPHASIS: Final = 0.5
"""How much more the pose at the measure line counts than the middle of the window, and the first one less."""
_ENDINGS: Final = (("Hand", 0.4), ("LowerArm", 0.7), ("Foot", 2.0), ("Toes", 1.5), ("hips", 2.0))


@dataclass(frozen=True, slots=True, eq=False)
class Metric:
    """Weights of a cloud of K poses of J joints; the weight of a point is the product, and all together are 1."""

    joint: Float64
    """Weight of each joint, sum 1, shape (J,)."""
    window: Float64
    """Weight of each pose along the window, sum 1, shape (K,)."""

    @classmethod
    def of(cls, joints: Mapping[str, float] | None = None, emphasis: float = EMPHASIS) -> "Metric":
        """The default, with other weights for some `joints` by name, and another `emphasis` of the measure line."""
        return cls(joint_weights(joints), window_weights(emphasis=emphasis))

    @property
    def points(self) -> Float64:
        """Weight of every point of a cloud, shape (K · J,)."""
        return np.outer(self.window, self.joint).reshape(-1)


def joint_weights(changes: Mapping[str, float] | None = None) -> Float64:
    """Weight of each joint in the cloud, sum 1, shape (J,): feet carry, hips lead, hands may differ.

    `changes` sets the weights of single joints by name, 1 for most, beside 2 for hips and feet and 0.4 for hands.
    ValueError for a name that no joint has, a weight that is negative or not finite, or if nothing is left to compare.
    """
    weights = np.ones(SKELETON.joint_count)
    for ending, weight in _ENDINGS:
        for joint, name in enumerate(SKELETON.names):
            if name.endswith(ending):
                weights[joint] = weight
    for name, weight in (changes or {}).items():
        if name not in SKELETON.names:
            raise ValueError(f"weight of {name!r}: no such joint; there are {', '.join(SKELETON.names)}")
        if not 0.0 <= weight < np.inf:
            raise ValueError(f"weight of {name!r} is {weight}; a number from 0 expected")
        weights[SKELETON.index(name)] = weight
    if weights.sum() <= 0.0:
        raise ValueError("all joints have weight 0: nothing is left to compare")
    return np.asarray(weights / weights.sum(), np.float64)


def window_weights(count: int = WINDOW_SAMPLES, emphasis: float = EMPHASIS) -> Float64:
    """Weight along the window, sum 1, shape (count,): larger towards the measure line, where the blend ends.

    It grows linearly from 1 - `emphasis` to 1 + `emphasis`; ValueError outside [0, 1].
    """
    if not 0.0 <= emphasis <= 1.0:
        raise ValueError(f"emphasis of the measure line {emphasis}: 0 to 1 expected")
    weights = np.linspace(1.0 - emphasis, 1.0 + emphasis, count)
    return np.asarray(weights / weights.sum(), np.float64)
