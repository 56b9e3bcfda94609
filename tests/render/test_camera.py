"""Camera matrices against independent geometry, and the inverse map from a pixel to the floor."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base.stage_snapshot import Camera
from live.render.camera import (
    FAR,
    NEAR,
    floor_point,
    project_points,
    projection,
    screen_bounds,
    view_matrix,
    world_to_clip,
)

SIZE = (1280, 720)


def test_view_matrix_is_rigid_with_target_straight_ahead() -> None:
    camera = Camera(eye=(2.0, 3.0, 9.0), target=(-1.0, 0.5, -2.0))
    matrix = view_matrix(camera)
    np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(matrix) == pytest.approx(1.0)
    seen = matrix @ np.array([*camera.target, 1.0])
    distance = math.dist(camera.eye, camera.target)
    np.testing.assert_allclose(seen[:3], [0.0, 0.0, -distance], atol=1e-12)


def test_projection_has_near_far_planes_and_vertical_field_of_view() -> None:
    camera = Camera(field_of_view_deg=50.0)
    matrix = projection(camera, 16 / 9)
    for distance, depth in ((NEAR, -1.0), (FAR, 1.0)):
        clip = matrix @ np.array([0.0, 0.0, -distance, 1.0])
        assert clip[2] / clip[3] == pytest.approx(depth)
    edge = matrix @ np.array([0.0, math.tan(math.radians(25.0)) * 7.0, -7.0, 1.0])
    assert edge[1] / edge[3] == pytest.approx(1.0)


def test_audience_right_is_picture_right_and_back_is_higher() -> None:
    centre, right, back, head = project_points(Camera(), SIZE, [[0, 0, 0], [2, 0, 0], [0, 0, -2], [0, 1.7, 0]])
    assert right[0] > centre[0]
    assert back[1] < centre[1]
    assert head[1] < centre[1]


@given(
    x=st.floats(-6, 6),
    z=st.floats(-5, 4),
    eye_x=st.floats(-8, 8),
    eye_y=st.floats(1.0, 12.0),
    field=st.floats(20, 80),
)
def test_floor_point_is_recovered_from_its_pixel(x: float, z: float, eye_x: float, eye_y: float, field: float) -> None:
    camera = Camera(eye=(eye_x, eye_y, 11.5), target=(0.0, 0.9, 0.0), field_of_view_deg=field)
    pixel = project_points(camera, SIZE, [[x, 0.0, z]])[0]
    point = floor_point(camera, SIZE, (float(pixel[0]), float(pixel[1])))
    assert point is not None
    assert point == pytest.approx((x, z), abs=1e-6)


def test_pixel_above_horizon_has_no_floor_point() -> None:
    camera = Camera(eye=(0.0, 1.5, 8.0), target=(0.0, 1.5, 0.0))
    assert floor_point(camera, SIZE, (640, 100)) is None
    assert floor_point(camera, SIZE, (640, 700)) is not None


def test_camera_can_look_straight_down() -> None:
    camera = Camera(eye=(0.0, 10.0, 0.0), target=(0.0, 0.0, 0.0))
    point = floor_point(camera, SIZE, (640, 360))
    assert point == pytest.approx((0.0, 0.0), abs=1e-9)
    upper = floor_point(camera, SIZE, (640, 0))
    assert upper is not None
    assert upper[1] < 0.0  # the back of the stage on top


def test_invalid_camera_is_refused_by_field() -> None:
    with pytest.raises(ValueError, match="eye and target"):
        view_matrix(Camera(eye=(1.0, 1.0, 1.0), target=(1.0, 1.0, 1.0)))
    with pytest.raises(ValueError, match="field_of_view_deg"):
        world_to_clip(Camera(field_of_view_deg=180.0), SIZE)


def test_screen_bounds_contain_every_point_of_box() -> None:
    camera = Camera(eye=(2.0, 2.5, 9.0))
    low, high = np.array([-1.0, 0.0, -2.0]), np.array([1.5, 1.8, 1.0])
    x, y, width, height = screen_bounds(world_to_clip(camera, SIZE), SIZE, low, high)
    inside = low + np.random.default_rng(1).random((500, 3)) * (high - low)
    pixels = project_points(camera, SIZE, inside)
    assert ((pixels[:, 0] >= x) & (pixels[:, 0] <= x + width)).all()
    from_below = SIZE[1] - pixels[:, 1]
    assert ((from_below >= y) & (from_below <= y + height)).all()
    assert width * height < 0.5 * SIZE[0] * SIZE[1]


def test_box_around_camera_covers_whole_screen() -> None:
    matrix = world_to_clip(Camera(), SIZE)
    assert screen_bounds(matrix, SIZE, np.array([-1.0, 0.0, 5.0]), np.array([1.0, 4.0, 20.0])) == (0, 0, *SIZE)
