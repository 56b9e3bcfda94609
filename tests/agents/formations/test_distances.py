"""Distances between places against SciPy's tree, bit by bit: drawings of formations depend on them."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from live.agents.formations.distances import close_pairs, closest_distance

DRAW = np.random.default_rng(5)
GRID = np.stack(np.meshgrid(np.arange(12.0), np.arange(9.0)), axis=-1).reshape(-1, 2)
PLACES = {
    "spread": DRAW.normal(size=(300, 2)) * (7.0, 3.0),
    "deep": DRAW.normal(size=(300, 2)) * (0.1, 9.0),
    "grid": GRID,
    "column": np.stack([np.zeros(50), np.linspace(0.0, 9.0, 50)], axis=1),
    "doubled": np.concatenate([GRID, GRID[:3]]),
    "two": np.array([[0.0, 0.0], [3.0, 4.0]]),
}


@pytest.mark.parametrize("name", PLACES)
def test_closest_distance_is_that_of_a_tree(name):
    places = PLACES[name]
    assert closest_distance(places) == cKDTree(places).query(places, k=2)[0][:, 1].min()


@pytest.mark.parametrize("distance", [0.0, 0.3, 1.0, 5.0, 100.0])
@pytest.mark.parametrize("name", PLACES)
def test_close_pairs_are_those_of_a_tree(name, distance):
    found = close_pairs(PLACES[name], distance)
    assert sorted(map(tuple, found.tolist())) == sorted(cKDTree(PLACES[name]).query_pairs(distance))


@pytest.mark.parametrize("places", [np.zeros((0, 2)), np.zeros((1, 2))])
def test_fewer_than_two_places_have_no_distance(places):
    assert closest_distance(places) == math.inf
    assert close_pairs(places, 1.0).shape == (0, 2)
