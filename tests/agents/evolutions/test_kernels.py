"""Evolution kernels against plain numpy and invariants (T088, T101)."""

import numpy as np
import pytest

from live.agents.evolutions import evolution_kernels, joint_kernels
from live.agents.evolutions.incremental_assignment import run_to_end
from live.agents.evolutions.paths import separate_in_pieces
from live.agents.evolutions.trajectory import GroupState, Locomotion


def make_locomotion(ways, times, soft=0.25):
    ways = np.array(ways, np.float32)
    times = np.array(times, float)
    turns = np.zeros((len(ways), 3, 2))
    turns[:, :, 0] = np.linspace(times[:, 0], times[:, 1], 3).T
    turns[:, :, 1] = [0.0, 1.0, -1.0]
    return Locomotion(ways, times, turns, soft)


@pytest.mark.parametrize("soft", [0.0, 0.1, 0.25, 0.5])
def test_speed_profile_runs_from_zero_to_one_continuously(soft):
    t = np.linspace(0, 1, 2001)
    share = np.array([evolution_kernels.profile(x, soft) for x in t])
    speed = np.gradient(share, t)
    assert share[0] == 0.0
    assert share[-1] == 1.0
    assert share + share[::-1] == pytest.approx(np.ones_like(t), abs=1e-9)
    assert speed.max() == pytest.approx(1 / (1 - soft), rel=2e-3)
    if soft > 0:
        assert speed[0] < 0.01
        assert np.abs(np.gradient(speed, t)).max() <= 1.5 / soft / (1 - soft) * 1.02


def test_velocities_match_positions_and_ends_are_held():
    curve = [[[0, 0], [1, 0.2], [2, 1], [2, 2], [1, 3]], [[5, 5], [5, 4], [5, 3], [5, 2], [5, 1]]]
    moved = make_locomotion(curve, [[2.0, 6.0], [3.0, 9.0]])
    beats = np.linspace(1, 10, 1801)
    places, headings = moved.sample(beats)
    out = GroupState(2)
    speeds = []
    for beat in beats:
        moved.evaluate(float(beat), out)
        speeds.append(out.velocity.copy())
    assert np.array(speeds)[1:-1] == pytest.approx(np.gradient(places, beats, axis=0)[1:-1], abs=0.02)
    assert places[0] == pytest.approx(np.array([[0, 0], [5, 5]]))
    assert places[-1] == pytest.approx(np.array([[1, 3], [5, 1]]))
    assert np.interp(4.0, beats, places[:, 0, 0]) == pytest.approx(2.0, abs=0.01)  # half of the time, middle knot
    assert headings[:, 1] == pytest.approx(np.interp(beats, [3, 6, 9], [0, 1, -1]), abs=1e-6)


def test_unselected_rows_are_unchanged():
    moved = make_locomotion([[[0, 0], [1, 0]], [[2, 0], [3, 0]]], [[0.0, 1.0]] * 2)
    out = GroupState(5)
    moved.write(1.0, np.array([4, 1], np.int32), np.array([1, 0], np.uint8), out)
    assert out.controlled.tolist() == [0, 0, 0, 0, 1]
    assert out.position[4].tolist() == [1.0, 0.0]


def test_samples_match_positions_on_straight_paths():
    moved = make_locomotion([[[0, 0], [4, 1]], [[1, 1], [0, 0]]], [[0.0, 4.0], [2.0, 4.0]])
    beats = np.linspace(-1, 5, 13)
    sample = np.zeros((13, 2, 2), np.float32)
    evolution_kernels.sample_paths(beats, moved.path_knots, moved.times, moved.ramp, 0, 2, sample)
    assert sample == pytest.approx(moved.sample(beats)[0], abs=1e-5)


def test_nearest_approach_is_found_between_samples():
    sample = np.random.default_rng(3).uniform(-3, 3, (4, 5, 2)).astype(np.float32)
    distance, when = np.zeros((5, 5), np.float32), np.zeros((5, 5), np.float32)
    step = np.zeros(5)
    evolution_kernels.longest_moves(sample, 0, 5, step)
    assert step == pytest.approx(np.hypot(*np.diff(sample, axis=0).T).max(axis=1), rel=1e-6)
    evolution_kernels.nearest_approach(sample, step, np.inf, 0, 5, distance, when)
    at = np.linspace(0, 3, 3001)
    fine = np.stack([[np.interp(at, range(4), sample[:, d, a]) for a in range(2)] for d in range(5)])
    for i in range(5):
        for j in range(5):
            apart = np.hypot(*(fine[i] - fine[j]))
            assert distance[i, j] == (np.inf if i == j else pytest.approx(apart.min(), abs=3e-3))
            if i != j:
                assert np.interp(when[i, j], at, apart) == pytest.approx(apart.min(), abs=3e-3)


def test_tracking_adds_path_velocity_and_position_correction():
    rows = np.full((2, 8), 7, np.float32)
    now = np.array([[0, 0], [0, 0]], np.float32)
    evolution_kernels.track(now, now + np.float32(0.3), now + np.float32(1), np.array([1, 0], np.uint8), 2.0, 0.3, rows)
    assert rows[0, :2] == pytest.approx([3.0, 3.0], abs=1e-5)
    assert rows[0, 6] == 1.0
    assert (rows[1] == 7).all()


@pytest.mark.parametrize("freedom", [0.0, 0.5, 1.0])
def test_colliding_pair_is_separated_in_opposite_directions_with_fixed_ends(freedom):
    """T101: shifted along one direction, by the same length, as far as needed."""
    t = np.linspace(-1, 1, 33)
    sample = np.stack([np.stack([t * 3, t * 0], 1), np.stack([-t * 3, t * 0], 1)]).astype(np.float32)
    offset = np.zeros_like(sample)
    assert run_to_end(separate_in_pieces(sample, offset, 0.5, 1.0, freedom, 5)) >= 1
    assert (offset[:, [0, -1]] == 0).all()
    assert offset[0] == pytest.approx(-offset[1], abs=1e-6)
    apart = np.hypot(*np.moveaxis(sample[0] + offset[0] - sample[1] - offset[1], -1, 0))
    assert apart[1:-1].min() >= 0.5 - 1e-5
    if freedom == 0.0:
        assert offset[:, 16, 0] == pytest.approx([0, 0], abs=1e-6)  # perpendicular to the path
    other = np.zeros_like(sample)
    run_to_end(separate_in_pieces(sample, other, 0.5, 1.0, freedom, 8))
    assert not np.allclose(offset, other)


def test_path_smoothing_weights_are_quarter_half_quarter():
    ways = np.random.default_rng(1).normal(size=(2, 6, 2)).astype(np.float32)
    expected = ways.copy()
    expected[:, 1:-1] = 0.25 * ways[:, :-2] + 0.5 * ways[:, 1:-1] + 0.25 * ways[:, 2:]
    evolution_kernels.smooth_paths(ways)
    assert ways == pytest.approx(expected, abs=1e-6)


def test_swaps_skip_dancers_without_slot_and_other_sections():
    start = np.array([[0.0, 0], [1, 0], [2, 0], [9, 9]])
    slots = np.array([[0.0, 1], [1, 1], [2, 1]])
    slot = np.array([1, 0, 2, -1], np.int32)
    assert evolution_kernels.swap_pairs(start, slots, slot, np.array([0, 1, 0, 0], np.int32), 0, 4) == 0
    assert evolution_kernels.swap_pairs(start, slots, slot, np.zeros(4, np.int32), 0, 4) == 1
    assert slot.tolist() == [0, 1, 2, -1]


def test_two_who_meet_head_on_are_shifted_to_their_right_within_their_times():
    """T147: equal shifts, smooth, none before the start and after the arrival; an obstacle alone moves nobody."""
    line = np.linspace(-3.0, 3.0, 33)
    way = np.stack([np.stack([line, 0 * line], 1), np.stack([-line, 0 * line], 1)])
    rest, shift, count, work = way.copy(), np.zeros_like(way), np.zeros((2, 33)), np.zeros((3, 33))
    keep, free = np.full((2, 2), 0.6), np.array([[2, 30], [2, 30]])
    for give in (np.zeros(2), np.ones(2)):
        stride = np.full(2, 6.0 / 32)
        found = joint_kernels.shift_encounters(
            way, keep, 0.1, 0.01, stride, give, free, 5.0, 5.0, 0, 2, shift, count
        )  # fmt: skip
        assert found == give[0]
        joint_kernels.apply_shifts(shift, count, free, rest, 3.0, 3.0, 0.05, 0.03, 5.0, 5.0, work, way)
    moved = way - rest
    assert np.abs(moved[0] + moved[1]).max() < 1e-12
    assert moved[0, 16, 1] > 0.05  # who goes towards +x has the audience, +z, on the right
    assert not moved[:, :4].any()
    assert not moved[:, 29:].any()
    assert not shift.any()
    assert not count.any()
