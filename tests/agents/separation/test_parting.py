"""Place separation: places too close move apart, within the limit and only where needed."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.separation.path_separation import PlaceSeparation


def place_separation(count):
    return PlaceSeparation(count, 0.7, half_width=6.0, half_depth=4.0, seed=1)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 40), st.integers(0, 2**32 - 1), st.floats(0.0, 1.0))
def test_places_move_within_limit_and_only_when_needed(count, seed, most):
    chance = np.random.default_rng(seed)
    anchor = chance.uniform(-3, 3, (count, 2)).astype(np.float32)
    place = anchor.copy()
    place_separation(len(place))(place, anchor, most)
    assert np.isfinite(place).all()
    assert (np.hypot(*(place - anchor).T) <= most + 1e-5).all()
    apart = anchor * 10.0  # the same crowd, scaled up
    if _smallest_distance(apart) > 0.7:
        place = apart.copy()
        place_separation(len(place))(place, apart, most)
        assert (place == apart).all()


def test_separation_halves_the_total_shortfall():
    """A single pair may get closer while others separate; the shortfall summed over all pairs shrinks each time."""
    for seed in range(100):
        anchor = np.random.default_rng(seed).uniform(-3, 3, (24, 2)).astype(np.float32)
        place = anchor.copy()
        place_separation(len(place))(place, anchor, 0.35)
        assert _total_shortfall(place) < 0.5 * _total_shortfall(anchor)


def test_coincident_places_separate_within_limit():
    anchor = np.full((9, 2), 1.0, np.float32)
    place = anchor.copy()
    part = place_separation(9)
    for _ in range(5):
        part(place, anchor, 3.0)
    assert _smallest_distance(place) > 0.65


def _smallest_distance(place):
    apart = np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1)) + 9 * np.eye(len(place))
    return apart.min() if len(place) > 1 else 9.0


def _total_shortfall(place):
    """Shortfall from 0.7 m, summed over all pairs [m]."""
    apart = np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1))[np.triu_indices(len(place), 1)]
    return np.maximum(0.7 - apart, 0.0).sum()
