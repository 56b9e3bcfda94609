"""Tests of the warp mesh: interpolation, smoothness, the regular mesh, and folds."""

from types import SimpleNamespace

import numpy as np
import pytest

from live.base.errors import PersonError
from live.render.outputs.output import FULL_WINDOW, MAX_MESH_POINTS, Output
from live.render.outputs.output_coordinates import picture_to_window, window_to_picture
from live.render.outputs.screen import Screen
from live.render.outputs.warp import (
    MAX_VERTICES,
    SUBDIVISIONS,
    check_mesh,
    regular_mesh,
    unwarp_point,
    vertices,
    warp_grid,
)


def perturbed_mesh(columns=5, rows=4, by=0.03, seed=2):
    points = np.array(regular_mesh(columns, rows)) + np.random.default_rng(seed).uniform(-by, by, (rows, columns, 2))
    return tuple(tuple(map(tuple, row)) for row in points)


def test_regular_mesh_is_identity():
    shares = np.linspace(0.0, 1.0, 41)
    for columns, rows in ((2, 2), (3, 5), (17, 9)):
        places = warp_grid(regular_mesh(columns, rows), shares, shares)
        np.testing.assert_allclose(places, np.stack(np.meshgrid(shares, shares), axis=-1), atol=1e-12)


def test_warp_interpolates_mesh_points():
    mesh = perturbed_mesh()
    places = warp_grid(mesh, np.linspace(0, 1, 5), np.linspace(0, 1, 4))
    np.testing.assert_allclose(places, mesh, atol=1e-12)


@pytest.mark.gl
@pytest.mark.parametrize(
    "output",
    [
        Output(mesh=perturbed_mesh(4, 3, 0.05)),
        Output(mesh=perturbed_mesh(2, 2, 0.1), corners=((0.1, 0.12), (0.93, 0.04), (0.86, 0.95), (0.05, 0.85))),
        Output(mesh=perturbed_mesh(3, 3, 0.06), rotation=90, mirror=True, crop=(0.2, 0.1, 0.7, 0.8)),
    ],
)
def test_pointer_position_matches_picture_drawn_there(throw, output):
    """The colours encode the position: the colour at a pixel must match the position from `to_picture`."""
    y, x = np.mgrid[0:180, 0:320]
    picture = np.stack([x * (255.0 / 319), y * (255.0 / 179), np.full(x.shape, 255.0)], axis=2).round().astype(np.uint8)
    seen = throw(picture, output).astype(int)
    screen = SimpleNamespace(output=output, window=SimpleNamespace(size=(320, 180)))
    drawn = np.argwhere((seen[..., 2] > 250) & (seen[..., 0] > 2) & (seen[..., 1] > 2))
    off = []
    for row, column in drawn[:: len(drawn) // 60]:
        at = Screen.to_picture(screen, (column + 0.5, row + 0.5), (320, 180))
        off.append(np.abs(np.subtract(at, 0.5) / (319, 179) - seen[row, column, :2] / 255.0).max())
        window = ((column + 0.5) / 320, (row + 0.5) / 180)
        assert picture_to_window(output, window_to_picture(output, window)) == pytest.approx(window, abs=0.004)
    assert len(off) >= 60
    assert max(off) < 0.006  # two pixels; without the mesh it is ten times as much


def test_point_outside_picture_maps_to_window():
    output = Output(mesh=perturbed_mesh(3, 3), corners=((0.1, 0.12), (0.93, 0.04), (0.86, 0.95), (0.05, 0.85)))
    y = picture_to_window(output, (0.5, 1.1))[1]
    assert y > picture_to_window(output, (0.5, 1.0))[1] > picture_to_window(output, (0.5, 0.9))[1]
    assert picture_to_window(Output(), (-0.2, 1.3)) == pytest.approx((-0.2, 1.3))


def test_mesh_border_is_extrapolated():
    mesh = perturbed_mesh(3, 3)
    (inside, beside), step = (unwarp_point(mesh, (0.5, y)) for y in (0.1, -0.2)), 0.3
    assert inside[1] - beside[1] == pytest.approx(step, rel=0.2)
    assert unwarp_point((), (0.3, -2.0)) == (0.3, -2.0)
    assert unwarp_point(regular_mesh(4, 5), (0.31, 0.77)) == pytest.approx((0.31, 0.77))


def test_warp_slope_is_continuous_across_mesh_lines():
    """The slopes on both sides of every line, by finite differences, are equal."""
    mesh, little = perturbed_mesh(), 1e-6
    along = np.linspace(0.05, 0.95, 7)
    for line in (0.25, 0.5, 0.75):
        at = warp_grid(mesh, np.array([line - little, line, line + little]), along)
        before, after = (at[:, 1] - at[:, 0]) / little, (at[:, 2] - at[:, 1]) / little
        np.testing.assert_allclose(before, after, atol=1e-4)


def test_vertices_follow_mesh_and_corners():
    corners = ((0.1, 0.05), (0.9, 0.1), (0.95, 0.9), (0.0, 0.8))
    drawn = vertices(Output(corners=corners, mesh=perturbed_mesh()))
    assert drawn.shape == (4 * SUBDIVISIONS * 3 * SUBDIVISIONS * 6, 5)
    assert drawn.dtype == np.float32
    assert drawn[:, 2].min() > 0.0
    flat = vertices(Output(corners=corners))
    np.testing.assert_allclose(flat[[0, 1, 2, 5], :2] / flat[[0, 1, 2, 5], 2:3], corners, atol=1e-6)
    np.testing.assert_array_equal(flat[[0, 1, 2, 5], 3:], FULL_WINDOW)
    assert len(vertices(Output(mesh=regular_mesh(MAX_MESH_POINTS, MAX_MESH_POINTS)))) == MAX_VERTICES


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        ([[(0, 0), (1, 0)], [(0, 1)]], "different numbers"),
        ([[(0, 0)], [(0, 1)]], "1 by 2 points"),
        (regular_mesh(18, 2), "18 by 2"),
        ([[(0, 0), (1, 0)], [(1, 1), (0, 1)]], "folds over at row 1, column 1"),
        ([[(0, 0), (0.5, 0), (0.4, 0)], [(0, 1), (0.5, 1), (1, 1)]], "folds over at row 1, column 2"),
    ],
)
def test_invalid_mesh_is_refused_with_reason(mesh, words):
    with pytest.raises(PersonError, match=words):
        check_mesh(mesh)


def test_valid_meshes_are_accepted():
    check_mesh(())
    check_mesh(perturbed_mesh())
    check_mesh(regular_mesh(2, 2))
