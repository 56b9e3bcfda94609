"""Tests of edge collapse: fewer triangles with the shape kept."""

import numpy as np
import numpy.typing as npt

from live.render.body.mesh_simplify import mirror_partners, simplify, subdivide

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]


def _sphere(levels: int) -> tuple[Float64, Int64]:
    signs = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
    points = np.array(signs, np.float64)
    faces = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2]], np.int64)
    for _ in range(levels):
        points, faces = subdivide(points, faces)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points, np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])


def _volume(points: Float64, triangles: Int64) -> float:
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return float((np.cross(a, b) * c).sum()) / 6.0


def test_simplified_sphere_stays_closed_at_target_triangle_count() -> None:
    points, triangles = _sphere(3)
    used, fewer = simplify(points, triangles, np.zeros((len(points), 1)), 300)
    assert len(fewer) <= 300
    assert len(fewer) > 280
    directed = {(int(t[i]), int(t[(i + 1) % 3])) for t in fewer for i in range(3)}
    assert len(directed) == 3 * len(fewer)
    assert all((b, a) in directed for a, b in directed)
    assert len(used) - len(fewer) // 2 == 2  # Euler: V - E + F = 2 with E = 3F/2
    assert _volume(points[used], fewer) > 0.93 * _volume(points, triangles)


def test_a_symmetric_mesh_stays_symmetric() -> None:
    points, triangles = _sphere(3)
    used, _ = simplify(points, triangles, np.zeros((len(points), 1)), 250)
    kept = points[used]
    partner = mirror_partners(kept)
    np.testing.assert_allclose(kept[partner] * [-1.0, 1.0, 1.0], kept, atol=1e-9)


def test_more_vertices_stay_where_attributes_vary() -> None:
    points, triangles = _sphere(3)
    points *= 0.2  # as large as a body's parts
    plain = np.zeros((len(points), 1))
    striped = np.where(points[:, 1:2] > 0.0, 4.0 * np.sin(45.0 * points[:, 1:2]), 0.0)
    above = [
        float((points[simplify(points, triangles, carried, 300)[0], 1] > 0.0).mean()) for carried in (plain, striped)
    ]
    assert above[1] > above[0] + 0.05


def test_simplification_stops_at_tetrahedron() -> None:
    """A tetrahedron cannot lose a vertex and stay closed."""
    points = np.array([[0.0, 1.0, 0.0], [0.0, -0.5, 1.0], [1.0, -0.5, -0.5], [-1.0, -0.5, -0.5]])
    triangles = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], np.int64)
    used, kept = simplify(points, triangles, np.zeros((4, 1)), 2)
    assert len(used) == 4
    assert len(kept) == 4
