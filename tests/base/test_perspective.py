"""Projector perspective: the floor's corners are projected back to their picture positions, for any place."""

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.floor_corners import check_corners, floor_corners
from live.base.projector_perspective import camera_from_corners
from live.base.stage_snapshot import Camera
from live.render.camera import project_points

SIZE, STAGE = (1920, 1080), (12.0, 8.0)
ASPECT = SIZE[0] / SIZE[1]


def project_floor(camera, stage=STAGE):
    """Positions of the floor's corners in the picture of a camera, 0..1 (4, 2)."""
    floor = floor_corners(*stage)
    return project_points(camera, SIZE, np.stack([floor[:, 0], np.zeros(4), floor[:, 1]], axis=1)) / SIZE


@pytest.mark.parametrize(
    "camera",
    [
        Camera(),
        Camera((0.0, 7.0, 14.0), (0.0, 0.5, 0.0), 30.0),
        Camera((3.0, 5.5, 12.0), (-1.0, 0.2, 1.0), 35.0, 7.5, (0.1, -0.4)),
        Camera((0.0, 12.0, 0.5), (0.0, 0.0, 0.0), 50.0, shift=(0.0, 0.5)),
        Camera((-6.0, 9.0, -7.0), (0.0, 0.0, 0.0), 45.0, -170.0),
    ],
)
def test_camera_is_recovered_from_place_and_corners(camera):
    found = camera_from_corners(camera.eye, project_floor(camera), STAGE, ASPECT)
    assert found.eye == camera.eye
    assert found.field_of_view_deg == pytest.approx(camera.field_of_view_deg, abs=1e-6)
    assert found.roll_deg == pytest.approx(camera.roll_deg, abs=1e-6)
    assert found.shift == pytest.approx(camera.shift, abs=1e-7)
    assert (found.stretch, found.skew) == pytest.approx((1.0, 0.0), abs=1e-7)
    way, true = (np.subtract(one.target, one.eye) for one in (found, camera))
    assert np.allclose(way / np.linalg.norm(way), true / np.linalg.norm(true), atol=1e-8)
    body = np.random.default_rng(3).uniform((-5, 0, -4), (5, 2, 4), (40, 3))  # what stands on the floor, too
    assert np.abs(project_points(found, SIZE, body) - project_points(camera, SIZE, body)).max() < 1e-4


def test_hand_set_corners_are_matched_within_a_pixel():
    """Corners adjusted by hand after a keystone correction: no real lens has them, yet feet still meet the floor."""
    chance, tried = np.random.default_rng(9), 0
    for _ in range(60):
        camera = Camera(tuple(chance.uniform((-4, 3, 8), (4, 9, 16))), (0.0, 0.0, 0.0), float(chance.uniform(30, 60)))
        corners = project_floor(camera) + chance.normal(0.0, 0.01, (4, 2))
        found = camera_from_corners(camera.eye, corners, STAGE, ASPECT)
        assert np.abs(project_floor(found) - corners).max() * SIZE[0] < 1e-6
        middle = project_points(found, SIZE, [(0.0, 0.0, 0.0)])[0] / SIZE  # where the diagonals meet
        a, b, c, d = corners
        across = np.linalg.solve(np.stack([c - a, b - d], axis=1), b - a)
        assert np.allclose(a + across[0] * (c - a), middle, atol=1e-9)
        tried += 1
    assert tried == 60


@pytest.mark.parametrize(
    ("at", "corners", "words"),
    [
        ((0, 5, 12), [(0.2, 0.3), (0.8, 0.7), (0.8, 0.3), (0.2, 0.7)], "cross"),
        ((0, 5, 12), [(0.2, 0.3), (0.5, 0.3), (0.8, 0.3), (0.2, 0.7)], "line"),
        ((0, 5, 12), [(0.5, 0.5)] * 4, "line"),
        ((0, 5, 12), [(0.8, 0.3), (0.2, 0.3), (0.1, 0.8), (0.9, 0.8)], "other way"),
        ((0, 0, 12), [(0.2, 0.3), (0.8, 0.3), (0.9, 0.8), (0.1, 0.8)], "on the floor"),
        ((0, 5, -12), [(0.2, 0.3), (0.8, 0.3), (0.9, 0.8), (0.1, 0.8)], "angle of view"),
    ],
)
def test_invalid_corners_are_refused_with_reason(at, corners, words):
    with pytest.raises(PersonError, match=words):
        camera_from_corners(at, corners, STAGE, ASPECT)


def test_ordered_picture_corners_are_valid():
    check_corners([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
