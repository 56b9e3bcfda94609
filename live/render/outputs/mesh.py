"""Mesh: a grid of points that bends the frame smoothly, and the triangles that are drawn of it."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.render.outputs.corner_pin import homography
from live.render.outputs.output import MESH_LEAST, MESH_MOST, Output, Point

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

PIECES: Final = 12
"""Each cell of a mesh is drawn in so many pieces each way."""
MOST_VERTICES: Final = ((MESH_MOST - 1) * PIECES) ** 2 * 6
"""Vertices of the largest mesh."""

Mesh = Sequence[Sequence[Point]]


def regular(columns: int, rows: int) -> tuple[tuple[Point, ...], ...]:
    """The mesh of so many points that bends nothing."""
    return tuple(tuple((i / (columns - 1), j / (rows - 1)) for i in range(columns)) for j in range(rows))


def check_mesh(mesh: Mesh) -> None:
    """PersonError unless the mesh is a grid that nowhere folds over."""
    rows, columns = len(mesh), len(mesh[0]) if mesh else 0
    if not mesh:
        return
    if any(len(row) != columns for row in mesh):
        raise PersonError(
            "the rows of the mesh have different numbers of points", f"{columns} in each, as in the first"
        )
    if not (MESH_LEAST <= columns <= MESH_MOST and MESH_LEAST <= rows <= MESH_MOST):
        raise PersonError(
            f"a mesh of {columns} by {rows} points", f"{MESH_LEAST} to {MESH_MOST} points in a row and in a column"
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


def bent(mesh: Mesh, across: Float64, down: Float64) -> Float64:
    """Where points of the regular frame lie: for shares `across` (m,) and `down` (n,) places of shape (n, m, 2).

    Catmull-Rom splines through the points, which keep straight what is straight: the regular mesh bends nothing.
    """
    points = np.array(mesh, np.float64)
    along: Float64 = _spline(points, down)
    result: Float64 = _spline(along.swapaxes(0, 1), across).swapaxes(0, 1)
    return result


def unbent(mesh: Mesh, place: Point) -> Point:
    """Which point of the regular frame is drawn at a place of the bent one: in the very triangles that are drawn.

    Beside the mesh, where nothing is drawn, the nearest triangle goes on.
    """
    if not mesh:
        return place
    corners, shares = _triangles(tuple(tuple(row) for row in mesh))
    inside = (shares @ (*place, 1.0)).reshape(3, -1)  # how much each triangle's corners count
    nearest = int(np.minimum(np.minimum(inside[0], inside[1]), inside[2]).argmax())
    u, v = inside[:, nearest] @ corners[nearest]
    return float(u), float(v)


@lru_cache(maxsize=8)
def _triangles(mesh: tuple[tuple[Point, ...], ...]) -> tuple[Float64, Float64]:
    """Corners of the drawn triangles in the regular frame (T, 3, 2), and what takes (x, y, 1) to how much the
    first, second and third corners of all count, (3 T, 3)."""
    grids = []
    across, down = _shares(mesh)
    for grid in (bent(mesh, across, down), np.stack(np.meshgrid(across, down), axis=-1)):
        a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
        grids.append(np.stack([a, b, c, a, c, d], axis=2).reshape(-1, 3, 2))
    there, corners = grids
    square = np.concatenate([there, np.ones((*there.shape[:2], 1))], axis=2).swapaxes(1, 2)
    flat = np.abs(np.linalg.det(square)) < 1e-12  # folded to a line: nobody can point at it
    square[flat] = np.eye(3)
    shares = np.linalg.inv(square)
    shares[flat] = -1e9
    return corners, np.ascontiguousarray(shares.swapaxes(0, 1).reshape(-1, 3))


def _shares(mesh: Mesh) -> tuple[Float64, Float64]:
    """The shares of the frame, across and down, between which pieces are drawn."""
    columns, rows = len(mesh[0]), len(mesh)
    return np.linspace(0.0, 1.0, (columns - 1) * PIECES + 1), np.linspace(0.0, 1.0, (rows - 1) * PIECES + 1)


def _spline(points: Float64, shares: Float64) -> Float64:
    """A spline along the first axis of (k, ..., 2) at shares (s,) of the way from its first to its last point."""
    count = len(points)
    wide = np.concatenate([2.0 * points[:1] - points[1:2], points, 2.0 * points[-1:] - points[-2:-1]])
    place = np.clip(shares, 0.0, 1.0) * (count - 1)
    cell = np.minimum(place.astype(np.intp), count - 2)
    t = (place - cell).reshape(-1, *[1] * (points.ndim - 1))
    p0, p1, p2, p3 = (wide[cell + n] for n in range(4))
    result: Float64 = p1 + 0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)))
    return result


def vertices(output: Output) -> Float32:
    """What is drawn of an output: triangles' corners (x w, y w, w, u, v) with (x, y) in the window and (u, v) in the
    frame, shape (V, 5). The card divides by w, which makes the corner pin exact in every pixel."""
    if output.mesh:
        across, down = _shares(output.mesh)
        places = bent(output.mesh, across, down)
    else:
        across = down = np.array([0.0, 1.0])
        places = np.stack(np.meshgrid(across, down), axis=-1)
    through = np.concatenate([places, np.ones((*places.shape[:2], 1))], axis=-1) @ homography(output.corners).T
    grid = np.concatenate([through, np.stack(np.meshgrid(across, down), axis=-1)], axis=-1)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.stack([a, b, c, a, c, d], axis=2).reshape(-1, 5).astype(np.float32)
