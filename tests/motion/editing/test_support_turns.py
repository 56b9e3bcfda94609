from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion.editing.turn_insertion import MAX_SEGMENTS, SupportTurns, ease_progress, stack_turns, support_turns
from tests.motion.editing.made_steps import sketched_step


def random_turns(seed: int, rows: int = 3) -> SupportTurns:
    chance = np.random.default_rng(seed)
    ends = np.sort(chance.random((rows, 2 * MAX_SEGMENTS)), axis=-1)
    weight = chance.random((rows, MAX_SEGMENTS))
    weight[:, 5:] = 0.0
    start, stop = ends[:, ::2].copy(), ends[:, 1::2].copy()
    start[:, 5:] = stop[:, 5:] = 1.0
    return SupportTurns(
        start=start,
        stop=stop,
        weight=weight / weight.sum(axis=-1, keepdims=True),
        point=chance.uniform(-1, 1, (rows, MAX_SEGMENTS, 2)),
        point_stop=chance.uniform(-1, 1, (rows, MAX_SEGMENTS, 2)),
        softness=chance.choice((0.0, 0.25, 0.5), (rows, MAX_SEGMENTS)),
    )


def displacement_by_loop(turns: SupportTurns, row: int, angle: float, until: float, count: int) -> complex:
    """Turn in small angles about the moving point, as the thesis does per frame; z + i x of the displacement."""
    matrix, moved = complex(1.0), complex(0.0)
    for n in range(MAX_SEGMENTS):
        start, stop = turns.start[row, n], turns.stop[row, n]
        passed = np.clip((until - start) / max(stop - start, 1e-12), 0.0, 1.0)
        progress = ease_progress(np.linspace(0.0, passed, count + 1), turns.softness[row, n])
        for a, b in pairwise(progress):
            where = turns.point[row, n] + 0.5 * (a + b) * (turns.point_stop[row, n] - turns.point[row, n])
            point = complex(where[1], where[0])
            held = matrix * point + moved
            matrix *= np.exp(1j * angle * turns.weight[row, n] * (b - a))
            moved += held - (matrix * point + moved)
    return moved


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000), st.floats(-7.0, 7.0), st.floats(0.0, 1.0))
def test_displacement_is_limit_of_loop(seed: int, angle: float, fraction: float) -> None:
    turns = random_turns(seed)
    x, z = turns.displacement(fraction, angle)[1]
    errors = [abs(displacement_by_loop(turns, 1, angle, fraction, count) - complex(z, x)) for count in (20, 80)]
    assert errors[1] < 2e-3
    assert errors[1] <= errors[0] / 4.0 + 1e-9  # at least first order; it is second


@given(st.integers(0, 1000), st.floats(-7.0, 7.0))
def test_share_goes_from_zero_to_one(seed: int, angle: float) -> None:
    turns = random_turns(seed)
    assert turns.share(0.0) == pytest.approx(0.0)
    assert turns.share(1.0) == pytest.approx(1.0)
    assert turns.displacement(0.0, angle) == pytest.approx(0.0)
    assert turns.displacement(0.5, 0.0) == pytest.approx(0.0)


@given(st.integers(0, 1000))
def test_share_never_decreases(seed: int) -> None:
    turns = random_turns(seed, rows=1)
    assert (np.diff(turns.share(np.linspace(0.0, 1.0, 200))) >= -1e-12).all()


def test_turn_about_one_point_is_plain_rotation() -> None:
    turns = random_turns(1, rows=1)
    there = np.full_like(turns.point, 0.7)
    same = replace(turns, point=there, point_stop=there)
    yaw = 1.1 * same.share(0.6)[0]
    x, z = 0.7 * np.cos(yaw) + 0.7 * np.sin(yaw), 0.7 * np.cos(yaw) - 0.7 * np.sin(yaw)
    assert same.displacement(0.6, 1.1)[0] == pytest.approx([0.7 - x, 0.7 - z])


def test_many_dancers_match_single_dancers() -> None:
    turns = stack_turns([support_turns(sketched_step(name), 0) for name in ("walk", "samba", "kick")])
    nodes = np.array((2, 0, 1, 1))
    fraction, angle = np.array((0.1, 0.5, 0.7, 1.0)), np.array((0.3, -1.0, 2.0, 0.0))
    dancers = turns.select(nodes)
    assert dancers.share(fraction).shape == (4,)
    assert dancers.displacement(fraction, angle).shape == (4, 2)
    for n, node in enumerate(nodes):
        one = turns.select(np.array((node,)))
        assert dancers.displacement(fraction, angle)[n] == pytest.approx(one.displacement(fraction[n], angle[n])[0])
        assert dancers.share(fraction)[n] == pytest.approx(one.share(fraction[n])[0])


@pytest.mark.long
@given(st.floats(0.0, 0.5))
def test_eased_progress_is_monotonic_and_symmetric(softness: float) -> None:
    passed = np.linspace(0.0, 1.0, 101)
    progress = ease_progress(passed, softness)
    assert progress[[0, 50, 100]] == pytest.approx([0.0, 0.5, 1.0])
    assert (np.diff(progress) >= 0.0).all()
    assert progress + progress[::-1] == pytest.approx(np.ones(101))
    assert np.diff(progress).max() * 100.0 <= 1.0 / (1.0 - softness) + 1e-9


def test_eased_progress_starts_and_ends_at_rest() -> None:
    near = ease_progress(np.array((1e-3, 1.0 - 1e-3)), 0.5)
    assert near == pytest.approx([2e-6, 1.0 - 2e-6])
    assert ease_progress(np.array((0.0, 0.3, 1.0)), 0.0) == pytest.approx([0.0, 0.3, 1.0])


@pytest.mark.long
@given(st.integers(0, 1000))
def test_maximum_speed_bounds_slope_of_share(seed: int) -> None:
    turns = random_turns(seed, rows=1)
    x = np.linspace(0.0, 1.0, 20_001)
    steepest = np.diff(turns.share(x)).max() / (x[1] - x[0])
    assert steepest <= turns.max_speed[0] * (1.0 + 1e-6)
    assert support_turns(sketched_step("walk"), 0).max_speed == pytest.approx(
        np.diff(support_turns(sketched_step("walk"), 0).share(x)).max() / (x[1] - x[0])
    )
