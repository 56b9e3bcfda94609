"""Neighbours in a group: the Delaunay graph of its places, and how many of its edges another arrangement keeps (T145).

Takahashi et al. 2009 and Kwon et al. 2008 take the edges of the Delaunay triangulation as the adjacency of a formation.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64

FLAT: Final = 1e-7
"""Places that leave a straight line by less than this share of its length are a row."""
FLAT_SINE: Final = 0.1
"""Triangles with a smallest angle of this sine are flat: corners of a line, no neighbours across."""
ON_CIRCLE: Final = 1e-5
"""Four places whose opposite angles exceed half a turn by less stand on a circle [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """Who is beside whom among D places."""

    edges: Int64
    """Pairs of neighbours, (E, 2), the lower number first, sorted."""
    inner: Int64
    """Of each edge between two triangles that are not flat, its ends and the third corners of both, (I, 4)."""
    side: Float64
    """On which side of the directed edge the third corners lie, 1 or -1, (I, 2)."""

    def share_kept(self, after: Float64) -> float:
        """Return the share of the edges that are edges of the Delaunay graph of places `after` (D, 2), 0 to 1.

        Where four stand on a circle, such as in a grid, either diagonal is one.
        """
        if not len(self.edges):
            return 1.0
        size = len(after)
        now = _delaunay_edges(after)
        number = self.edges[:, 0] * size + self.edges[:, 1]
        kept = np.isin(number, now[:, 0] * size + now[:, 1])
        angle = opposite_angles(self.inner, self.side, after).sum(axis=0)
        fine = self.inner[angle <= np.pi + ON_CIRCLE]
        return float((kept | np.isin(number, fine[:, 0] * size + fine[:, 1])).mean())


def opposite_angles(inner: Int64, side: Float64, places: Float64) -> Float64:
    """Return the two angles opposite to each inner edge, (2, I) [rad]; more than half a turn where a triangle has
    turned over."""
    angles = np.zeros((2, len(inner)))
    for corner in (0, 1):
        third = places[inner[:, 2 + corner]]
        u, v = places[inner[:, 0]] - third, places[inner[:, 1]] - third
        angle = np.arctan2(side[:, corner] * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]), (u * v).sum(axis=1))
        angles[corner] = np.where(angle < -0.5, angle + 2.0 * np.pi, angle)
    return angles


def neighbours_of(places: Float64, *, mirrored: bool = False) -> Neighbours:
    """Return the neighbours among `places` (D, 2) [m]: the edges of all Delaunay triangles that are not flat, and each
    one's nearest. In a row each has the next one; two are neighbours. `mirrored`: as they are in a mirror."""
    from scipy.spatial import Delaunay, cKDTree

    none = np.zeros((0, 4), np.int64), np.zeros((0, 2))
    order = _row_order(places)
    if order is not None:
        return Neighbours(_sorted(_chain(order)), *none)
    corners = Delaunay(places - places.mean(axis=0)).simplices.astype(np.int64)
    corners = corners[_smallest_sine(places[corners]) > FLAT_SINE]
    nearest = cKDTree(places).query(places, k=2)[1]
    nearest = nearest[nearest[:, 0] != nearest[:, 1]]
    ends = np.concatenate([corners[:, [1, 2]], corners[:, [2, 0]], corners[:, [0, 1]]])
    third = np.concatenate([corners[:, 0], corners[:, 1], corners[:, 2]])
    ends.sort(axis=1)
    rank = np.lexsort((third, ends[:, 1], ends[:, 0]))
    ends, third = ends[rank], third[rank]
    twice = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1))
    inner = np.column_stack([ends[twice], third[twice], third[twice + 1]])
    edges = np.concatenate([ends, np.sort(nearest, axis=1)])
    a, b = places[inner[:, 0]], places[inner[:, 1]]
    side = np.stack([_side(a, b, places[inner[:, k]]) for k in (2, 3)], axis=1)
    return Neighbours(_sorted(edges), inner, -side if mirrored else side)


def _delaunay_edges(places: Float64) -> Int64:
    """Return all edges of the Delaunay graph of `places` (D, 2), the lower number first, (E, 2)."""
    from scipy.spatial import Delaunay

    order = _row_order(places)
    if order is not None:
        return _chain(order)
    found = Delaunay(places - places.mean(axis=0))
    corners, hidden = found.simplices.astype(np.int64), found.coplanar[:, [0, 2]].astype(np.int64)
    return np.sort(np.concatenate([corners[:, :2], corners[:, 1:], corners[:, [0, 2]], hidden]), axis=1)


def _chain(order: Int64) -> Int64:
    return np.sort(np.stack([order[:-1], order[1:]], axis=1), axis=1)


def _smallest_sine(corners: Float64) -> Float64:
    """Return the sine of the smallest angle of triangles (T, 3, 2), (T,)."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    sides = np.sort(np.stack([np.hypot(*u.T), np.hypot(*v.T), np.hypot(*(v - u).T)]), axis=0)
    return np.asarray(np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / np.maximum(sides[1] * sides[2], 1e-12))


def _row_order(places: Float64) -> Int64 | None:
    """Return the order of places along their line if they stand in a row (or are fewer than three), else None."""
    from scipy.spatial import Delaunay, QhullError

    if len(places) < 2:
        return np.arange(len(places))
    offset = places - places.mean(axis=0)
    _, width, axes = np.linalg.svd(offset, full_matrices=False)
    if len(places) > 2 and width[1] > FLAT * max(float(width[0]), 1e-9):
        try:
            Delaunay(offset)
        except QhullError:
            pass
        else:
            return None
    return np.argsort(offset @ axes[0], kind="stable")


def _sorted(edges: Int64) -> Int64:
    return np.unique(edges, axis=0) if len(edges) else edges.reshape(0, 2)


def _side(a: Float64, b: Float64, c: Float64) -> Float64:
    """Return 1 where c lies to the left of the way from a to b, else -1, (K,)."""
    u, v = a - c, b - c
    return np.where(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] < 0.0, -1.0, 1.0)
