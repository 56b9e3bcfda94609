"""Mesh simplification by edge collapse with quadric errors (Garland and Heckbert 1997), and Catmull-Clark subdivision
(Catmull and Clark 1978) of closed meshes, with any vertex data.

Simplification removes vertices and moves none, so their data stays valid. Edges collapse in mirrored pairs, so a
symmetric mesh stays symmetric; a closed mesh stays closed.
"""

import numpy as np

from live.base.arrays import Bool, Float64, Int64
from live.render.body.mesh_simplify_kernels import collapse_cheapest, nearest_mirrored


def mirror_partners(points: Float64) -> Int64:
    """Return for each point the index of the point nearest to its mirror image in the plane x = 0."""
    partner = np.empty(len(points), np.int64)
    nearest_mirrored(np.ascontiguousarray(points, np.float64), np.argsort(points[:, 1], kind="stable"), partner)
    return partner


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


def simplify(
    points: Float64, triangles: Int64, vertex_data: Float64, target_count: int, fixed: Bool | None = None
) -> tuple[Int64, Int64]:
    """Return kept vertices (indices into `points`), and about `target_count` triangles among them, or more if needed.

    `vertex_data` (V, C): vertex data (joint weights); collapses between different values cost more; `fixed` (V,): these
    vertices stay.
    The mesh [m] must be closed and symmetric about x = 0.
    """
    points, left = np.ascontiguousarray(points, np.float64), np.array(triangles, np.int64, order="C")
    first, following = _corner_lists(left, len(points))
    stay = np.zeros(len(points), np.bool_) if fixed is None else np.ascontiguousarray(fixed, np.bool_)
    collapse_cheapest(
        points, _quadrics(points, left), np.ascontiguousarray(vertex_data, np.float64), mirror_partners(points), stay,
        target_count, left, first, following,
    )  # fmt: skip
    left = left[left[:, 0] >= 0]
    used = np.unique(left)
    return used, np.searchsorted(used, left)


def _corner_lists(triangles: Int64, count: int) -> tuple[Int64, Int64]:
    """Return the linked lists of each vertex's corners: `first` (V,) and `following` (3T,)."""
    vertex = triangles.ravel()
    order = np.argsort(vertex, kind="stable")
    first, following = np.full(count, -1, np.int64), np.full(len(vertex), -1, np.int64)
    same = vertex[order[1:]] == vertex[order[:-1]]
    following[order[:-1][same]] = order[1:][same]
    begins = np.concatenate([[True], ~same])
    first[vertex[order[begins]]] = order[begins]
    return first, following


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
    keys, edge_number = np.unique(np.minimum(start, stop) * count + np.maximum(start, stop), return_inverse=True)
    edges = np.stack([keys // count, keys % count], axis=1)
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
