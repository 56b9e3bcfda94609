"""Tests of foot extrapolation between two ticks against numpy."""

import numpy as np

from live.motion.pose.foot_lock_kernels import (
    DROP,
    DROP_SPEED,
    FEET_COLUMNS,
    FOLLOWED_COLUMNS,
    HELD,
    HIP_DROP,
    LIFT,
    LOCK_COLUMNS,
    SHIFT_X,
    SHIFT_Z,
    SLIDE,
    SPEED_X,
    SPEED_Y,
    SPEED_Z,
    STAND_TIME,
    extrapolate_feet,
    farthest_shift,
    pop_slide,
)

COUNT = 30


def random_foot_locks(seed=3):
    chance = np.random.default_rng(seed)
    lock = chance.normal(0.0, 1.0, (COUNT, 2, LOCK_COLUMNS)).astype(np.float32)
    lock[:, :, HELD] = chance.integers(0, 2, (COUNT, 2))
    return lock


def test_free_feet_are_extrapolated_and_locked_feet_stay():
    lock, feet = random_foot_locks(), np.zeros((COUNT, 2, FEET_COLUMNS), np.float32)
    extrapolate_feet(feet, lock, 0.01)
    expected = lock[:, :, :FOLLOWED_COLUMNS].copy()
    free = lock[:, :, HELD] == 0.0
    for place, speed in ((SHIFT_X, SPEED_X), (SHIFT_Z, SPEED_Z), (LIFT, SPEED_Y)):
        expected[free, place] += np.float32(0.01) * lock[free, speed]
    np.testing.assert_array_equal(feet[:, :, :FOLLOWED_COLUMNS], expected)
    np.testing.assert_array_equal(feet[:, :, HIP_DROP], lock[:, :, DROP] + np.float32(0.01) * lock[:, :, DROP_SPEED])
    assert 0 < free.sum() < free.size


def test_farthest_shift_is_maximum_over_feet():
    lock = random_foot_locks()
    assert farthest_shift(lock) == np.abs(lock[:, :, (SHIFT_X, SHIFT_Z)]).max()


def test_slide_is_reported_once():
    lock = np.abs(random_foot_locks())
    before = lock.copy()
    slid, stood = np.zeros((2, COUNT))
    pop_slide(lock, slid, stood)
    np.testing.assert_allclose(slid, before[:, :, SLIDE].sum(axis=1), rtol=1e-6)
    np.testing.assert_allclose(stood, before[:, :, STAND_TIME].sum(axis=1), rtol=1e-6)
    pop_slide(lock, slid, stood)
    assert not slid.any()
    assert not stood.any()
