"""Parting: places that are too near move apart, nobody farther than allowed or without need."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.separation.path_separation import PlaceSeparation


def parting(count):
    return PlaceSeparation(count, 0.7, half_width=6.0, half_depth=4.0, seed=1)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 40), st.integers(0, 2**32 - 1), st.floats(0.0, 1.0))
def test_nobody_is_moved_farther_than_allowed_or_without_need(count, seed, most):
    chance = np.random.default_rng(seed)
    anchor = chance.uniform(-3, 3, (count, 2)).astype(np.float32)
    place = anchor.copy()
    parting(len(place))(place, anchor, most)
    assert np.isfinite(place).all()
    assert (np.hypot(*(place - anchor).T) <= most + 1e-5).all()
    apart = anchor * 10.0  # the same crowd with room for everybody, where there is any
    if _nearest(apart) > 0.7:
        place = apart.copy()
        parting(len(place))(place, apart, most)
        assert (place == apart).all()


def test_crowds_have_more_room_afterwards():
    """A single pair may come nearer while others part; what all pairs together lack of the gap shrinks each time."""
    for seed in range(100):
        anchor = np.random.default_rng(seed).uniform(-3, 3, (24, 2)).astype(np.float32)
        place = anchor.copy()
        parting(len(place))(place, anchor, 0.35)
        assert _lack(place) < 0.5 * _lack(anchor)


def test_a_crowd_in_one_place_parts_when_it_may():
    anchor = np.full((9, 2), 1.0, np.float32)
    place = anchor.copy()
    part = parting(9)
    for _ in range(5):
        part(place, anchor, 3.0)
    assert _nearest(place) > 0.65


def _nearest(place):
    apart = np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1)) + 9 * np.eye(len(place))
    return apart.min() if len(place) > 1 else 9.0


def _lack(place):
    """By how much all pairs together are nearer than 0.7 m [m]."""
    apart = np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1))[np.triu_indices(len(place), 1)]
    return np.maximum(0.7 - apart, 0.0).sum()
