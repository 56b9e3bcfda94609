"""Tests of foot lifts after a cut: smooth, landed in time, and only for feet with some distance to move."""

import numpy as np
import pytest

from live.motion.pose.foot_lock import ARRIVAL_DISTANCE, LIFT_HEIGHT, STAY_DISTANCE, CutFootLift
from live.motion.pose.foot_lock_kernels import CLEARANCE, CLEARANCE_SOFTNESS, FEET_COLUMNS
from live.motion.pose.inertialization_kernels import MAX_FADE_TIME


def clearance_at(landing, age):
    """CLEARANCE of both feet of all dancers, (A, 2), `age` [s] after their cuts."""
    feet = np.zeros((len(landing.lift), 2, FEET_COLUMNS), np.float32)
    landing.apply(feet, np.full(len(landing.lift), age, np.float32))
    np.testing.assert_array_equal(feet[:, :, :CLEARANCE], 0.0)
    assert feet[:, :, CLEARANCE_SOFTNESS] == pytest.approx(0.3 * feet[:, :, CLEARANCE])
    return feet[:, :, CLEARANCE]


def test_only_feet_with_distance_to_move_are_lifted():
    landing = CutFootLift(3)
    landing.begin(np.array([0, 2], np.int32), np.array([[0.5, 0.3], [0.02, 0.11]]))
    highest = np.max([clearance_at(landing, age) for age in np.linspace(0.0, MAX_FADE_TIME, 81)], axis=0)
    assert highest[0] == pytest.approx([LIFT_HEIGHT, LIFT_HEIGHT], abs=1e-4)
    np.testing.assert_array_equal(highest[1:], 0.0)
    landing.begin(np.array([0], np.int32), np.array([[0.5, 0.1]]))  # cut again
    assert (clearance_at(landing, 0.1)[0] > 0.0).tolist() == [True, False]


def test_lift_is_smooth_and_ends_within_fade_time():
    landing, dt = CutFootLift(1), 1.0 / 240.0
    landing.begin(np.array([0], np.int32), np.array([[0.5, 0.5]]))
    height = np.array([clearance_at(landing, n * dt)[0, 0] for n in range(121)])
    assert height[0] == height[-1] == clearance_at(landing, MAX_FADE_TIME)[0, 0] == 0.0
    speed = np.diff(height) / dt
    assert abs(speed[0]) < 0.15
    assert np.abs(speed).max() < 1.4
    assert np.abs(np.diff(speed)).max() < 0.3  # no pop


def test_larger_existing_clearance_is_kept():
    landing = CutFootLift(1)
    landing.begin(np.array([0], np.int32), np.array([[0.5, 0.0]]))
    feet = np.full((1, 2, FEET_COLUMNS), 0.2, np.float32)
    landing.apply(feet, np.array([0.15], np.float32))
    np.testing.assert_array_equal(feet, np.float32(0.2))


def test_lifted_feet_lock_only_on_arrival():
    landing = CutFootLift(2)
    landing.begin(np.array([0], np.int32), np.array([[0.5, 0.0]]))
    away = np.array([[0.5 * (ARRIVAL_DISTANCE + STAY_DISTANCE)] * 2] * 2)
    assert landing.may_lock(away).tolist() == [[False, True], [True, True]]
    assert landing.may_lock(0.0 * away).all()
    assert not landing.may_lock(0.0 * away + STAY_DISTANCE).any()
