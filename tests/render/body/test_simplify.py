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


def test_the_first_edges_to_collapse_are_the_cheapest() -> None:
    """Against costs in numpy (Garland and Heckbert 1997): planes by area, and the change of data along an edge."""
    points, triangles = _sphere(2)
    points *= (0.31, 0.12, 0.2)
    data = np.stack([np.sin(9.0 * points[:, 1]), points[:, 2]], axis=1)
    a, b, c = (points[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    plane = np.column_stack([normal / area[:, None], -(normal * a).sum(axis=1) / area])
    form = np.einsum("t,ti,tj->tij", area, plane, plane)
    quadric = np.array([form[(triangles == vertex).any(axis=1)].sum(axis=0) for vertex in range(len(points))])
    gone, kept = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).T
    at = np.column_stack([points[kept], np.ones(len(kept))])
    cost = np.einsum("ei,eij,ej->e", at, quadric[gone] + quadric[kept], at)
    change = np.abs(data[gone] - data[kept]).sum(axis=1)
    cost += 2e-4 * np.linalg.norm(points[gone] - points[kept], axis=1) * (0.2 + change)
    cost[(np.abs(points[gone, 0]) < 1e-9) & (np.abs(points[kept, 0]) > 1e-9)] = np.inf  # those in the middle stay there
    cheapest = gone[cost <= cost.min() * (1.0 + 1e-6)]
    used, _ = simplify(points, triangles, data, len(triangles) - 1)
    left_out = np.setdiff1d(np.arange(len(points)), used)
    assert 0 < len(left_out) <= 2
    assert np.isin(left_out, cheapest).all()


def test_numbers_that_differ_by_rounding_give_the_same_mesh() -> None:
    """So bodies are the same on all machines, whatever the last bits of their mathematical libraries are."""
    points, triangles = _sphere(3)
    points *= 0.2
    data = np.sin(30.0 * points[:, 1:2])
    rounded = points * (1.0 + 1e-15 * np.random.default_rng(1).uniform(-1.0, 1.0, points.shape))
    (used, fewer), (also_used, also_fewer) = (simplify(each, triangles, data, 200) for each in (points, rounded))
    assert np.array_equal(used, also_used)
    assert np.array_equal(fewer, also_fewer)


def test_fixed_vertices_stay() -> None:
    points, triangles = _sphere(3)
    fixed = points[:, 1] > 0.5
    used, _ = simplify(points, triangles, np.zeros((len(points), 1)), 300, fixed)
    assert np.isin(np.flatnonzero(fixed), used).all()


def test_partners_are_the_nearest_to_the_mirror_images() -> None:
    points = np.random.default_rng(2).normal(size=(60, 3))
    image = points * [-1.0, 1.0, 1.0]
    nearest = np.linalg.norm(points[None] - image[:, None], axis=2).argmin(axis=1)
    assert np.array_equal(mirror_partners(points), nearest)


def test_simplification_stops_at_tetrahedron() -> None:
    """A tetrahedron cannot lose a vertex and stay closed."""
    points = np.array([[0.0, 1.0, 0.0], [0.0, -0.5, 1.0], [1.0, -0.5, -0.5], [-1.0, -0.5, -0.5]])
    triangles = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], np.int64)
    used, kept = simplify(points, triangles, np.zeros((4, 1)), 2)
    assert len(used) == 4
    assert len(kept) == 4
