"""The mesh: through its points, smooth, nothing bent by the regular one, no folds."""

import numpy as np
import pytest

from live.base.errors import PersonError
from live.render.outputs.mesh import MOST_VERTICES, PIECES, bent, check_mesh, regular, vertices
from live.render.outputs.output import MESH_MOST, UNBENT, Output


def moved(columns=5, rows=4, by=0.03, seed=2):
    points = np.array(regular(columns, rows)) + np.random.default_rng(seed).uniform(-by, by, (rows, columns, 2))
    return tuple(tuple(map(tuple, row)) for row in points)


def test_the_regular_mesh_bends_nothing():
    shares = np.linspace(0.0, 1.0, 41)
    for columns, rows in ((2, 2), (3, 5), (17, 9)):
        places = bent(regular(columns, rows), shares, shares)
        np.testing.assert_allclose(places, np.stack(np.meshgrid(shares, shares), axis=-1), atol=1e-12)


def test_it_goes_through_its_points():
    mesh = moved()
    places = bent(mesh, np.linspace(0, 1, 5), np.linspace(0, 1, 4))
    np.testing.assert_allclose(places, mesh, atol=1e-12)


def test_it_is_smooth_across_its_lines():
    """The slope on both sides of every line is the same, found by differences."""
    mesh, little = moved(), 1e-6
    along = np.linspace(0.05, 0.95, 7)
    for line in (0.25, 0.5, 0.75):
        at = bent(mesh, np.array([line - little, line, line + little]), along)
        before, after = (at[:, 1] - at[:, 0]) / little, (at[:, 2] - at[:, 1]) / little
        np.testing.assert_allclose(before, after, atol=1e-4)


def test_vertices_are_the_bent_frame_through_the_corners():
    corners = ((0.1, 0.05), (0.9, 0.1), (0.95, 0.9), (0.0, 0.8))
    drawn = vertices(Output(corners=corners, mesh=moved()))
    assert drawn.shape == (4 * PIECES * 3 * PIECES * 6, 5)
    assert drawn.dtype == np.float32
    assert drawn[:, 2].min() > 0.0
    flat = vertices(Output(corners=corners))
    np.testing.assert_allclose(flat[[0, 1, 2, 5], :2] / flat[[0, 1, 2, 5], 2:3], corners, atol=1e-6)
    np.testing.assert_array_equal(flat[[0, 1, 2, 5], 3:], UNBENT)
    assert len(vertices(Output(mesh=regular(MESH_MOST, MESH_MOST)))) == MOST_VERTICES


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        ([[(0, 0), (1, 0)], [(0, 1)]], "different numbers"),
        ([[(0, 0)], [(0, 1)]], "1 by 2 points"),
        (regular(18, 2), "18 by 2"),
        ([[(0, 0), (1, 0)], [(1, 1), (0, 1)]], "folds over at row 1, column 1"),
        ([[(0, 0), (0.5, 0), (0.4, 0)], [(0, 1), (0.5, 1), (1, 1)]], "folds over at row 1, column 2"),
    ],
)
def test_meshes_that_cannot_be_drawn_are_named(mesh, words):
    with pytest.raises(PersonError, match=words):
        check_mesh(mesh)


def test_meshes_that_can_be_drawn_are_allowed():
    check_mesh(())
    check_mesh(moved())
    check_mesh(regular(2, 2))
