"""Blend feasibility of joins: point clouds do not show limb twist or the direction in which a body turns."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Float32, Float64, Int64

if TYPE_CHECKING:
    from live.graph.step_library import StepLibrary


MOMENTS: Final = np.linspace(0.2, 0.8, 7)
"""Positions in the blend, from its beginning to the measure line, at which the rotations are compared; before and after
them one of the two hardly counts."""
MIN_ROOT_COSINE: Final = 0.3
"""Cosine of half the maximum angle between the bodies: 145 degrees apart."""
MIN_CHORD: Final = 0.5
"""Minimum length of the mixture of two unit rotations; a shorter one swings round suddenly. It is 1 if they are equal,
and 0 if they are opposite quaternions mixed half and half."""


@dataclass(frozen=True, slots=True, eq=False)
class Blends:
    """Local rotations of N measures that end and of M that begin, at the K MOMENTS of a blend."""

    end: Float32
    """Shape (N, K, J, 4)."""
    start: Float32
    """Shape (M, K, J, 4)."""
    weight: Float64
    """Weight of the measure that begins, (K,)."""

    @classmethod
    def of(cls, library: "StepLibrary", window: float, first: Int64, second: Int64) -> "Blends":
        """Those of the nodes `first` (N,) and `second` (M,); `window`: length of a blend as a share of the measure."""
        before = (MOMENTS - 1.0) * window
        return cls(
            _rotations(library, first, library.node_last, before),
            _rotations(library, second, library.node_first, before),
            MOMENTS * MOMENTS * (3.0 - 2.0 * MOMENTS),
        )

    @classmethod
    def none(cls, first: int, second: int) -> "Blends":
        """No moments: every pair of `first` and `second` measures can be blended."""
        return cls(np.empty((first, 0, 1, 4), np.float32), np.empty((second, 0, 1, 4), np.float32), np.empty(0))


def _rotations(library: "StepLibrary", nodes: Int64, line: Float64, before: Float64) -> Float32:
    """Return local rotations of `nodes` (n,) at the samples nearest to `before` (K,) measures from the `line` (N,), (n,
    K, J, 4)."""
    length = (library.node_last[nodes] - library.node_first[nodes])[:, None]
    sample = np.maximum(line[nodes, None] + before * length, library.node_lead[nodes, None])
    rows = np.clip(np.round(sample).astype(np.int64), 0, len(library.clip_rotation) - 1)
    return np.ascontiguousarray(library.clip_rotation[rows])
