import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion import quaternion
from live.motion.editing.facing import (
    average_orientation,
    circular_mean,
    face_audience,
    heading_of,
    turn_clip,
)
from tests.motion.editing.made_steps import random_clip, sketched_step

YAWS = st.floats(-3.1, 3.1)


def about_y(yaw: float) -> np.ndarray:
    return quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), np.asarray(yaw))


@given(YAWS)
def test_heading_is_positive_toward_plus_x(yaw: float) -> None:
    assert heading_of(about_y(yaw)) == pytest.approx(yaw)


@given(YAWS)
def test_bowed_body_keeps_its_heading(yaw: float) -> None:
    bow = quaternion.from_axis_angle(np.array((1.0, 0.0, 0.0)), np.asarray(np.pi / 2))
    assert heading_of(quaternion.mul(about_y(yaw), bow)) == pytest.approx(yaw)


def test_mean_heading_is_circular() -> None:
    assert circular_mean(np.radians((170.0, -170.0))) == pytest.approx(np.pi)
    assert circular_mean(np.radians((10.0, 350.0, 0.0))) == pytest.approx(0.0, abs=1e-12)
    assert circular_mean(np.radians((0.0, 90.0))) == pytest.approx(np.radians(45.0))
    assert circular_mean(np.radians((0.0, 180.0))) == 0.0


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 100), YAWS)
def test_turned_clip_faces_audience(seed: int, yaw: float) -> None:
    faced = face_audience(turn_clip(random_clip(seed), yaw))
    assert np.sin(average_orientation(faced)) == pytest.approx(0.0, abs=1e-5)
    assert np.cos(average_orientation(faced)) > 0.99


def test_turning_rotates_clip_about_first_position() -> None:
    clip = sketched_step("walk", "long forward").clip
    turned = turn_clip(clip, 1.0)
    assert turned.root_position[0] == pytest.approx(clip.root_position[0], abs=1e-6)
    assert heading_of(turned.rotation[:, 0]) == pytest.approx(heading_of(clip.rotation[:, 0]) + 1.0, abs=1e-5)
    way, before = (c.root_position[-1] - c.root_position[0] for c in (turned, clip))
    assert way == pytest.approx(quaternion.rotate(about_y(1.0), before), abs=1e-5)
    assert np.array_equal(turned.rotation[:, 1:], clip.rotation[:, 1:])
