"""Matching: which fragments of the data are most like one of the sketch's (P007-P010)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.texture.fragments import Fragments

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

LONGEST: Final = 4.0
"""A fragment of the data that lasts longer than so many times the sketch's is rejected: poses held for calibration."""
SHARE: Final = 0.1
"""Of all fragments so many are kept as candidates (K)."""
SCALES: Final = (0.0, 2.0)
"""Within this the scale of P010 is looked for: the paper bounds it not, and a negative one would turn motion about."""


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """The candidates of each of n fragments of the sketch, the closest first."""

    candidates: tuple[Int64, ...]
    """For each the fragments of the data, (at most K,)."""
    distances: tuple[Float64, ...]
    """The mean square of what differs, value and derivative, of each, in the features' own units."""
    scales: tuple[Float64, ...]
    """The scale of each (P010); 1 where none was asked for."""


def resampled(signal: Float64, begin: Int64, end: Int64, count: int) -> Float64:
    """Fragments of `signal` (T, D) from samples `begin` to `end` (F,) by linear resampling to `count` samples,
    (F, count, D)."""
    part = np.linspace(0.0, 1.0, count)
    at = begin[:, None] + (end - begin)[:, None] * part
    low = np.minimum(at.astype(np.int64), len(signal) - 2)
    weight = (at - low)[..., None]
    return np.asarray(signal[low] * (1.0 - weight) + signal[low + 1] * weight)


def match(
    sketch: Float64, sketch_parts: Fragments, data: Float64, data_parts: Fragments, keep: int, *, scale: bool = False
) -> Matches:
    """The `keep` (K) fragments of the data that are most like each of the sketch's.

    `sketch` (T, 2 D) and `data` (S, 2 D) hold the D matching angles' band and behind it the derivatives, weighted.
    Raises ValueError where every fragment of the data is too long for one of the sketch.
    """
    count = sketch_parts.count
    candidates = [np.zeros(0, np.int64)] * count
    distances, scales = ([np.zeros(0)] * count for _ in range(2))
    lengths = sketch_parts.length
    for length in np.unique(lengths).tolist():
        allowed = np.flatnonzero(data_parts.length <= LONGEST * length)
        if not len(allowed):
            raise ValueError(f"all fragments of the data last longer than {LONGEST:g} times {length} samples")
        theirs = resampled(data, data_parts.begin[allowed], data_parts.end[allowed], length + 1)
        flat = theirs.reshape(len(allowed), -1)
        own_rows = np.flatnonzero(lengths == length)
        own = resampled(sketch, sketch_parts.begin[own_rows], sketch_parts.end[own_rows], length + 1)
        own = own.reshape(len(own_rows), -1)
        apart = _squares(own, flat) / flat.shape[1]
        for row, far in zip(own_rows.tolist(), apart, strict=True):
            best = np.argsort(far, kind="stable")[:keep]
            candidates[row], distances[row] = allowed[best], far[best]
            scales[row] = np.ones(len(best))
            if scale:
                half = sketch.shape[1] // 2
                mine = sketch[sketch_parts.begin[row] : sketch_parts.end[row] + 1, :half]
                scales[row] = _scales(mine, theirs[best][..., :half])
    return Matches(tuple(candidates), tuple(distances), tuple(scales))


def _squares(a: Float64, b: Float64) -> Float64:
    """Squared distances (n, m) of rows (n, d) and (m, d)."""
    squares = np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1)[None] - 2.0 * (a @ b.T)
    return np.asarray(np.maximum(squares, 0.0))


def _scales(own: Float64, theirs: Float64) -> Float64:
    """The scale s of each of `theirs` (K, n, D) for which ‖s M - A‖ is least (P010): <M, A> / <M, M>, within SCALES."""
    over = np.einsum("knd,nd->k", theirs, own)
    under = np.einsum("knd,knd->k", theirs, theirs)
    return np.asarray(np.clip(np.where(under > 1e-12, over / np.maximum(under, 1e-12), 1.0), *SCALES))
