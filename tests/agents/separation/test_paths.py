"""Colliding paths are separated, dancers in contact are pushed apart, agents stay near their dancers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.separation.path_separation import MARGIN, MOMENTS, Paths, PathSeparation
from live.agents.separation.path_separation_kernels import extrapolate_paths
from live.agents.separation.separation_kernels import tether_agents
from tests.agents.separation.made_paths import places_at
from tests.fixtures.mostly_long import mostly_long

RADIUS = 0.25


def random_straight_paths(count, seed):
    """Dancers on straight paths between random places."""
    chance = np.random.default_rng(seed)
    start, end = chance.uniform((-5, -3), (5, 3), (2, count, 2))
    paths = Paths(count)
    share = np.linspace(0, 1, MOMENTS)
    paths.path[:] = start[:, None] + share[None, :, None] * (end - start)[:, None]
    paths.share[:] = np.clip(2.0 * share - 0.4, 0.0, 1.0)
    return paths


def build_separation(count, **values):
    weights = values.pop("responsibility", np.ones(count, np.float32))
    radius = np.full(count, RADIUS, np.float32)
    return PathSeparation(radius, weights, gap_at_end=0.7, half_width=6.0, half_depth=4.0, seed=1)


def pair_distances(paths, goal, first=0.0):
    """Distances of all pairs at many moments, (T, A, A), by brute force."""
    aimed, found = np.zeros((len(goal), 3)), []
    for place in np.linspace(first, 1, 200):
        out = places_at(paths, place, goal, aimed)
        apart = np.hypot(*(out[:, None] - out[None]).transpose(2, 0, 1))
        np.fill_diagonal(apart, np.inf)
        found.append(apart)
    return np.array(found)


def test_head_on_paths_pass_each_other():
    paths, goal, aimed = Paths(2), np.zeros((2, 2)), np.zeros((2, 3))
    way = np.linspace(-1.0, 1.0, MOMENTS)
    paths.path[0, :, 0], paths.path[1, :, 0] = way, -way
    paths.path[1, :, 1] = 0.05
    paths.share[:] = np.clip(2.5 * np.linspace(0, 1, MOMENTS), 0.0, 1.0)
    part = build_separation(2)
    assert pair_distances(paths, goal).min() < 0.1
    for _ in range(12):
        part.separate(paths, goal, aimed, np.full(2, 0.35))
    assert pair_distances(paths, goal).min() > 2 * RADIUS + 0.9 * MARGIN
    assert goal[0] == pytest.approx(-goal[1], abs=0.02)  # the offset is shared
    part.separate(paths, goal, aimed, np.full(2, 0.35))
    assert part.shortfall.max() < 0.01


@mostly_long("seed", range(6), quick=[0, 3])
def test_missing_distances_are_those_of_all_pairs(seed):
    """Boxes around the corrected paths sort out most pairs: what is left has what brute force finds."""
    chance = np.random.default_rng(seed)
    paths, goal = random_straight_paths(40, seed), chance.uniform(-1.5, 1.5, (40, 2))
    paths.path[:] = paths.path[:, :1] + 0.1 * (paths.path - paths.path[:, :1])
    paths.share[:] = np.linspace(0.0, 0.08, MOMENTS)  # too little of the corrections for the round to change them
    part, before = build_separation(40), goal.copy()
    part.separate(paths, goal, np.zeros((40, 3)), np.full(40, 2.0))
    np.testing.assert_array_equal(goal, before)
    apart = pair_distances(paths, goal)
    lack = np.maximum(2 * RADIUS + MARGIN - apart.min(axis=0), 0.7 - apart[-1]).max(axis=1)
    found = lack > 0.01
    assert 5 < found.sum() < 40
    np.testing.assert_allclose(part.shortfall[found], lack[found], atol=5e-3)
    assert part.shortfall[lack < -0.01].max(initial=-1.0) <= 0.0


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(st.integers(2, 20), st.integers(0, 2**32 - 1), st.floats(0.05, 0.35))
def test_paths_are_offset_within_limit_and_only_when_needed(count, seed, most):
    paths, goal, aimed = random_straight_paths(count, seed), np.zeros((count, 2)), np.zeros((count, 3))
    before = pair_distances(paths, goal)
    part = build_separation(count)
    for _ in range(8):
        part.separate(paths, goal, aimed, np.full(count, most))
    assert (np.hypot(*goal.T) <= most + 1e-9).all()
    free = (before.min(axis=0) > 2 * RADIUS + 0.45 + 2 * most).all(axis=1)
    assert not goal[free].any()


@pytest.mark.long
def test_separation_takes_most_of_the_overlap_of_crossing_crowds():
    """Paths that touch are far enough apart: what counts is how deep bodies are in each other."""
    deep, contacts = np.zeros(2), np.zeros(2)
    for seed in range(10):
        paths, goal = random_straight_paths(12, seed), np.zeros((12, 2))
        part = build_separation(12)
        for after in range(2):
            overlap = np.maximum(2 * RADIUS - pair_distances(paths, goal, 0.5), 0.0)
            deep[after] += overlap.sum()
            contacts[after] += (overlap.max(axis=0) > 0.02).sum()
            for _ in range(20):
                part.separate(paths, goal, np.zeros((12, 3)), np.full(12, 0.35))
    assert deep[1] < 0.15 * deep[0]
    assert contacts[1] < 0.5 * contacts[0]  # a third of a metre is not enough for all


def test_soloist_and_absent_dancer_are_not_offset():
    paths, goal, aimed = Paths(3), np.zeros((3, 2)), np.zeros((3, 3))
    paths.path[:] = np.array([[0.0, 0.0], [0.3, 0.0], [0.1, 0.1]], np.float32)[:, None]
    paths.share[:] = np.linspace(0, 1, MOMENTS)
    part = build_separation(3, responsibility=np.array([0.0, 1.0, 1.0], np.float32))
    part.set_present(np.array([3, 3, 0], np.int8), 3)
    for _ in range(10):
        part.separate(paths, goal, aimed, np.full(3, 0.6), place=0.5)
    assert not goal[(0, 2), :].any()
    assert goal[1, 0] > 0.2


@settings(max_examples=20, deadline=None)
@given(st.floats(0.0, 0.55), st.floats(0, 6.3))
def test_dancers_in_contact_are_pushed_apart_smoothly(apart, angle):
    part, now = build_separation(2), np.zeros((2, 2), np.float32)
    now[1] = apart * np.sin(angle), apart * np.cos(angle)
    way = []
    for _ in range(64):
        moved = part.push_apart(now, now, margin=0.05, stiffness=18.0, dt=1.0 / 64.0)
        moved = np.zeros((2, 2)) if moved is None else moved
        way.append(moved.copy())
        now += moved.astype(np.float32)
    assert np.hypot(*(now[1] - now[0])) > 0.54
    speed = np.array(way) * 64.0
    assert np.abs(np.diff(speed, axis=0, prepend=0.0)).max() < 1.3  # of 3.6 m/s at most


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_tethered_agents_stay_near_their_dancers(seed):
    chance = np.random.default_rng(seed)
    position, velocity, dancer, pace = chance.normal(0, 1, (4, 9, 2)).astype(np.float32)
    most = chance.uniform(0.2, 2.0, 9).astype(np.float32)
    before, asked = position.copy(), velocity.copy()
    tether_agents(position, velocity, dancer, pace, most)
    away = position - dancer
    size = np.hypot(*away.T)
    assert (size <= most + 1e-5).all()
    near = np.hypot(*(before - dancer).T) <= most
    assert (position[near] == before[near]).all()
    assert (velocity[near] == asked[near]).all()
    out = ((velocity - pace) * away).sum(axis=1)[~near]
    assert (out <= 1e-5).all()  # no agent moves away from its dancer


WINDOW = 0.1875


def extrapolate_random_paths(fractions, *, goes_on, count=6):
    """Extrapolated positions of random dancers by the kernel (K, A, 2), their current positions, and by brute force the
    positions on this and the next measure's paths at each of `fractions`, (K + 1, A, 2) each.
    """
    chance = np.random.default_rng(3)
    paths, aimed = (random_straight_paths(count, 1), random_straight_paths(count, 2)), np.zeros((count, 3))
    goals, now = chance.normal(0.0, 0.2, (2, count, 2)), chance.normal(0.0, 1.0, (count, 2)).astype(np.float32)
    out = np.zeros((len(fractions) - 1, count, 2), np.float32)
    extrapolate_paths(
        paths[0].path, paths[0].share, goals[0], aimed, paths[1].path, paths[1].share, goals[1], aimed,
        goes_on, WINDOW, np.array(fractions), now, out, 0, count,
    )  # fmt: skip
    own, later = np.zeros((2, len(fractions), count, 2), np.float32)
    for k, fraction in enumerate(fractions):
        own[k] = places_at(paths[0], min(fraction, 1.0), goals[0], aimed)
        later[k] = places_at(paths[1], max(fraction - 1.0, 0.0), goals[1], aimed)
    return out, now, own, later


def test_extrapolation_adds_path_displacement():
    out, now, own, later = extrapolate_random_paths([0.3, 0.5, 0.75, 1.1, 1.4], goes_on=True)
    np.testing.assert_allclose(out[:2], now + own[1:3] - own[0], atol=1e-5)
    np.testing.assert_allclose(out[2:], now + later[3:] - own[0], atol=1e-5)
    out, now, own, _ = extrapolate_random_paths(
        [0.3, 0.95, 1.4], goes_on=False
    )  # without a next path the dancer stays at the end
    np.testing.assert_allclose(out, now + own[1:] - own[0], atol=1e-5)


def test_extrapolation_is_continuous_across_the_measure_line():
    fractions = np.linspace(0.7, 1.1, 401)
    out, *_ = extrapolate_random_paths([*fractions], goes_on=True)
    speed = np.hypot(*np.diff(out, axis=0).transpose(2, 0, 1)) / 0.001
    assert speed.max() < 1.5 * 12.0 / WINDOW  # paths far apart, blended
    beyond = out[fractions[1:] >= 1.0 - 1e-9]
    _, now, own, later = extrapolate_random_paths([0.7, 1.0], goes_on=True)
    np.testing.assert_allclose(beyond[0], now + later[1] - own[0], atol=1e-3)  # at the line the next path begins


def test_contact_during_the_path_causes_a_push():
    now = np.array([[0.0, 0.0], [0.9, 0.0]], np.float32)
    back = np.stack([now, now])
    assert build_separation(2).push_apart(now, back, margin=0.05, stiffness=24.0, dt=1.0 / 64.0) is None
    swing = back.copy()
    swing[0, 0, 0] = 0.5  # out and back
    moved = build_separation(2).push_apart(now, swing, margin=0.05, stiffness=24.0, dt=1.0 / 64.0)
    assert moved is not None
    assert moved[0, 0] < 0.0 < moved[1, 0]


@pytest.mark.parametrize("gap", [0.51, 0.53])
def test_push_from_one_side_causes_no_contact_on_the_other(gap):
    """Two outer dancers approach, the left one faster: the middle one is not pushed into the right one."""
    now = np.array([[-0.6, 0.0], [0.0, 0.0], [gap, 0.0]], np.float32)
    part, pair_distances = build_separation(3), np.inf
    for _ in range(48):
        soon = now.copy()
        soon[0, 0] = now[1, 0] - 0.2
        moved = part.push_apart(now, soon, margin=0.1, stiffness=24.0, dt=1.0 / 64.0)
        now = now if moved is None else now + moved.astype(np.float32)
        pair_distances = min(pair_distances, now[2, 0] - now[1, 0])
    assert pair_distances > 2 * RADIUS
    assert now[1, 0] > 0.02  # the middle dancer gives way together with its neighbor
