"""Mesh simplification by edge collapse with quadric errors (Garland and Heckbert 1997), and Catmull-Clark subdivision
(Catmull and Clark 1978) of closed meshes, with any vertex data.

Simplification removes vertices and moves none, so their data stays valid. Edges collapse in mirrored pairs, so a
symmetric mesh stays symmetric; a closed mesh stays closed.
"""

import heapq
import math
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64, Int64

_DATA_COST: Final = 2e-4
"""Cost of a full change of weights along a metre [m^4]."""
_FLIP: Final = 0.25
"""A triangle must not rotate by more than the angle with this cosine."""


def mirror_partners(points: Float64) -> Int64:
    """Return for each point the index of the point nearest to its mirror image in the plane x = 0."""
    image = points * np.array([-1.0, 1.0, 1.0])
    squared = (points**2).sum(axis=1)[:, None] + (image**2).sum(axis=1)[None, :] - 2.0 * points @ image.T
    return np.asarray(squared.argmin(axis=0), np.int64)


def _quadrics(points: Float64, triangles: Int64) -> Float64:
    """Return per vertex the sum of its triangles' squared-distance forms, weighted by area, shape (V, 4, 4)."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    area = np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    normal /= area
    plane = np.concatenate([normal, -(normal * a).sum(axis=1, keepdims=True)], axis=1)
    form = plane[:, :, None] * plane[:, None, :] * area[:, :, None]
    total = np.zeros((len(points), 4, 4))
    for corner in range(3):
        np.add.at(total, triangles[:, corner], form)
    return total


class _Mesh:
    """Triangle mesh that supports edge collapse."""

    def __init__(self, points: Float64, triangles: Int64, vertex_data: Float64) -> None:
        self.points = points
        self.faces: dict[int, tuple[int, int, int]] = dict(enumerate(map(tuple, triangles.tolist())))
        self.faces_of: list[set[int]] = [set() for _ in range(len(points))]
        for face, corners in self.faces.items():
            for corner in corners:
                self.faces_of[corner].add(face)
        self.quadric = _quadrics(points, triangles)
        self.homogeneous = np.concatenate([points, np.ones((len(points), 1))], axis=1)
        self._vertex_data = vertex_data

    def neighbours(self, vertex: int) -> set[int]:
        found = {corner for face in self.faces_of[vertex] for corner in self.faces[face]}
        found.discard(vertex)
        return found

    def cost(self, gone: int, kept: int) -> float:
        """Return the cost of collapsing `gone` onto `kept`: quadric error, and difference of vertex data."""
        at = self.homogeneous[kept]
        shape = float(at @ (self.quadric[gone] + self.quadric[kept]) @ at)
        apart = float(np.abs(self._vertex_data[gone] - self._vertex_data[kept]).sum())
        return shape + _DATA_COST * math.dist(self.points[gone], self.points[kept]) * (0.2 + apart)

    def allowed(self, gone: int, kept: int) -> bool:
        """Whether the mesh stays closed and no triangle flips."""
        around_gone, around_kept = self.neighbours(gone), self.neighbours(kept)
        if len(around_gone & around_kept) != 2 or len(around_gone | around_kept) <= 4:
            return False  # the mesh would become non-manifold, or a tetrahedron degenerate
        for face in self.faces_of[gone]:
            corners = self.faces[face]
            if kept in corners:
                continue
            moved = [kept if corner == gone else corner for corner in corners]
            before, after = _normal(self.points[list(corners)]), _normal(self.points[moved])
            if before @ after < _FLIP * np.sqrt((before @ before) * (after @ after)) or after @ after < 1e-16:
                return False
        return True

    def collapse(self, gone: int, kept: int) -> None:
        for face in list(self.faces_of[gone]):
            corners = self.faces[face]
            if kept in corners:
                del self.faces[face]
                for corner in corners:
                    self.faces_of[corner].discard(face)
            else:
                self.faces[face] = tuple(kept if c == gone else c for c in corners)  # type: ignore[assignment]
                self.faces_of[kept].add(face)
        self.faces_of[gone].clear()
        self.quadric[kept] += self.quadric[gone]


def _normal(corners: Float64) -> Float64:
    ux, uy, uz = (corners[1] - corners[0]).tolist()
    vx, vy, vz = (corners[2] - corners[0]).tolist()
    return np.array([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx])


class _CollapseQueue:
    """Priority queue of possible collapses, cheapest first; entries of changed vertices are stale."""

    def __init__(self, mesh: _Mesh, partner: list[int], fixed: Bool) -> None:
        self._mesh, self._partner, self._fixed = mesh, partner, fixed.tolist()
        self._heap: list[tuple[float, int, int, int, int]] = []
        self._version = [0] * len(mesh.points)

    def push(self, vertex: int) -> None:
        """Add every collapse along the edges of a vertex."""
        for other in self._mesh.neighbours(vertex):
            for gone, kept in ((vertex, other), (other, vertex)):
                if self._fixed[gone]:
                    continue
                if self._partner[gone] != gone or self._partner[kept] == kept:  # vertices at x = 0 stay there
                    versions = self._version[gone], self._version[kept]
                    heapq.heappush(self._heap, (self._mesh.cost(gone, kept), gone, kept, *versions))

    def pop(self) -> tuple[int, int] | None:
        """Remove and return the cheapest collapse that is not stale, or None."""
        while self._heap:
            _, gone, kept, at_gone, at_kept = heapq.heappop(self._heap)
            if self._version[gone] == at_gone and self._version[kept] == at_kept:
                return gone, kept
        return None

    def invalidate(self, gone: int, kept: int) -> None:
        """Mark entries of `gone` and of all vertices around `kept` as stale."""
        self._version[gone] = -1
        for one in self._mesh.neighbours(kept) | {kept}:
            self._version[one] += 1


def simplify(
    points: Float64, triangles: Int64, vertex_data: Float64, target_count: int, fixed: Bool | None = None
) -> tuple[Int64, Int64]:
    """Return kept vertices (indices into `points`), and about `target_count` triangles among them, or more if needed.

    `vertex_data` (V, C): vertex data (joint weights); collapses between different values cost more; `fixed` (V,): these
    vertices stay.
    The mesh [m] must be closed and symmetric about x = 0.
    """
    mesh = _Mesh(points, triangles, vertex_data)
    partner = mirror_partners(points).tolist()
    queue = _CollapseQueue(mesh, partner, np.zeros(len(points), np.bool_) if fixed is None else fixed)
    for vertex in np.flatnonzero(points[:, 0] >= -1e-9).tolist():
        queue.push(vertex)
    while len(mesh.faces) > target_count and (pair := queue.pop()) is not None:
        gone, kept = pair
        pairs = [pair] if partner[gone] == gone else [pair, (partner[gone], partner[kept])]
        if gone in pairs[-1][1:] or kept == partner[gone] or not all(mesh.allowed(*one) for one in pairs):
            continue
        for one in pairs:
            mesh.collapse(*one)
            queue.invalidate(*one)
        for vertex in mesh.neighbours(kept) | {kept}:
            queue.push(vertex)
    left = np.array(list(mesh.faces.values()), np.int64)
    used = np.unique(left)
    return used, np.searchsorted(used, left)


def subdivide(values: Float64, faces: Int64, chosen: Bool | None = None) -> tuple[Float64, Int64]:
    """Split each face of n corners into n; `values` (V, C): positions and other vertex data; `faces` (F, N): a face
    with fewer than N corners ends with -1.

    Returns the new values, old vertices first, and the new faces (-, 4) with the same orientation. With `chosen` (F,)
    only these are split; the others follow with up to 2N corners, those on a split edge included, and vertices without
    a face may be among the values.
    Raises ValueError if the mesh is not closed (an edge with other than two faces).
    """
    count = len(values)
    there = faces >= 0
    corners = there.sum(axis=1)
    column = np.arange(faces.shape[1])
    following = np.take_along_axis(faces, (column + 1) % corners[:, None], axis=1)
    start, stop = faces[there], following[there]
    pairs = np.stack([np.minimum(start, stop), np.maximum(start, stop)], axis=1)
    edges, edge_number = np.unique(pairs, axis=0, return_inverse=True)
    edge_of = np.zeros_like(faces)
    edge_of[there] = edge_number.reshape(-1)
    uses = np.bincount(edge_of[there], minlength=len(edges))
    if not np.all(uses == 2):
        raise ValueError(f"the mesh is not closed: {int((uses != 2).sum())} edges without exactly two faces")

    face_value = (values[faces] * there[:, :, None]).sum(axis=1) / corners[:, None]
    each = np.repeat(face_value, corners, axis=0)
    edge_faces = np.zeros((len(edges), values.shape[1]))
    np.add.at(edge_faces, edge_of[there], each)
    middle = values[edges].mean(axis=1)
    edge_value = 0.5 * middle + 0.25 * edge_faces

    valence = np.bincount(edges.ravel(), minlength=count)[:, None].astype(np.float64)
    face_sum = np.zeros_like(values)
    np.add.at(face_sum, start, each)
    edge_sum = np.zeros_like(values)
    np.add.at(edge_sum, edges.ravel(), np.repeat(middle, 2, axis=0))
    vertex_value = (face_sum / valence + 2.0 * edge_sum / valence + (valence - 3.0) * values) / valence

    edge_index = count + edge_of
    before = np.take_along_axis(edge_index, (column - 1) % corners[:, None], axis=1)
    centre = count + len(edges) + np.arange(len(faces))
    part = there if chosen is None else there & chosen[:, None]
    quads = np.concatenate(
        [np.stack([faces[:, i], edge_index[:, i], centre, before[:, i]], axis=1)[part[:, i]] for i in column.tolist()]
    )
    new_values = np.concatenate([vertex_value, edge_value, face_value])
    if chosen is None:
        return new_values, quads
    split = np.zeros(len(edges), np.bool_)
    split[edge_of[chosen]] = True
    left = faces[~chosen]
    around = np.stack([left, np.where((split[edge_of] & there)[~chosen], edge_index[~chosen], -1)], axis=2)
    around = around.reshape(len(left), 2 * faces.shape[1])
    around = np.take_along_axis(around, np.argsort(around < 0, axis=1, kind="stable"), axis=1)
    return new_values, np.concatenate([np.pad(quads, ((0, 0), (0, around.shape[1] - 4)), constant_values=-1), around])
