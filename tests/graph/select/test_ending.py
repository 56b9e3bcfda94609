"""Measures' ends in one pass, against placing and joining done one after the other."""

import numpy as np

from live.graph.select.candidates import next_axes, own_end, turn_vectors
from tests.motion.pose.test_gather_kernels import COUNT, GRAPH, danced


def test_ends_and_axes_are_those_of_placing_and_joining():
    one, placed = danced(5), np.empty((COUNT, 4))
    one.placements_at(np.ones(COUNT), placed)
    end, facing = own_end(GRAPH, one.node, one.take, one.take_share[0].astype(np.float64))
    hips, heading, axes = one.ends_and_axes()
    np.testing.assert_allclose(hips, placed[:, :2] + turn_vectors(end, placed[:, 2]), atol=1e-12)
    np.testing.assert_allclose(heading, placed[:, 3] + facing, atol=1e-12)
    np.testing.assert_allclose(axes, next_axes(GRAPH, one.node, hips, heading), atol=1e-12)


def test_who_leaps_ends_where_her_new_clip_does_and_nobody_else():
    one, rows = danced(6), np.array([3, 9], np.int32)
    before = one.ends()[0]
    one.replace_node(rows, (one.node[rows] + 1) % GRAPH.library.node_count, one.placement[rows])
    fresh = danced(6)
    fresh.copy_from(one)
    fresh._ends = None
    for known, anew in zip(one.ends_and_axes(), fresh.ends_and_axes(), strict=True):
        np.testing.assert_array_equal(known, anew)
    changed = (one.ends()[0] != before).any(axis=1)
    assert changed[rows].all()
    assert changed.sum() == 2
