"""FlatClouds: point clouds as K003 wants them, centred, weighted, floor coordinates as complex numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from live.graph.build.weights import Metric

Float64 = npt.NDArray[np.float64]
Float32 = npt.NDArray[np.float32]
Complex = npt.NDArray[np.complex128]
Complex64 = npt.NDArray[np.complex64]


@dataclass(frozen=True, slots=True, eq=False)
class FlatClouds:
    """N clouds of P points."""

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

    A projection makes no distance longer, whatever the rotation, so pairs that are far apart here are far apart.
    """
    coarse_height: Float32
    """The heights likewise, shape (N, 3 · J)."""
    coarse_size: Float32
    """|coarse_floor|² + |coarse_height|² [m²], shape (N,)."""

    @classmethod
    def of(cls, clouds: Float64, metric: Metric) -> "FlatClouds":
        """From world positions (N, K, J, 3) [m]; ValueError if the metric is for clouds of another shape."""
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
        """The clouds of all parts, one after another."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in cls.__slots__))

    def chosen(self, index: npt.NDArray[np.int64]) -> "FlatClouds":
        """The clouds `index` (M,), in order; views where they follow each other."""
        if len(index) and index[-1] - index[0] == len(index) - 1:
            part: Any = slice(int(index[0]), int(index[-1]) + 1)
        else:
            part = index
        return FlatClouds(*(getattr(self, name)[part] for name in FlatClouds.__slots__))

    def __len__(self) -> int:
        return len(self.size)


def _parabolas(metric: Metric) -> Float64:
    """Orthonormal functions of the K samples of a window that span √weight · (1, t, t²), shape (K, 3 or fewer)."""
    count = len(metric.window)
    t = np.linspace(-1.0, 1.0, count)[:, None]
    powers = np.sqrt(metric.window)[:, None] * t ** np.arange(min(3, count))
    return np.asarray(np.linalg.qr(powers)[0])
