"""Dancers on lines: exact counts, evenly along the way or in weighted measure, corners first where wished (T091)."""

import numpy as np
import numpy.typing as npt

from live.agents.formations.curve import Curve

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]


def share(count: int, lengths: Float64, fixed: Float64, least: Int64) -> Int64:
    """Split `count` over C lines so that their gaps are as equal as can be (Webster's method), shape (C,).

    Line c of `lengths[c]` with k shares has k + `fixed[c]` gaps; each gets at least `least[c]`, whose sum is not more
    than `count`. Of equal lines the outermost of the list come first, so that symmetrical shapes stay so.
    """
    given = least.astype(np.int64).copy()
    if count - int(given.sum()) > 16:  # most of them at once, the last ones one by one
        gap = float(lengths.sum()) / max(count + float(fixed.sum()), 1.0)
        ahead = np.maximum(given, np.floor(lengths / max(gap, 1e-12) - fixed).astype(np.int64) - 1)
        given = ahead if ahead.sum() <= count else given
    number = np.arange(len(lengths))
    rank = np.minimum(number, len(lengths) - 1 - number) + 1e-3 * number
    for _ in range(count - int(given.sum())):
        priority = lengths / np.maximum(given + fixed + 0.5, 0.5)
        best = np.flatnonzero(priority >= priority.max() * (1.0 - 1e-9))
        given[best[np.argmin(rank[best])]] += 1
    return given


def share_over_curves(count: int, curves: "list[Curve]") -> Int64:
    """How many dancers stand on each line, shape (C,), together `count`."""
    lengths = np.array([curve.length for curve in curves])
    fixed = np.array([0.0 if curve.closed else sum(curve.gaps) - 1.0 for curve in curves])
    return share(count, lengths, fixed, np.zeros(len(curves), np.int64))


def along(curve: Curve, count: int, *, corners: bool, phase: float = 0.0) -> Float64:
    """Where `count` dancers stand along a line, in units of its `at`, shape (count,), growing.

    With `corners` each corner has one, if there are as many dancers, and sides are filled as evenly as whole numbers
    allow. `phase` moves those of a closed line without marked corners, in spacings. `count` 0 is nobody.
    """
    if count == 0:
        return np.zeros(0)
    if curve.closed:
        marked = np.array(curve.corners) if corners else np.zeros(0)
        if not 0 < len(marked) <= count:
            return np.asarray((np.arange(count) + phase) * (curve.length / count), np.float64)
        ends = np.append(marked, marked[0] + curve.length)
        return np.asarray(np.sort(np.mod(_sides(ends, count, (0.0, 0.0))[:count], curve.length)))
    inner = np.array(curve.corners) if corners else np.zeros(0)
    ends = np.concatenate([[0.0], inner, [curve.length]])
    least = _least(len(ends) - 1, curve.gaps)
    if least.sum() > count - 1:
        ends = np.array([0.0, curve.length])
    if count - 1 + sum(curve.gaps) <= 0:
        return np.array([curve.length / 2])
    return _sides(ends, count - 1, curve.gaps)


def _least(sides: int, gaps: tuple[float, float]) -> Int64:
    """The fewest whole gaps of each side: a side between two corners has one."""
    least = np.ones(sides, np.int64)
    least[0] -= gaps[0] > 0
    least[-1] -= gaps[1] > 0
    return np.maximum(least, 0)


def _sides(ends: Float64, whole: int, gaps: tuple[float, float]) -> Float64:
    """Dancers on all `ends` (but for gaps at the first and last) and evenly between them; `whole` gaps in all."""
    lengths = np.diff(ends)
    parts = np.zeros(len(lengths))
    parts[0] += gaps[0]
    parts[-1] += gaps[1]
    number = share(whole, lengths, parts, _least(len(lengths), gaps) if len(lengths) > 1 else np.zeros(1, np.int64))
    found = []
    for n, length in enumerate(lengths):
        gap = length / max(number[n] + parts[n], 1e-9)
        begin = ends[n] + (gaps[0] * gap if n == 0 else 0.0)
        found.append(begin + gap * np.arange(number[n] + (n == len(lengths) - 1)))
    return np.concatenate(found)
