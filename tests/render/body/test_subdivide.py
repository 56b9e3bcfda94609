"""Catmull-Clark subdivision against the known values of the cube, and its invariants."""

import numpy as np
import pytest

from live.render.body.mesh_simplify import subdivide

CUBE = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], np.float64
)
FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2]], np.int64)


def test_subdivided_cube_has_known_points() -> None:
    """Corners move to 5/9, edge middles to 3/4, face middles stay (Catmull and Clark 1978)."""
    points, faces = subdivide(CUBE, FACES)
    assert points.shape == (26, 3)
    assert faces.shape == (24, 4)
    np.testing.assert_allclose(np.abs(points[:8]), 5.0 / 9.0)
    np.testing.assert_allclose(np.sort(np.abs(points[8:20]), axis=1), np.tile([0.0, 0.75, 0.75], (12, 1)), atol=1e-12)
    np.testing.assert_allclose(np.sort(np.abs(points[20:]), axis=1), np.tile([0.0, 0.0, 1.0], (6, 1)), atol=1e-12)


def test_faces_keep_orientation() -> None:
    points, faces = subdivide(CUBE, FACES)
    a, b, c = (points[faces[:, i]] for i in range(3))
    outward = (np.cross(b - a, c - a) * points[faces].mean(axis=1)).sum(axis=1)
    assert (outward > 0.0).all()


def test_vertex_weight_sums_are_kept() -> None:
    """Values that sum to 1 at every vertex still do: each new value is an average."""
    rng = np.random.default_rng(3)
    weights = rng.random((8, 5))
    weights /= weights.sum(axis=1, keepdims=True)
    values, faces = subdivide(weights, FACES)
    values, _ = subdivide(values, faces)
    np.testing.assert_allclose(values.sum(axis=1), 1.0)
    assert values.min() >= 0.0


def test_open_mesh_is_refused() -> None:
    with pytest.raises(ValueError, match="not closed"):
        subdivide(CUBE, FACES[:-1])
