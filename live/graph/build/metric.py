"""Metric for point clouds: weights per joint and along the window (T032, K002), and the clouds prepared for K003."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Complex64, Float32, Float64
from live.motion.skeleton import SKELETON

WINDOW_SAMPLES: Final = 12
"""Poses in a window; the cloud has 12 · J points."""
EMPHASIS: Final = 0.5
"""Extra weight of the pose at the measure line over the middle of the window; the first pose has as much less."""
_ENDINGS: Final = (("Hand", 0.4), ("LowerArm", 0.7), ("Foot", 2.0), ("Toes", 1.5), ("hips", 2.0))


@dataclass(frozen=True, slots=True, eq=False)
class Metric:
    """Weights of a cloud of K poses of J joints; a point's weight is the product, and the sum is 1."""

    joint: Float64
    """Weight of each joint, sum 1, shape (J,)."""
    window: Float64
    """Weight of each pose along the window, sum 1, shape (K,)."""

    @classmethod
    def of(cls, joints: Mapping[str, float] | None = None, emphasis: float = EMPHASIS) -> "Metric":
        """Return the default with other weights for some `joints` by name, or another `emphasis` of the line."""
        return cls(joint_weights(joints), window_weights(emphasis=emphasis))

    @property
    def points(self) -> Float64:
        """Return the weight of every point of a cloud, shape (K · J,)."""
        return np.outer(self.window, self.joint).reshape(-1)


def joint_weights(changes: Mapping[str, float] | None = None) -> Float64:
    """Return the weight of each joint in the cloud, sum 1, shape (J,); feet and hips weigh most, hands least.

    `changes` sets the weights of joints by name; the default is 1 for most, 2 for hips and feet and 0.4 for hands.
    ValueError for an unknown joint, a weight that is negative or not finite, or if all weights are 0.
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
    """Return the weight along the window, sum 1, shape (count,): larger towards the measure line, where the blend ends.

    It grows linearly from 1 - `emphasis` to 1 + `emphasis`; ValueError outside [0, 1].
    """
    if not 0.0 <= emphasis <= 1.0:
        raise ValueError(f"emphasis of the measure line {emphasis}: 0 to 1 expected")
    weights = np.linspace(1.0 - emphasis, 1.0 + emphasis, count)
    return np.asarray(weights / weights.sum(), np.float64)


Complex = npt.NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class FlatClouds:
    """N clouds of P points: centred, weighted, floor coordinates as complex numbers (K003)."""

    floor: Complex
    """√w (x + iz), centred, shape (N, P)."""
    height: Float64
    """√w y, shape (N, P)."""
    centre: Complex
    """Weighted mean of x + iz [m], shape (N,)."""
    size: Float64
    """|floor|² + |height|² [m²], shape (N,)."""
    coarse_floor: Complex64
    """The floor coordinates as parabolas in time: their projection on three basis functions, shape (N, 3 · J).

    A projection never lengthens a distance, for any rotation, so pairs that are far apart here are far apart.
    """
    coarse_height: Float32
    """The heights likewise, shape (N, 3 · J)."""
    coarse_size: Float32
    """|coarse_floor|² + |coarse_height|² [m²], shape (N,)."""

    @classmethod
    def of(cls, clouds: Float64, metric: Metric) -> "FlatClouds":
        """Prepare world positions (N, K, J, 3) [m]; ValueError if the metric is for clouds of another shape."""
        if clouds.shape[1:] != (len(metric.window), len(metric.joint), 3):
            expected = f"(N, {len(metric.window)}, {len(metric.joint)}, 3)"
            raise ValueError(f"clouds of shape {clouds.shape}; {expected} expected")
        weights = metric.points
        root = np.sqrt(weights)
        points = clouds.reshape(len(clouds), -1, 3)
        floor: Complex = np.empty(points.shape[:2], np.complex128)
        floor.real, floor.imag = points[..., 0], points[..., 2]
        centre: Complex = floor @ weights.astype(np.complex128)
        floor -= centre[:, None]
        floor *= root
        height = np.ascontiguousarray(points[..., 1] * root, np.float64)
        return cls._of(floor, height, centre, _parabolas(metric))

    @classmethod
    def _of(cls, floor: Complex, height: Float64, centre: Complex, basis: Float64) -> "FlatClouds":
        size = sum(np.einsum("np,np->n", part, part) for part in (floor.real, floor.imag, height))
        shape = (len(floor), len(basis), -1)
        coarse = (np.einsum("kc,nkj->ncj", basis, part.reshape(shape), optimize=True) for part in (floor, height))
        coarse_floor, coarse_height = (part.reshape(len(floor), -1) for part in coarse)
        parts = (coarse_floor.real, coarse_floor.imag, coarse_height)
        return cls(
            floor,
            height,
            centre,
            np.asarray(size),
            coarse_floor.astype(np.complex64),
            coarse_height.astype(np.float32),
            np.asarray(sum(np.einsum("np,np->n", part, part) for part in parts), np.float32),
        )

    @classmethod
    def joined(cls, parts: Sequence["FlatClouds"]) -> "FlatClouds":
        """Return the clouds of all parts, concatenated."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in cls.__slots__))

    def select(self, index: npt.NDArray[np.int64]) -> "FlatClouds":
        """Return the clouds `index` (M,), in order; views if the indices are consecutive."""
        if len(index) and index[-1] - index[0] == len(index) - 1:
            part: Any = slice(int(index[0]), int(index[-1]) + 1)
        else:
            part = index
        return FlatClouds(*(getattr(self, name)[part] for name in FlatClouds.__slots__))

    def __len__(self) -> int:
        return len(self.size)


def _parabolas(metric: Metric) -> Float64:
    """Return orthonormal functions of K window samples that span √weight · (1, t, t²), shape (K, 3 or fewer)."""
    count = len(metric.window)
    t = np.linspace(-1.0, 1.0, count)[:, None]
    powers = np.sqrt(metric.window)[:, None] * t ** np.arange(min(3, count))
    return np.asarray(np.linalg.qr(powers)[0])
