"""Tests of measure ends computed in one pass against separate placement and joining."""

import numpy as np

from live.graph.select.candidates import next_axes, own_end, turn_vectors
from tests.fixtures.hips import placements_at
from tests.motion.pose.test_gather_kernels import COUNT, GRAPH, random_measures


def test_ends_and_axes_match_separate_placement_and_joining():
    one = random_measures(5)
    placed = placements_at(one, np.ones(COUNT))
    end, facing = own_end(GRAPH, one.node, one.take, one.take_share[0].astype(np.float64))
    hips, heading, axes = one.ends_and_axes()
    np.testing.assert_allclose(hips, placed[:, :2] + turn_vectors(end, placed[:, 2]), atol=1e-12)
    np.testing.assert_allclose(heading, placed[:, 3] + facing, atol=1e-12)
    np.testing.assert_allclose(axes, next_axes(GRAPH, one.node, hips, heading), atol=1e-12)


def test_node_replacement_changes_only_ends_of_replaced_dancers():
    one, rows = random_measures(6), np.array([3, 9], np.int32)
    before = one.ends()[0]
    one.replace_node(rows, (one.node[rows] + 1) % GRAPH.library.node_count, one.placement[rows])
    fresh = random_measures(6)
    fresh.copy_from(one)
    fresh._ends = None
    for known, recomputed in zip(one.ends_and_axes(), fresh.ends_and_axes(), strict=True):
        np.testing.assert_array_equal(known, recomputed)
    changed = (one.ends()[0] != before).any(axis=1)
    assert changed[rows].all()
    assert changed.sum() == 2
