"""Predicted collisions, against the same rules in plain Python."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.agents.separation.collision_prediction_kernels import MAX_RANGE, predict_collisions

RADIUS = 0.25
SLACK = 0.03


def collision_moments(ways, things=(), *, yields=None, here=None):
    """Moments of predicted collisions of each dancer of `ways` (K, A, 2) with others or with `things` (K, M, 2)."""
    ways = np.ascontiguousarray(ways, np.float64)
    count = ways.shape[1]
    things = np.ascontiguousarray(things, np.float64).reshape(len(ways), -1, 2)
    padded = np.zeros((len(ways), 8, 2))
    padded[:, : things.shape[1]] = things
    out = np.full(count, 9.0)
    predict_collisions(
        ways,
        np.full(count, RADIUS, np.float32),
        np.ones(count, np.float32) if yields is None else np.array(yields, np.float32),
        np.ones(count, np.bool_) if here is None else np.array(here),
        2.0,
        1.5,
        padded,
        np.full(8, RADIUS, np.float32),
        things.shape[1],
        SLACK,
        out,
    )
    return out


def straight_paths(start, way):
    """Paths of constant speed over the moments 0, 1 and 2."""
    start, way = np.array(start, float), np.array(way, float)
    return np.stack([start, start + way, start + 2 * way])


def test_faster_dancer_of_a_colliding_pair_yields():
    ways = straight_paths([(0, 0), (0.7, 0)], [(0.1, 0), (-0.4, 0)])
    assert collision_moments(ways).tolist() == [0, 1]
    assert collision_moments(ways[:, ::-1]).tolist() == [1, 0]


def test_dancer_with_right_of_way_does_not_yield():
    ways = straight_paths([(0, 0), (0.7, 0)], [(0.1, 0), (-0.4, 0)])
    assert collision_moments(ways, yields=[1, 0]).tolist() == [1, 0]


@pytest.mark.parametrize(
    ("start", "way"),
    [
        ([(0, 0), (0.6, 0)], [(0.3, 0), (0.3, 0)]),  # side by side
        ([(0, 0), (0.4, 0)], [(-0.02, 0), (0.02, 0)]),  # too near, but going apart
        ([(0, 0), (1.5, 0)], [(0.3, 0), (-0.3, 0)]),  # collision later
    ],
)
def test_pair_without_timely_approach_has_no_collision(start, way):
    assert not collision_moments(straight_paths(start, way)).any()


def test_obstacles_have_longer_prediction_range_than_dancers():
    walker = straight_paths([(2.0, 0)], [(-0.9, 0)])
    assert collision_moments(straight_paths([(0, 0)], [(0, 0)]), walker).tolist() == [2]
    both = np.concatenate([straight_paths([(0, 0)], [(0, 0)]), walker], axis=1)
    assert not collision_moments(both).any()


def test_absent_dancer_causes_no_collision():
    ways = straight_paths([(0, 0), (0.7, 0)], [(0.1, 0), (-0.4, 0)])
    assert not collision_moments(ways, here=[True, False]).any()


@given(st.integers(0, 2**32 - 1))
def test_crowd_prediction_matches_pairwise_rules(seed):
    chance = np.random.default_rng(seed)
    count = 14
    ways = straight_paths(chance.uniform(-1.5, 1.5, (count, 2)), chance.uniform(-0.5, 0.5, (count, 2)))
    wanted = np.zeros(count)
    for i in range(count):
        for j in range(i + 1, count):
            before, after = ways[0, j] - ways[0, i], ways[1, j] - ways[1, i]
            if np.abs(before).max() > MAX_RANGE:
                continue
            distance = np.hypot(*after)
            if distance < 2 * RADIUS - SLACK and distance < np.hypot(*before) - 0.01:
                to = before / np.hypot(*before)
                farther = (ways[1, i] - ways[0, i]) @ to > (ways[1, j] - ways[0, j]) @ -to
                wanted[i if farther else j] = 1
    assert collision_moments(ways).tolist() == wanted.tolist()
