"""Tests of one search layer against numpy, nodes without edges included."""

import numpy as np

from live.graph.distance_kernels import cheapest_successors


def test_layer_is_minimum_over_edges_of_each_node():
    chance = np.random.default_rng(2)
    node, first = np.array([0, 2, 3, 7]), np.array([0, 4, 5, 11])
    target, cost = chance.integers(0, 9, 20).astype(np.int32), chance.uniform(size=20)
    value = np.where(chance.uniform(size=9) < 0.3, np.inf, chance.uniform(size=9))
    out = np.zeros(9)
    cheapest_successors(out, node, first, target, cost, value)
    expected = np.full(9, np.inf)
    expected[node] = np.minimum.reduceat(cost + value[target], first)
    np.testing.assert_array_equal(out, expected)
    assert np.isfinite(out).sum() == 4


def test_nodes_without_edges_have_infinite_cost():
    out, none = np.zeros(3), np.zeros(0)
    cheapest_successors(out, np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.int32), none, np.ones(3))
    assert np.isinf(out).all()
