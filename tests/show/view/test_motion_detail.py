"""Level of detail of motion: by height in the picture only, nobody near the camera loses anything."""

import numpy as np

from live.base import picture_parameters
from live.base.picture_parameters import EYE, FIELD_OF_VIEW, PLAN, TARGET
from live.show.view.view_builder import BODY_HEIGHT, FULL_DETAIL, NO_DETAIL, motion_detail
from tests.show.made_show import made_show


def picture(eye=(0.0, 1.6, 10.0), field=40.0, plan=0.0):
    """Picture parameters of a camera that looks to the back."""
    row = np.zeros(picture_parameters.ROW_SIZE)
    row[EYE], row[FIELD_OF_VIEW], row[PLAN] = eye, field, plan
    row[TARGET] = eye[0], eye[1] - 0.2, eye[2] - 10.0
    return row


def distance_at(share, field):
    """Distance [m] at which a dancer is this share of the picture's height high."""
    return BODY_HEIGHT / (2.0 * share * np.tan(np.radians(field / 2.0)))


def test_everybody_has_full_detail_on_a_usual_stage():
    x, z = np.meshgrid(np.linspace(-8.0, 8.0, 9), np.linspace(-6.0, 6.0, 7))
    assert motion_detail(picture(), np.stack([x.ravel(), z.ravel()], axis=1).astype(np.float32)) is None


def test_detail_falls_with_the_height_in_the_picture():
    for field in (20.0, 40.0, 90.0):
        near, far = distance_at(FULL_DETAIL, field), distance_at(NO_DETAIL, field)
        hips = np.zeros((5, 2), np.float32)
        hips[:, 1] = -np.array([0.5 * near, 0.98 * near, 0.5 * (near + far), 1.02 * far, 3.0 * far])
        detail = motion_detail(picture(eye=(0.0, 1.0, 0.0), field=field), hips)
        assert detail[:2].tolist() == [1.0, 1.0]
        assert 0.3 < detail[2] < 0.7
        assert detail[3:].tolist() == [0.0, 0.0]


def test_a_plan_has_no_distance():
    hips = np.array([[0.0, -500.0]], np.float32)
    assert motion_detail(picture(), hips).tolist() == [0.0]
    assert motion_detail(picture(plan=0.5), hips) is None


def test_whoever_is_surely_not_seen_has_no_detail():
    hips = np.array([[0.0, 0.0], [0.0, 12.0], [0.0, 14.0], [0.0, 30.0], [24.0, 3.0], [30.0, 3.0], [-30.0, 3.0]])
    detail = motion_detail(picture(), hips.astype(np.float32))
    assert detail.tolist() == [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    edge = 10.0 * 16.0 / 9.0 * np.tan(np.radians(20.0))  # of a wide picture, at the middle of the stage
    assert motion_detail(picture(), np.array([[edge, 0.0], [-edge, 0.0]], np.float32)) is None


def test_nothing_is_left_out_for_others_than_the_camera():
    """All dancers are behind the camera; who else looks sees their arms as a usual camera does."""
    shown = {}
    for name, away, detailed in (("usual", False, False), ("away", True, False), ("others", True, True)):
        show = made_show()
        view = show.view()
        view.detailed = detailed
        if away:
            show.desk.parameters.picture[EYE] = 0.0, 1.6, -300.0
            show.desk.parameters.picture[TARGET] = 0.0, 1.6, -400.0
        for tick in range(1, 129):
            show.tick(tick / 64)
            show.fill(view, tick / 64)
        shown[name] = view.joint_position.copy()
    np.testing.assert_array_equal(shown["others"], shown["usual"])
    assert shown["away"].shape == shown["usual"].shape
