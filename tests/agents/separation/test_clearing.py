"""Corrections never lead dancers into walls or obstacles, checked by brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.crowd.obstacles import Surroundings
from live.agents.separation.path_separation import MOMENTS, Paths, PathSeparation
from tests.agents.separation.made_paths import places_at

RADIUS = 0.25


def make_surroundings(*, walls=(), obstacles=()):
    made = Surroundings()
    for number, wall in enumerate(walls):
        assert made.set_wall(f"wall {number}", *wall)
    for number, obstacle in enumerate(obstacles):
        assert made.set_obstacle(f"thing {number}", *obstacle)
    return made


def build_separation(count, surroundings):
    radius, weights = np.full(count, RADIUS, np.float32), np.ones(count, np.float32)
    return PathSeparation(
        radius, weights, gap_at_end=0.7, half_width=6.0, half_depth=4.0, seed=1, surroundings=surroundings
    )


def straight_paths(*ways):
    """Straight paths from the first to the second point of each pair."""
    paths, at = Paths(len(ways)), np.linspace(0.0, 1.0, MOMENTS)
    for dancer, (begin, end) in enumerate(np.array(ways)):
        paths.path[dancer] = begin + at[:, None] * (end - begin)
    paths.share[:] = np.clip(2.0 * at - 0.3, 0.0, 1.0)
    return paths


def sample_paths(paths, goal):
    """Positions along the paths, (T, A, 2)."""
    aimed, found = np.zeros((len(goal), 3)), []
    for place in np.linspace(0.0, 1.0, 200):
        found.append(places_at(paths, place, goal, aimed))
    return np.array(found)


def separate_paths(paths, surroundings, most, goal=None):
    goal = np.zeros((len(paths.path), 2)) if goal is None else goal
    part = build_separation(len(goal), surroundings)
    for _ in range(25):
        part.separate(paths, goal, np.zeros((len(goal), 3)), np.full(len(goal), most))
    return goal


def test_path_grazing_an_obstacle_is_led_around_it():
    paths = straight_paths([(-1.5, 0.0), (1.5, 0.0)])
    around = make_surroundings(obstacles=[(0.5, -0.3, 0.2)])
    assert np.hypot(*(sample_paths(paths, np.zeros((1, 2)))[:, 0] - (0.5, -0.3)).T).min() < 0.31
    goal = separate_paths(paths, around, 0.35)
    assert goal[0, 1] > 0.1
    assert np.hypot(*(sample_paths(paths, goal)[:, 0] - (0.5, -0.3)).T).min() > 0.2 + RADIUS - 0.02


def test_path_ending_in_a_wall_stops_before_it():
    paths = straight_paths([(0.0, 0.0), (1.9, 0.0)], [(3.0, 1.0), (2.2, 1.0)])
    goal = separate_paths(paths, make_surroundings(walls=[(2.0, -3.0, 2.0, 3.0)]), 0.35)
    ends = sample_paths(paths, goal)[-1]
    assert ends[0, 0] == pytest.approx(2.0 - RADIUS, abs=0.02)
    assert ends[1, 0] == pytest.approx(2.0 + RADIUS, abs=0.02)  # each dancer stays on its side


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
def test_correction_never_causes_an_obstacle_collision(seed, count):
    """A path that is clear without a correction stays clear with it, within the allowed offset."""
    chance = np.random.default_rng(seed)
    middle = chance.uniform((-5, -3), (5, 3))
    around = make_surroundings(obstacles=[(*middle, 0.4)])
    begin = middle + 1.6 * _units(chance, count)
    paths = straight_paths(*zip(begin, begin + 0.8 * _units(chance, count), strict=True))
    clear = _distance(sample_paths(paths, np.zeros((count, 2))), middle) >= 0.4 + RADIUS + 0.02
    asked = 0.3 * _units(chance, count)
    for dancer in np.flatnonzero(clear):
        alone = straight_paths((begin[dancer], paths.path[dancer, -1]))  # no other dancer
        goal = separate_paths(alone, around, 0.35, asked[dancer : dancer + 1].copy())
        assert _distance(sample_paths(alone, goal), middle)[0] > 0.4 + RADIUS - 0.03
        assert np.hypot(*goal[0]) <= 0.35 + 1e-9


def _units(chance, count):
    angle = chance.uniform(0.0, 2.0 * np.pi, count)
    return np.stack([np.sin(angle), np.cos(angle)], 1)


def _distance(ways, middle):
    return np.hypot(*(ways - middle).transpose(2, 0, 1)).min(axis=0)


def test_push_never_moves_a_dancer_into_a_wall():
    """Two dancers overlap, one with a wall behind: it stays before the wall, and the two still separate."""
    around = make_surroundings(walls=[(1.0, -3.0, 1.0, 3.0)])
    part, place = build_separation(2, around), np.array([[0.7, 0.0], [0.4, 0.0]], np.float32)
    for _ in range(200):
        moved = part.push_apart(place, place, margin=0.05, stiffness=24.0, dt=1 / 64)
        if moved is None:
            break
        assert np.hypot(*moved.T).max() < 0.05
        place += moved.astype(np.float32)
        assert place[0, 0] <= 1.0 - RADIUS + 1e-4
    assert place[0, 0] - place[1, 0] > 2.0 * RADIUS - 0.02
