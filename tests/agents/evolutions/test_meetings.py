"""Colliding pairs are those whose nearest approach is too close, pair by pair, for any paths."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.evolutions.evolution_kernels import (
    count_collisions,
    longest_moves,
    longest_steps,
    nearest_approach,
    pair_collides,
)

COUNT, TIMES = 12, 33


def random_paths(seed, speed):
    chance = np.random.default_rng(seed)
    start = chance.uniform(-2.0, 2.0, (COUNT, 1, 2))
    return np.ascontiguousarray(start + np.cumsum(chance.normal(0.0, speed, (COUNT, TIMES, 2)), axis=1), np.float32)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from((0.0, 0.01, 0.1, 1.0)), st.floats(0.05, 1.5))
def test_colliding_pairs_match_nearest_approach(seed, speed, clear):
    ways, step = random_paths(seed, speed), np.zeros(COUNT)
    distance, when = np.zeros((2, COUNT, COUNT), np.float32)
    sample = np.ascontiguousarray(ways.transpose(1, 0, 2))
    longest_moves(sample, 0, COUNT, step)
    nearest_approach(sample, step, np.inf, 0, COUNT, distance, when)
    every, at = np.zeros((2, COUNT, COUNT), np.float32)
    nearest_approach(
        sample, np.full(COUNT, 1e9), np.inf, 0, COUNT, every, at
    )  # as if they might be anywhere: no time skipped
    assert np.array_equal(distance, every)
    assert np.array_equal(when, at)
    nearest_approach(sample, step, clear, 0, COUNT, every, at)
    assert np.array_equal(np.where(distance < clear, distance, np.inf), np.where(every < clear, every, np.inf))
    assert (every >= distance).all()
    longest_steps(ways, step)
    near = distance < np.float32(clear)
    for i in range(COUNT):
        for j in range(i + 1, COUNT):
            assert pair_collides(ways, i, j, clear, step[i] + step[j]) == near[i, j]
    assert count_collisions(ways, step, 0, COUNT, clear) == np.triu(near, 1).sum()
    assert sum(count_collisions(ways, step, n, n + 3, clear) for n in range(0, COUNT, 3)) == np.triu(near, 1).sum()
