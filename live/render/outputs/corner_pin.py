"""Corner pin: the projective map that brings the frame's corners to four given points of the window."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.render.outputs.output import Point

Float64 = npt.NDArray[np.float64]

LEAST_AREA: Final = 1e-4
"""Corners that enclose less than this share of the window show nothing."""
FARTHEST: Final = 4.0
"""A corner lies at most so many windows beside the window."""


def homography(corners: Sequence[Point]) -> Float64:
    """The matrix (3, 3) that takes (u, v, 1) of the frame to (x w, y w, w) of the window, the corners exactly.

    `corners`: upper left, upper right, lower right, lower left; they must be convex (`check_corners`).
    After Heckbert, "Fundamentals of texture mapping and image warping" (1989), section 2.2.3.
    """
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = corners
    sum_x, sum_y = x0 - x1 + x2 - x3, y0 - y1 + y2 - y3
    ax, ay, bx, by = x1 - x2, y1 - y2, x3 - x2, y3 - y2
    area = ax * by - bx * ay
    g = (sum_x * by - bx * sum_y) / area
    h = (ax * sum_y - sum_x * ay) / area
    return np.array([
        [x1 - x0 + g * x1, x3 - x0 + h * x3, x0],
        [y1 - y0 + g * y1, y3 - y0 + h * y3, y0],
        [g, h, 1.0],
    ])  # fmt: skip


def mapped(matrix: Float64, points: npt.ArrayLike) -> Float64:
    """Points (..., 2) through a homography, shape (..., 2)."""
    given = np.asarray(points, np.float64)
    through = np.concatenate([given, np.ones((*given.shape[:-1], 1))], axis=-1) @ matrix.T
    result: Float64 = through[..., :2] / through[..., 2:]
    return result


def check_corners(corners: Sequence[Point]) -> None:
    """PersonError unless the corners can hold a picture: convex, in order, not turned over, with an area."""
    points = np.array(corners, np.float64)
    if np.abs(points - 0.5).max() > FARTHEST + 0.5:
        raise PersonError(f"a corner lies more than {FARTHEST:g} windows away", "0 and 1 are the window's borders")
    sides = np.roll(points, -1, axis=0) - points
    after = np.roll(sides, -1, axis=0)
    turns = sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]
    x, y = points.T
    area = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    order = "give them as upper left, upper right, lower right, lower left"
    if abs(area) < LEAST_AREA and not (turns.min() < -LEAST_AREA and turns.max() > LEAST_AREA):
        raise PersonError("the corners enclose nothing", order)
    if turns.max() < 0.0:
        raise PersonError("the corners turn the picture over", f"{order}; `mirror = true` mirrors it")
    if turns.min() <= LEAST_AREA:
        what = "cross" if _cross(points) else "have a dent, or three of them lie in a line"
        raise PersonError(f"the corners {what}", order)


def _cross(points: Float64) -> bool:
    """Whether two opposite sides of the four points cross."""
    return any(_meet(points[i], points[i + 1], points[i + 2], points[(i + 3) % 4]) for i in (0, 1))


def _meet(a: Float64, b: Float64, c: Float64, d: Float64) -> bool:
    def side(p: Float64, q: Float64, r: Float64) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0
