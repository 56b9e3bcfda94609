"""Warp of an output: corner pin (homography to four points of the window) and smooth mesh of control points."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64
from live.base.errors import PersonError
from live.render.outputs.output import MAX_MESH_POINTS, MIN_MESH_POINTS, Output, Point

MIN_AREA: Final = 1e-4
"""Corners that enclose less than this share of the window show nothing."""
MAX_CORNER_DISTANCE: Final = 4.0
"""Maximum distance of a corner from the window, in window sizes."""


def homography(corners: Sequence[Point]) -> Float64:
    """Return the matrix (3, 3) that maps (u, v, 1) of the frame to (x w, y w, w) of the window, exact at the corners.

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


def map_points(matrix: Float64, points: npt.ArrayLike) -> Float64:
    """Return points (..., 2) mapped by a homography, shape (..., 2)."""
    given = np.asarray(points, np.float64)
    through = np.concatenate([given, np.ones((*given.shape[:-1], 1))], axis=-1) @ matrix.T
    result: Float64 = through[..., :2] / through[..., 2:]
    return result


def check_corners(corners: Sequence[Point]) -> None:
    """Raise PersonError unless the corners are convex, in order, not mirrored, and enclose an area."""
    points = np.array(corners, np.float64)
    if np.abs(points - 0.5).max() > MAX_CORNER_DISTANCE + 0.5:
        raise PersonError(
            f"a corner lies more than {MAX_CORNER_DISTANCE:g} windows away", "0 and 1 are the window's borders"
        )
    sides = np.roll(points, -1, axis=0) - points
    after = np.roll(sides, -1, axis=0)
    turns = sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]
    x, y = points.T
    area = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    order = "give them as upper left, upper right, lower right, lower left"
    if abs(area) < MIN_AREA and not (turns.min() < -MIN_AREA and turns.max() > MIN_AREA):
        raise PersonError("the corners enclose nothing", order)
    if turns.max() < 0.0:
        raise PersonError("the corners turn the picture over", f"{order}; `mirror = true` mirrors it")
    if turns.min() <= MIN_AREA:
        what = "cross" if _is_crossed(points) else "have a dent, or three of them lie in a line"
        raise PersonError(f"the corners {what}", order)


def _is_crossed(points: Float64) -> bool:
    """Whether two opposite sides of the four points cross."""
    return any(_segments_cross(points[i], points[i + 1], points[i + 2], points[(i + 3) % 4]) for i in (0, 1))


def _segments_cross(a: Float64, b: Float64, c: Float64, d: Float64) -> bool:
    def side(p: Float64, q: Float64, r: Float64) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0


SUBDIVISIONS: Final = 12
"""Subdivisions of a mesh cell in each direction."""
MAX_VERTICES: Final = ((MAX_MESH_POINTS - 1) * SUBDIVISIONS) ** 2 * 6
"""Vertices of the largest mesh."""

Mesh = Sequence[Sequence[Point]]


def regular_mesh(columns: int, rows: int) -> tuple[tuple[Point, ...], ...]:
    """Return the regular mesh, which does not warp."""
    return tuple(tuple((i / (columns - 1), j / (rows - 1)) for i in range(columns)) for j in range(rows))


def check_mesh(mesh: Mesh) -> None:
    """Raise PersonError unless the mesh is a grid without folds."""
    rows, columns = len(mesh), len(mesh[0]) if mesh else 0
    if not mesh:
        return
    if any(len(row) != columns for row in mesh):
        raise PersonError(
            "the rows of the mesh have different numbers of points", f"{columns} in each, as in the first"
        )
    if not (MIN_MESH_POINTS <= columns <= MAX_MESH_POINTS and MIN_MESH_POINTS <= rows <= MAX_MESH_POINTS):
        raise PersonError(
            f"a mesh of {columns} by {rows} points",
            f"{MIN_MESH_POINTS} to {MAX_MESH_POINTS} points in a row and in a column",
        )
    points = np.array(mesh, np.float64)
    across, down = np.diff(points, axis=1), np.diff(points, axis=0)
    for i in (slice(None, -1), slice(1, None)):
        for j in (slice(None, -1), slice(1, None)):
            turn = across[j, :, 0] * down[:, i, 1] - across[j, :, 1] * down[:, i, 0]
            if turn.min() <= 0.0:
                row, column = (int(n) + 1 for n in np.argwhere(turn <= 0.0)[0])
                raise PersonError(
                    f"the mesh folds over at row {row}, column {column}", "keep neighbouring points in their order"
                )


def warp_grid(mesh: Mesh, across: Float64, down: Float64) -> Float64:
    """Return the warped places of a regular grid: for shares `across` (m,) and `down` (n,), shape (n, m, 2).

    Uses Catmull-Rom splines through the points. They keep straight lines straight: the regular mesh does not warp.
    """
    points = np.array(mesh, np.float64)
    along: Float64 = _spline(points, down)
    result: Float64 = _spline(along.swapaxes(0, 1), across).swapaxes(0, 1)
    return result


def unwarp_point(mesh: Mesh, place: Point) -> Point:
    """Return the point of the regular frame that is drawn at a place of the warped one (inverse of the warp).

    Uses the same triangles that are drawn. Outside the mesh the nearest triangle is extrapolated.
    """
    if not mesh:
        return place
    corners, shares = _triangles(tuple(tuple(row) for row in mesh))
    inside = (shares @ (*place, 1.0)).reshape(3, -1)  # barycentric coordinates in each triangle
    nearest = int(np.minimum(np.minimum(inside[0], inside[1]), inside[2]).argmax())
    u, v = inside[:, nearest] @ corners[nearest]
    return float(u), float(v)


@lru_cache(maxsize=8)
def _triangles(mesh: tuple[tuple[Point, ...], ...]) -> tuple[Float64, Float64]:
    """Return the corners of the drawn triangles in the regular frame (T, 3, 2), and the matrix (3 T, 3) from (x, y, 1)
    to the barycentric coordinates of the first, second and third corners of all triangles."""
    grids = []
    across, down = _grid_lines(mesh)
    for grid in (warp_grid(mesh, across, down), np.stack(np.meshgrid(across, down), axis=-1)):
        a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
        grids.append(np.stack([a, b, c, a, c, d], axis=2).reshape(-1, 3, 2))
    there, corners = grids
    square = np.concatenate([there, np.ones((*there.shape[:2], 1))], axis=2).swapaxes(1, 2)
    flat = np.abs(np.linalg.det(square)) < 1e-12  # degenerate to a line: contains no point
    square[flat] = np.eye(3)
    shares = np.linalg.inv(square)
    shares[flat] = -1e9
    return corners, np.ascontiguousarray(shares.swapaxes(0, 1).reshape(-1, 3))


def _grid_lines(mesh: Mesh) -> tuple[Float64, Float64]:
    """Return the grid lines of the subdivided mesh as shares of the frame, across and down."""
    columns, rows = len(mesh[0]), len(mesh)
    return np.linspace(0.0, 1.0, (columns - 1) * SUBDIVISIONS + 1), np.linspace(0.0, 1.0, (rows - 1) * SUBDIVISIONS + 1)


def _spline(points: Float64, shares: Float64) -> Float64:
    """Evaluate a spline along the first axis of (k, ..., 2) at shares (s,) from its first to its last point."""
    count = len(points)
    wide = np.concatenate([2.0 * points[:1] - points[1:2], points, 2.0 * points[-1:] - points[-2:-1]])
    place = np.clip(shares, 0.0, 1.0) * (count - 1)
    cell = np.minimum(place.astype(np.intp), count - 2)
    t = (place - cell).reshape(-1, *[1] * (points.ndim - 1))
    p0, p1, p2, p3 = (wide[cell + n] for n in range(4))
    result: Float64 = p1 + 0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)))
    return result


def vertices(output: Output) -> Float32:
    """Return the triangle vertices of an output: (x w, y w, w, u, v) with (x, y) in the window and (u, v) in the
    frame, shape (V, 5). The GPU divides by w, so the corner pin is exact in every pixel."""
    if output.mesh:
        across, down = _grid_lines(output.mesh)
        places = warp_grid(output.mesh, across, down)
    else:
        across = down = np.array([0.0, 1.0])
        places = np.stack(np.meshgrid(across, down), axis=-1)
    through = np.concatenate([places, np.ones((*places.shape[:2], 1))], axis=-1) @ homography(output.corners).T
    grid = np.concatenate([through, np.stack(np.meshgrid(across, down), axis=-1)], axis=-1)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.stack([a, b, c, a, c, d], axis=2).reshape(-1, 5).astype(np.float32)
