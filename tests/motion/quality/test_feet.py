"""Tests of foot slide and skating: feet pulled at known speeds, and a direct form of the published definition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.quality.metrics import contact_slide_speeds, skating_balls, skating_frames, slide_speeds
from live.motion.skeleton import SKELETON


def sliding_rest_pose(count, *, speed=0.0, rate=60.0):
    """The rest pose moving at `speed` [m/s] along x, (T, J, 3)."""
    position = np.repeat(SKELETON.rest_positions()[None].astype(np.float64), count, axis=0)
    position[..., 0] += speed * np.arange(count)[:, None] / rate
    return position


@given(st.floats(0.0, 3.0), st.sampled_from([30.0, 60.0, 120.0]))
def test_pulled_body_slides_at_given_speed(speed, rate):
    position = sliding_rest_pose(20, speed=speed, rate=rate)
    np.testing.assert_allclose(slide_speeds(position, rate), speed, atol=1e-9)
    both = np.ones((20, 2), np.bool_)
    assert contact_slide_speeds(position, both, rate).shape == (38,)
    both[10] = False
    assert contact_slide_speeds(position, both, rate).shape == (34,)


def test_slower_of_heel_and_ball_counts():
    """A foot that turns about its ball stands."""
    position = sliding_rest_pose(10)
    position[:, SKELETON.index("leftFoot"), 0] += 0.1 * np.arange(10)
    assert slide_speeds(position, 60.0)[:, 0] == pytest.approx(0.0)


def test_batched_dancers_equal_single_dancers():
    one, two = sliding_rest_pose(30, speed=0.2), sliding_rest_pose(30, speed=1.0)
    both = np.stack([one, two], axis=1)
    np.testing.assert_allclose(slide_speeds(both, 60.0)[:, 1], slide_speeds(two, 60.0))
    np.testing.assert_array_equal(
        skating_frames(both, 60.0), np.stack([skating_frames(one, 60.0), skating_frames(two, 60.0)], axis=1)
    )


@pytest.mark.parametrize(("speed", "skating"), [(0.4, 0.0), (0.6, 1.0)])
def test_skating_starts_above_half_meter_per_second(speed, skating):
    found = skating_frames(sliding_rest_pose(200, speed=speed), 60.0)
    assert found[3:-3].mean() == skating


def test_raised_feet_do_not_skate():
    position = sliding_rest_pose(100, speed=2.0)
    position[..., 1] += 0.06
    assert not skating_frames(position, 60.0).any()


@given(st.integers(0, 2**32 - 1), st.integers(2, 30))
def test_skating_equals_loop_over_definition(seed, count):
    """Frame by frame, with loops."""
    chance = np.random.default_rng(seed)
    balls = np.cumsum(chance.normal(0.0, 0.03, (count, 2, 3)), axis=0)
    balls[..., 1] = TOES_OVER_SOLE + np.abs(chance.normal(0.0, 0.06, (count, 2)))
    found = skating_balls(balls)
    speed = np.zeros((count - 1, 2))
    for n in range(count - 1):
        for foot in range(2):
            x, _, z = balls[n + 1, foot] - balls[n, foot]
            speed[n, foot] = np.hypot(x, z) * 20.0
    for n in range(count - 1):
        expected = False
        for foot in range(2):
            low = max(balls[n, foot, 1], balls[n + 1, foot, 1]) - TOES_OVER_SOLE < 0.05
            five = sum(speed[k, foot] for k in range(n - 2, n + 3) if 0 <= k < count - 1) / 5.0
            expected |= bool(low and speed[n, foot] > 0.5 and five > 0.5)
        assert found[n] == expected
