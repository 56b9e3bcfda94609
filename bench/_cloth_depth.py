"""How deep points are in the body of a dancer who moves: the implicit surface of the body as it is drawn.

A point goes with the nearest vertex of the skin back into the rest pose, where the surface is known exactly.
"""

from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from live.base.arrays import Bool, Float32, Float64
from live.motion.skeleton import SKELETON
from live.render.body.body_mesh import FINE, build_body, skeleton_weights
from live.render.body.body_variants import parts_of
from live.render.body.implicit_surface import Shape

NEAR: Final = 0.05
"""Points farther from the skin [m] are not measured: they are outside."""
_BEFORE: Final = (0.015, 0.03, 0.045, 0.06)
"""So far in front of the skin [m] other flesh covers it."""
_REST: Final = SKELETON.rest_positions().astype(np.float64)


class SkinDepth:
    """The body `name`; its muscles and fingers go with the joints that they hang on."""

    def __init__(self, name: str) -> None:
        mesh = build_body(FINE, name)
        self._vertices, self._normal = mesh.position.astype(np.float64), mesh.normal.astype(np.float64)
        self._joint, weight = skeleton_weights(mesh)
        self._weight = weight.astype(np.float64)
        self._shape = Shape(parts_of(name))

    def distance(self, points: Float64, position: Float32, rotation: Float32) -> Float64:
        """Return the distance of points (N, 3) [m] from the skin of a dancer, negative inside, at most about NEAR.

        position (J, 3), rotation (J, 4): the dancer's joints. Skin as drawn: dual quaternions (Kavan et al. 2007).
        """
        _, back, skin = self._posed(position, rotation)
        away, nearest = cKDTree(skin).query(points, distance_upper_bound=NEAR)
        out = np.full(len(points), NEAR)
        near = np.flatnonzero(np.isfinite(away))
        if len(near):
            at = nearest[near]
            rest = self._vertices[at] + _turned(back[at], points[near] - skin[at])
            out[near] = self._shape.distance(rest)
        return out

    def is_covered(self, points: Float64, position: Float32, rotation: Float32) -> Bool:
        """Return whether flesh lies in front of the skin nearest to points (N, 3) inside the body, as in the bend of an
        elbow: nobody sees there what of cloth is inside."""
        turn, _, skin = self._posed(position, rotation)
        at = cKDTree(skin).query(points)[1]
        normal = _turned(turn[at], self._normal[at])
        before = [self.distance(skin[at] + far * normal, position, rotation) < 0.0 for far in _BEFORE]
        return np.asarray(np.any(before, axis=0))

    def _posed(self, position: Float32, rotation: Float32) -> tuple[Float64, Float64, Float64]:
        """Return the turns of the vertices, their inverses, (N, 4), and the skin (N, 3) [m]."""
        q = rotation.astype(np.float64)
        moved = position.astype(np.float64) - _turned(q, _REST)
        dual = 0.5 * _product(np.concatenate([np.zeros((len(q), 1)), moved], axis=1), q)
        real, dual = q[self._joint], dual[self._joint]
        share = self._weight * np.where((real * real[:, :1]).sum(-1) < 0.0, -1.0, 1.0)
        turn, dual = (share[..., None] * real).sum(1), (share[..., None] * dual).sum(1)
        size = np.linalg.norm(turn, axis=1, keepdims=True)
        turn, dual = turn / size, dual / size
        back = turn * np.array([1.0, -1.0, -1.0, -1.0])
        skin = _turned(turn, self._vertices) + 2.0 * _product(dual, back)[:, 1:]
        return turn, back, skin


def between(grid: Float64, *, closed: bool, parts: int = 3) -> Float64:
    """Return points of the sheet of a garment (rows, columns, 3): its particles and those between them, (N, 3)."""
    if closed:
        grid = np.concatenate([grid, grid[:, :1]], axis=1)
    shares = [(a / parts, b / parts) for a in range(parts) for b in range(parts)]
    points = [
        (1 - a) * (1 - b) * grid[:-1, :-1]
        + a * (1 - b) * grid[1:, :-1]
        + (1 - a) * b * grid[:-1, 1:]
        + a * b * grid[1:, 1:]
        for a, b in shares
    ]
    return np.concatenate([one.reshape(-1, 3) for one in points])


def _product(a: Float64, b: Float64) -> Float64:
    """Return the product of quaternions (w, x, y, z)."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )  # fmt: skip


def _turned(q: Float64, v: Float64) -> Float64:
    """Return vectors, rotated."""
    t = 2.0 * np.cross(q[..., 1:], v)
    return np.asarray(v + q[..., :1] * t + np.cross(q[..., 1:], t))
