"""Closed triangle meshes from simple shapes: balls, grids, fans; their orientation and normals."""

import numpy as np

from live.base.arrays import Float64, Int64


def vertex_normals(points: Float64, triangles: Int64) -> Float64:
    """Return normals weighted by the triangles' angles (Thürmer and Wüthrich 1998)."""
    normals = np.zeros_like(points)
    corners = points[triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
    for k in range(3):
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        size = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
        angle = np.arccos(np.clip((a * b).sum(axis=1) / np.maximum(size, 1e-12), -1.0, 1.0))
        np.add.at(normals, triangles[:, k], flat * angle[:, None])
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12))


def quads_to_triangles(faces: Int64) -> Int64:
    """Split quadrilaterals; mirrored ones, which begin at the same corner, are split alike."""
    return np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])


def faced_outward(points: Float64, triangles: Int64) -> Int64:
    """Return the triangles of a closed mesh turned so that they face outward."""
    a, b, c = (points[triangles[:, k]] - points.mean(axis=0) for k in range(3))
    return triangles if (np.cross(a, b) * c).sum() > 0.0 else triangles[:, ::-1]


def ball(rings: int, segments: int) -> tuple[Float64, Int64]:
    """Return a unit sphere with its poles on the z axis: points (V, 3), triangles (T, 3)."""
    turn = 2.0 * np.pi * np.arange(segments) / segments
    points = [[0.0, 0.0, 1.0]]
    for ring in range(1, rings):
        angle = np.pi * ring / rings
        points += [[np.sin(angle) * np.cos(a), np.sin(angle) * np.sin(a), np.cos(angle)] for a in turn]
    points.append([0.0, 0.0, -1.0])
    triangles = []
    last = len(points) - 1
    for k in range(segments):
        n = (k + 1) % segments
        triangles.append([0, 1 + k, 1 + n])
        for ring in range(rings - 2):
            a, b = 1 + ring * segments, 1 + (ring + 1) * segments
            triangles += [[a + k, b + k, b + n], [a + k, b + n, a + n]]
        triangles.append([1 + (rings - 2) * segments + k, last, 1 + (rings - 2) * segments + n])
    return np.array(points), np.array(triangles, np.int64)


def grid_triangles(rows: int, columns: int, *, around: bool) -> Int64:
    """Return triangles of a grid of points, row by row; `around`: its last column meets the first."""
    found = []
    for r in range(rows - 1):
        for c in range(columns if around else columns - 1):
            n = (c + 1) % columns
            a, b, d, e = r * columns + c, r * columns + n, (r + 1) * columns + n, (r + 1) * columns + c
            found += [[a, b, d], [a, d, e]]
    return np.array(found, np.int64).reshape(-1, 3)


def fan(first: int, count: int, apex: int, *, turned: bool) -> Int64:
    """Return triangles between a loop of `count` points from `first` on and a point `apex`."""
    loop = np.arange(count)
    one = np.column_stack([first + loop, first + (loop + 1) % count, np.full(count, apex)])
    return np.asarray(one[:, ::-1] if turned else one, np.int64)


def catmull_rom(points: Float64, at: Float64) -> Float64:
    """Return points between the rows of `points` (N, …) at fractional rows (Catmull and Rom 1974)."""
    last = len(points) - 1
    low = np.clip(np.floor(at).astype(np.int64), 0, last - 1)
    around = [points[np.clip(low + step, 0, last)] for step in (-1, 0, 1, 2)]
    return spline(around, (at - low).reshape(-1, *[1] * (points.ndim - 1)))


def spline(four: list[Float64], t: Float64) -> Float64:
    """Return points between the second and the third of four at shares `t` of a spline (Catmull and Rom 1974)."""
    a, b, c, d = four
    return np.asarray(
        0.5 * (2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * t**2 + (3.0 * b - a - 3.0 * c + d) * t**3)
    )
