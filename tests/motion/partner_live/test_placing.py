"""Tests of follower placement: it approaches the expected placement without jumps, and slowly while a foot stands."""

import numpy as np
import pytest

from live.motion.partner.point_clouds import leader_cloud
from live.motion.partner_live.floor_transform import MAX_SPEED, MAX_TURN_RATE, FloorTransform
from live.motion.partner_live.follower_filter import FollowerFilter
from live.motion.partner_live.follower_kernels import ANYWHERE, EXACT_GAIN, EXACT_WIDTH, GO_ON, SKIP, STAY
from live.motion.partner_live.follower_model import JUMP_PROBABILITY, KERNEL_WIDTH, RIDGE, SEEN_WIDTH
from live.motion.partner_live.follower_moments import root_track
from tests.motion.partner_live.led_pairs import led_pair

RATE = 30.0
DT = 1.0 / RATE
ROOT, FACING = 0.3 + 0.2j, np.exp(0.4j)
WANTED = (1.0 - 0.5j, complex(np.exp(1.4j)))


def aligned_transform() -> FloorTransform:
    placing = FloorTransform()
    placing.align(ROOT, FACING, 0.2 + 0.1j, complex(1.0))
    return placing


def hip_position(placing: FloorTransform, part: float) -> complex:
    turn, shift = placing.interpolate(part)
    return turn * ROOT + shift


def test_follower_starts_aligned_and_reaches_wanted_placement() -> None:
    placing = aligned_transform()
    assert hip_position(placing, 0.0) == pytest.approx(0.2 + 0.1j)
    assert placing.turn * FACING == pytest.approx(1.0)
    for _ in range(180):
        placing.follow(ROOT, FACING, WANTED, DT, standing=False, too_near=False)
    assert hip_position(placing, 1.0) == pytest.approx(WANTED[0], abs=1e-6)
    assert placing.turn * FACING == pytest.approx(WANTED[1], abs=1e-6)


def test_placement_is_continuous_across_frames_and_recordings() -> None:
    placing = aligned_transform()
    for n in range(20):
        end = hip_position(placing, 1.0)
        placing.follow(ROOT, FACING, WANTED, DT, standing=n % 3 == 0, too_near=False)
        assert hip_position(placing, 0.0) == pytest.approx(end, abs=1e-12)
    end = hip_position(placing, 1.0)
    placing.align(-1.0 + 0.0j, complex(1.0), end, placing.turn * FACING)
    turn, shift = placing.interpolate(0.0)
    assert turn * -1.0 + shift == pytest.approx(end, abs=1e-12)


def test_follower_moves_less_while_foot_stands() -> None:
    moved = []
    for stands in (True, False):
        placing = aligned_transform()
        for _ in range(6):
            placing.follow(ROOT, FACING, WANTED, DT, standing=stands, too_near=False)
        moved.append(abs(hip_position(placing, 1.0) - (0.2 + 0.1j)))
    assert moved[0] < 0.5 * moved[1]


def test_follower_speed_and_turn_rate_are_limited() -> None:
    for near, share in ((False, 1.0), (True, 2.0)):
        placing = aligned_transform()
        for _ in range(10):
            before = placing.turn
            placing.follow(ROOT, FACING, (30.0 + 0.0j, complex(-1.0)), DT, standing=False, too_near=near)
            assert abs(hip_position(placing, 1.0) - hip_position(placing, 0.0)) <= share * MAX_SPEED * DT * (1.0 + 1e-9)
            assert abs(np.angle(placing.turn / before)) <= share * MAX_TURN_RATE * DT * (1.0 + 1e-9)


def test_follower_keeps_recorded_minimum_distance_from_leader() -> None:
    leader, units = led_pair(56)
    reader = FollowerFilter(units, rate=RATE)
    x = leader_cloud(leader)
    reader.process_frame(x.floor[0], x.height[0])
    middle = complex(x.floor[0, :2].mean())
    real, _ = root_track(units.examples[0].follower)
    apart = np.abs(real - x.floor[:, :2].mean(axis=1))
    assert (apart < reader.min_distance - 1e-3).mean() < 0.03  # of all moments, 7.5 a second, it is one percent
    pushed = reader.keep_distance(middle + 0.5j * reader.min_distance)
    assert pushed == pytest.approx(middle + 1j * reader.min_distance)
    assert reader.keep_distance(middle + 2.0 * reader.min_distance) == middle + 2.0 * reader.min_distance


def test_regression_is_the_textbook_one() -> None:
    """Against kernel ridge regression by numpy, from the same features: the mean over both methods is taken apart."""
    leader, units = led_pair(57, 300)
    reader = FollowerFilter(units, rate=RATE)
    model = reader.model
    rows = model.rows
    square = ((rows[:, :, None] - rows[:, None]) ** 2).sum(axis=0) / model.share.sum()
    kernel = np.exp(-square / (2.0 * KERNEL_WIDTH**2))
    weights = np.linalg.solve(kernel + RIDGE * np.eye(model.count), model.moments.target - model.mean)
    np.testing.assert_allclose(model.weights, weights, atol=3e-5)
    x = leader_cloud(leader).resampled(RATE)
    for n in range(61):
        reader.process_frame(x.floor[n], x.height[n])
    at = 60 // model.stride
    told = 2.0 * reader.expected - reader._now
    places = slice(0, 66)
    np.testing.assert_allclose(told[places], (kernel[at] @ weights + model.mean)[places], atol=1e-3)


def test_filter_is_the_textbook_one() -> None:
    """Against a forward filter with a whole matrix of transitions."""
    leader, units = led_pair(58, 300)
    reader = FollowerFilter(units, rate=RATE)
    model, follows = reader.model, reader.model.moments.follows
    count = model.count
    move = np.zeros((count, count))
    for m in range(count):
        move[m, m] += STAY * (1.0 - JUMP_PROBABILITY)
        if follows[m] > 0:
            move[m, m + 1] += GO_ON * (1.0 - JUMP_PROBABILITY)
        if follows[m] > 1:
            move[m, m + 2] += SKIP * (1.0 - JUMP_PROBABILITY)
        np.add.at(move[m], model.jump_to[m], JUMP_PROBABILITY * model.jump_share[m])
    posterior = np.full(count, 1.0 / count)
    x = leader_cloud(leader).resampled(RATE)
    for n in range(80):
        reader.process_frame(x.floor[n], x.height[n])
        if n % model.stride == 0:
            near = reader._near_square
            seen = np.exp(-near / (2.0 * SEEN_WIDTH**2)) * (1.0 + EXACT_GAIN * np.exp(-near / (2.0 * EXACT_WIDTH**2)))
            posterior = (posterior @ move + ANYWHERE / count) * seen
            posterior /= posterior.sum()
            np.testing.assert_allclose(reader.posterior, posterior, atol=1e-7)
