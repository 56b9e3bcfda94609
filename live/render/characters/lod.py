"""Simplification of characters by vertex clustering (Rossignac and Borrel 1993), with the place of each cell that fits
the planes of its triangles best (Lindstrom 2000, Out-of-core simplification): means alone would thin limbs.

Cells are smaller at trunk, head, hands and feet. All vertices in a cell share a position, but only connected ones share
texture coordinates, so the surface does not tear and no colour crosses a seam.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion.skeleton import JOINT_COUNT, SKELETON

_DETAIL_FACTORS: Final = {
    "head": 2.0,
    "Hand": 1.7,
    "hips": 1.3,
    "spine": 1.3,
    "hest": 1.3,
    "Toes": 1.5,
    "Foot": 1.3,
    "neck": 1.3,
}
_ITERATIONS: Final = 14
_SMALLEST: Final = 0.002
_LARGEST: Final = 0.25
_TOWARDS_MEAN: Final = 0.1
"""Weight of a cell's mean beside its planes: where these say nothing, as on a flat place, the mean is kept."""


@dataclass(frozen=True, slots=True, eq=False)
class SimplifiedMesh:
    """Simplified mesh: which old vertices each new one averages, and the new triangles."""

    group: Int64
    """New vertex for each old one, shape (V,)."""
    cell_of_vertex: Int64
    """Cell of each new vertex, shape (N,)."""
    cell: Int64
    """Cell of each old vertex, shape (V,)."""
    triangle: Int64
    """Indices of new vertices, shape (T, 3)."""

    def mean(self, values: Float64) -> Float64:
        """Return means over the old vertices of each new one, (V, C) to (N, C)."""
        return _mean(values, self.group)

    def mean_positions(self, position: Float64) -> Float64:
        """Return means over cells, for every new vertex, (V, 3) to (N, 3)."""
        return np.asarray(_mean(position, self.cell)[self.cell_of_vertex])

    def surface_positions(self, position: Float64, triangle: Int64) -> Float64:
        """Return for every new vertex the place (N, 3) [m] nearest to the planes of the old triangles (T, 3) at its
        cell, by the squares of their areas; old vertices are at position (V, 3)."""
        mean = _mean(position, self.cell)
        corner = position[triangle]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        form, pull = np.zeros((len(mean), 3, 3)), np.zeros((len(mean), 3))
        for cell in self.cell[triangle].T:
            off = ((corner[:, 0] - mean[cell]) * normal).sum(axis=1)
            np.add.at(form, cell, normal[:, :, None] * normal[:, None, :])
            np.add.at(pull, cell, normal * off[:, None])
        form += (_TOWARDS_MEAN * np.trace(form, axis1=1, axis2=2) + 1e-18)[:, None, None] * np.eye(3)
        move = np.linalg.solve(form, pull[..., None])[..., 0]
        reach = np.zeros(len(mean))
        np.maximum.at(reach, self.cell, np.linalg.norm(position - mean[self.cell], axis=1))
        length = np.linalg.norm(move, axis=1)
        move *= np.minimum(1.0, 0.5 * reach / np.maximum(length, 1e-12))[:, None]
        return np.asarray((mean + move)[self.cell_of_vertex])


def simplify_to(
    position: Float64, weight: Float64, material: Int64, triangle: Int64, max_triangles: int
) -> SimplifiedMesh:
    """Return the finest level with at most `max_triangles` triangles; different `material` (V,) stays separate."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ends = np.concatenate([triangle[:, [0, 1]], triangle[:, [1, 2]]])
    links = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(len(position),) * 2)
    island = connected_components(links, directed=False)[1] * (int(material.max()) + 1) + material
    main = weight.argmax(axis=1)
    finer = np.array([_detail_factor(name) for name in SKELETON.names])[main][:, None]
    low, high = _SMALLEST, _LARGEST
    best = _level(position, main, island, triangle, finer, _LARGEST)
    for _ in range(_ITERATIONS):
        size = 0.5 * (low + high)
        level = _level(position, main, island, triangle, finer, size)
        if len(level.triangle) <= max_triangles:
            high, best = size, level
        else:
            low = size
    return best


def _detail_factor(name: str) -> float:
    return next((by for word, by in _DETAIL_FACTORS.items() if name.endswith(word)), 1.0)


def _level(
    position: Float64, main: Int64, island: Int64, triangle: Int64, finer: Float64, size: float
) -> SimplifiedMesh:
    # a cell's middle is in the plane x = 0, or the last bits there would decide which cell a vertex is in
    grid = np.floor(position * finer / size + np.array([0.5, 0.0, 0.0])).astype(np.int64) + 4096
    key = ((grid[:, 0] * 8192 + grid[:, 1]) * 8192 + grid[:, 2]) * JOINT_COUNT + main
    cell = np.unique(key, return_inverse=True)[1].reshape(-1)
    both, group = np.unique(cell * (int(island.max()) + 1) + island, return_inverse=True)
    group = group.reshape(-1)
    corners = cell[triangle]
    whole = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 2] != corners[:, 0])
    kept = group[triangle[whole]]
    first = np.argmin(kept, axis=1)[:, None]
    kept = np.unique(np.take_along_axis(kept, (first + np.arange(3)) % 3, axis=1), axis=0)
    return SimplifiedMesh(group, both // (int(island.max()) + 1), cell, kept)


def _mean(values: Float64, group: Int64) -> Float64:
    count = np.bincount(group)
    return np.column_stack([np.bincount(group, column) / count for column in values.T])
