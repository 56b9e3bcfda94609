"""Blend feasibility of joins: point clouds do not show limb twist or the direction in which a body turns."""

from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int32, Int64
from live.graph.build.blend_kernels import find_blendable

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


def can_blend(library: "StepLibrary", window: float, source: Int32, target: Int32, yaw: Float64) -> Bool:
    """Whether measure `target` can follow `source` (E,) without a joint that spins in the blend, (E,).

    `window`: length of the blend as a share of the measure; `yaw` (E,) [rad]: rotation of the target's clip (K001).
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
        MIN_ROOT_COSINE,
        MIN_CHORD,
        out,
    )
    return out & can_stand(library, window, source, target)


def can_stand(library: "StepLibrary", window: float, source: Int32, target: Int32) -> Bool:
    """Whether a dancer has something to stand on in the blend from recorded measures `source` to `target` (E,), (E,).

    Somewhere in it a foot stands in both, or both are in the air. Else the dancer would float from one foot to the
    other, or out of a jump onto the floor. Sketched measures are not asked.
    """
    before = (MOMENTS - 1.0) * window
    ends, starts = (_contacts(library, line, before) for line in (library.node_last, library.node_first))
    recorded = np.array([clip.recorded for clip in library.clips], np.bool_)[library.node_clip]
    good = np.ones(len(source), np.bool_)
    for rows in np.array_split(np.flatnonzero(recorded[source] & recorded[target]), 1 + len(source) // _PAIRS):
        one, other = ends[source[rows]], starts[target[rows]]
        common = (one & other).any(axis=-1) | ~(one.any(axis=-1) | other.any(axis=-1))
        good[rows] = common.any(axis=-1)
    return good


_PAIRS: Final = 100_000
"""Pairs whose contacts are compared at a time."""


def _contacts(library: "StepLibrary", line: Float64, before: Float64) -> Bool:
    """Return contacts at the samples nearest to `before` (K,) measures from the `line` (N,), (N, K, 2)."""
    return np.ascontiguousarray(library.clip_contact[_rows(library, line, before)])


def _rotations(library: "StepLibrary", line: Float64, before: Float64) -> Float32:
    """Return local rotations at those samples, (N, K, J, 4)."""
    return np.ascontiguousarray(library.clip_rotation[_rows(library, line, before)])


def _rows(library: "StepLibrary", line: Float64, before: Float64) -> Int64:
    """Return the samples nearest to `before` (K,) measures from the `line` (N,), (N, K)."""
    length = (library.node_last - library.node_first)[:, None]
    sample = np.maximum(line[:, None] + before * length, library.node_lead[:, None])
    return np.clip(np.round(sample).astype(np.int64), 0, len(library.clip_rotation) - 1)
