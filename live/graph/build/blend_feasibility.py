"""Blend feasibility of joins: point clouds do not show limb twist or the direction in which a body turns."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Float32, Float64, Int64, UInt8
from live.graph.build.blend_kernels import NOT_ASKED

if TYPE_CHECKING:
    from live.graph.step_library import StepLibrary


MOMENTS: Final = np.linspace(0.2, 0.8, 7)
"""Positions in the blend, from its beginning to the measure line, at which the rotations are compared; before and after
them one of the two hardly counts."""
MIN_ROOT_COSINE: Final = 0.3
"""Cosine of half the maximum angle between the bodies: 145 degrees apart."""
MIN_CHORD: Final = 0.7
"""Minimum length of the mixture of two unit rotations; a shorter one swings round suddenly. It is 1 if they are equal,
and 0 if they are opposite quaternions mixed half and half."""


@dataclass(frozen=True, slots=True, eq=False)
class Blends:
    """Local rotations and contacts of N measures that end and of M that begin, at the K MOMENTS of a blend."""

    end: Float32
    """Shape (N, K, J, 4)."""
    start: Float32
    """Shape (M, K, J, 4)."""
    weight: Float64
    """Weight of the measure that begins, (K,)."""
    end_stands: UInt8
    """Contacts of the feet as in `is_blendable`, shape (N, K, 2)."""
    start_stands: UInt8
    """Shape (M, K, 2)."""

    @classmethod
    def of(cls, library: "StepLibrary", window: float, first: Int64, second: Int64) -> "Blends":
        """Those of the nodes `first` (N,) and `second` (M,); `window`: length of a blend as a share of the measure."""
        before = (MOMENTS - 1.0) * window
        ends = _rows(library, first, library.node_last, before)
        starts = _rows(library, second, library.node_first, before)
        return cls(
            np.ascontiguousarray(library.clip_rotation[ends]),
            np.ascontiguousarray(library.clip_rotation[starts]),
            MOMENTS * MOMENTS * (3.0 - 2.0 * MOMENTS),
            _stands(library, first, ends),
            _stands(library, second, starts),
        )

    @classmethod
    def none(cls, first: int, second: int) -> "Blends":
        """No moments: every pair of `first` and `second` measures can be blended."""
        return cls(
            np.empty((first, 0, 1, 4), np.float32), np.empty((second, 0, 1, 4), np.float32), np.empty(0),
            np.empty((first, 0, 2), np.uint8), np.empty((second, 0, 2), np.uint8),
        )  # fmt: skip


def _rows(library: "StepLibrary", nodes: Int64, line: Float64, before: Float64) -> Int64:
    """Return the samples of `nodes` (n,) nearest to `before` (K,) measures from the `line` (N,), (n, K)."""
    length = (library.node_last[nodes] - library.node_first[nodes])[:, None]
    sample = np.maximum(line[nodes, None] + before * length, library.node_lead[nodes, None])
    return np.clip(np.round(sample).astype(np.int64), 0, len(library.clip_rotation) - 1)


def _stands(library: "StepLibrary", nodes: Int64, rows: Int64) -> UInt8:
    """Return the contacts of `nodes` (n,) at the samples `rows` (n, K), NOT_ASKED for sketched ones, (n, K, 2)."""
    stands = library.clip_contact[rows].astype(np.uint8)
    recorded = np.array([clip.recorded for clip in library.clips], np.bool_)
    stands[~recorded[library.node_clip[nodes]]] = NOT_ASKED
    return stands
