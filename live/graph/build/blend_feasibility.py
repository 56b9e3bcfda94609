"""Which joins can be blended: point clouds do not see how far a limb is twisted, nor which way round a body turns."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.build.blend_kernels import find_blendable
from live.graph.step_library import StepLibrary

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

MOMENTS: Final = np.linspace(0.2, 0.8, 7)
"""Places in the blend, from its beginning to the measure line, at which the rotations are compared; before and after
them one of the two hardly counts."""
LEAST_ROOT: Final = 0.3
"""Cosine of half the angle between the bodies: never farther than 145 degrees apart."""
LEAST_CHORD: Final = 0.5
"""Length of what is mixed of two unit rotations: shorter, it swings round in a moment. 1 where they are the same, 0
where they are half a turn of sign apart and mixed half and half."""


def blendable(library: StepLibrary, window: float, source: Int32, target: Int32, yaw: Float64) -> Bool:
    """Whether measure `target` can follow `source` (E,) without a joint that spins in the blend, (E,).

    `window`: length of the blend as a share of the measure; `yaw` (E,) [rad]: how the target's clip is turned (K001).
    """
    out = np.ones(len(source), np.bool_)
    if not len(source):
        return out
    before = (MOMENTS - 1.0) * window
    weight = MOMENTS * MOMENTS * (3.0 - 2.0 * MOMENTS)
    find_blendable(
        _rotations(library, library.node_last, before),
        _rotations(library, library.node_first, before),
        np.ascontiguousarray(source, np.int32),
        np.ascontiguousarray(target, np.int32),
        np.ascontiguousarray(yaw, np.float64),
        weight,
        LEAST_ROOT,
        LEAST_CHORD,
        out,
    )
    return out


def _rotations(library: StepLibrary, line: Float64, before: Float64) -> Float32:
    """Local rotations at the nearest samples to `before` (K,), in measures, from the `line` (N,), (N, K, J, 4)."""
    length = (library.node_last - library.node_first)[:, None]
    sample = np.maximum(line[:, None] + before * length, library.node_lead[:, None])
    rows = np.clip(np.round(sample).astype(np.int64), 0, len(library.clip_rotation) - 1)
    return np.ascontiguousarray(library.clip_rotation[rows])
