"""Tests of follower placement: it approaches the expected placement without jumps, and slowly while a foot stands."""

import numpy as np
import pytest

from live.motion.partner.point_clouds import Cloud, ends_cloud, fit, time_scaled
from live.motion.partner_live.online_decoder import MIN_FRAMES, SCORE_SPREAD, OnlineDecoder, root_track
from live.motion.partner_live.online_player import MAX_SPEED, MAX_TURN_RATE, FloorTransform
from tests.motion.partner.test_answer import pair_of

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
    for _ in range(60):
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
    leader, units = pair_of(56)
    reader = OnlineDecoder(units, rate=30.0, stretch=0.15, k=4.0)
    x = ends_cloud(leader)
    reader.process_frame(x.floor[0], x.height[0], boundary=True, unit_frames=None)
    middle = complex(x.floor[0, 2:].mean())
    real, _ = root_track(units.examples[0].follower)
    apart = np.abs(real - units.examples[0].control.floor[:, 2:].mean(axis=1))
    assert (apart < reader.min_distance).mean() < 0.02
    pushed = reader.keep_distance(middle + 0.5j * reader.min_distance)
    assert pushed == pytest.approx(middle + 1j * reader.min_distance)
    assert reader.keep_distance(middle + 2.0 * reader.min_distance) == middle + 2.0 * reader.min_distance


def test_expected_root_is_weighted_mean_of_running_units() -> None:
    """Against single fits of the input so far to each unit, weighted by score; the leader dances none of the units."""
    _, units = pair_of(55)
    leader, _ = pair_of(57)
    x = ends_cloud(leader).resampled(RATE)
    reader = OnlineDecoder(units, rate=RATE, stretch=0.15, k=4.0)
    last = 111
    for n in range(last + 1):
        reader.process_frame(x.floor[n], x.height[n], boundary=n % 5 == 0, unit_frames=None)
    step = units.rate / RATE
    found: list[tuple[float, complex, complex]] = []
    for begin in range(0, last + 2 - round(MIN_FRAMES), 5):
        seen = last - begin
        window = Cloud(x.floor[begin : last + 1], x.height[begin : last + 1], RATE)
        for unit in range(units.count):
            worth = reader.unit_score(unit, begin)
            if not np.isfinite(worth) or seen * step > 1.1 * units.length[unit]:
                continue
            of = units.examples[int(units.example[unit])]
            one = fit(window, time_scaled(of.control, float(units.start[unit]), seen * step, seen))
            real, front = root_track(of.follower)
            at = round(units.start[unit] + seen * step)
            found.append((worth, one.turn * real[at] + one.shift, one.turn * front[at]))
    worths = np.array([worth for worth, _, _ in found])
    near = worths < worths.min() + 8.0 * SCORE_SPREAD
    weights = np.exp(-(worths - worths.min()) / SCORE_SPREAD) * near
    expected = reader.expected_root()
    assert expected is not None
    assert weights.sum() > 2.0
    place, facing = (np.sum(weights * np.array([one[n] for one in found])) for n in (1, 2))
    assert abs(expected[0] - place / weights.sum()) < 0.01  # recordings are interpolated between samples
    assert abs(np.angle(expected[1] / facing)) < 0.01
