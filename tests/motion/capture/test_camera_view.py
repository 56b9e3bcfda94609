"""Tests of cameras found from marks on the floor."""

import numpy as np
import pytest

from live.base.errors import PersonError
from live.motion.capture.camera_view import assumed_view, calibrate
from tests.motion.capture.made_landmarks import look_at

MARKS = np.array([(-2.0, -1.5), (2.0, -1.5), (2.0, 1.5), (-2.0, 1.5)])
CAMERAS = [((0.0, 1.2, 5.0), 0.9), ((3.0, 2.0, 4.0), 1.2), ((-4.0, 1.4, 3.0), 0.8), ((0.0, 1.5, 6.0), 1.4)]


def _on_stage(marks):
    return np.column_stack((marks[:, 0], np.zeros(len(marks)), marks[:, 1]))


@pytest.mark.parametrize(("eye", "focal"), CAMERAS)
def test_four_marks_find_the_camera(eye, focal):
    there = look_at(eye, (0.0, 0.9, 0.0), focal)
    found = calibrate(MARKS, there.project(_on_stage(MARKS)), there.aspect)
    np.testing.assert_allclose(found.position, eye, atol=0.02)
    np.testing.assert_allclose(found.rotation, there.rotation, atol=0.005)
    assert found.focal == pytest.approx(focal, rel=0.005)
    assert found.calibrated


@pytest.mark.parametrize(("eye", "focal"), CAMERAS)
def test_clicks_off_by_a_pixel_and_a_half_leave_the_floor_right_within_15_cm(eye, focal):
    there = look_at(eye, (0.0, 0.9, 0.0), focal)
    generator = np.random.default_rng(1)
    clicked = there.project(_on_stage(MARKS)) + generator.normal(size=(4, 2)) * 1.5 / np.array((1920.0, 1080.0))
    found = calibrate(MARKS, clicked, there.aspect)
    places = _on_stage(np.stack(np.meshgrid(np.linspace(-2, 2, 5), np.linspace(-1.5, 1.5, 5)), -1).reshape(-1, 2))
    off = np.linalg.norm(found.on_floor(there.project(places)) - places, axis=1)
    assert off.max() < 0.15


def test_a_camera_that_looks_straight_down_still_finds_the_floor():
    down = look_at((0.0, 5.0, 0.01), (0.0, 0.0, 0.0), 0.9)
    places = down.project(_on_stage(MARKS))
    found = calibrate(MARKS, places, down.aspect)
    np.testing.assert_allclose(found.on_floor(places), _on_stage(MARKS), atol=0.02)


def test_rays_up_meet_no_floor_and_points_behind_are_not_seen():
    view = look_at((0.0, 1.5, 5.0), (0.0, 1.5, 0.0))
    assert np.isnan(view.on_floor([(0.5, 0.2)])).any()
    assert np.isnan(view.project([(0.0, 1.0, 9.0)])).all()


@pytest.mark.parametrize(
    ("marks", "order", "words"),
    [
        (MARKS[:3], [0, 1, 2], "at least four"),
        (np.array([(-2.0, 0.0), (0.0, 0.0), (2.0, 0.0), (0.0, 2.0)]), [0, 1, 2, 3], "on a line on the stage"),
        (MARKS[[0, 2, 1, 3]], [0, 1, 2, 3], "convex shape on the stage"),
        (MARKS, [0, 2, 1, 3], "convex shape in the picture"),
        (MARKS, [3, 2, 1, 0], "clockwise in one list"),
        (MARKS * (np.nan, 1.0), [0, 1, 2, 3], "not a finite number"),
        (MARKS * 1e5, [0, 1, 2, 3], "over 1000 m"),
        (MARKS + np.array((0.0, 2.0)) * [[0], [0], [1], [0]], [0, 1, 2, 3], "do not fit together"),
    ],
)  # fmt: skip
def test_bad_marks_are_refused_in_words(marks, order, words):
    places = look_at((0.5, 1.6, 5.0), (0.0, 0.9, 0.0)).project(_on_stage(MARKS))
    with pytest.raises(PersonError) as error:
        calibrate(marks, places[order], 16 / 9)
    assert words in error.value.message
    assert error.value.remedy


def test_marks_on_a_line_in_the_picture_are_refused():
    with pytest.raises(PersonError, match="on a line in the picture"):
        calibrate(MARKS, [(0.1, 0.5), (0.5, 0.5), (0.9, 0.5), (0.5, 0.9)], 16 / 9)


def test_marks_below_the_horizon_upside_down_are_refused():
    view = look_at((0.5, 1.6, 5.0), (0.0, 0.9, 0.0))
    turned = 1.0 - view.project(_on_stage(MARKS))
    with pytest.raises(PersonError):
        calibrate(MARKS[[0, 1, 2, 3]], turned[[2, 1, 0, 3]], view.aspect)


def test_an_assumed_camera_looks_at_the_stage_from_the_audience():
    view = assumed_view(16 / 9)
    (left, right) = view.project([(-1.0, 1.0, 0.0), (1.0, 1.0, 0.0)])
    assert left[0] < 0.5 < right[0]
    assert not view.calibrated
    with pytest.raises(ValueError, match="width over its height"):
        assumed_view(0.0)
