"""Tests of step reach by direction: against clips and mixtures, and limits of travel requests."""

import math

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from live.graph.motion_graph import build_graph
from live.graph.select.candidates import find_candidates, widening_candidates
from live.graph.select.reachability import TABLED_DIRECTIONS, TURNS, ReachTable, reach_of, turned_displacements
from live.graph.step_library import build_library
from tests.fixtures.steps_of_the_project import project_steps


@pytest.fixture(scope="module")
def graph():
    return build_graph(build_library(project_steps("walk", "groove")))


@pytest.fixture(scope="module")
def ways(graph):
    return ReachTable.of(graph, widening_candidates(graph, find_candidates(graph)))


def straight_reach(graph, ways, step):
    return ways.farthest[graph.library.step_index(step), len(TURNS) // 2]


def test_farthest_travel_equals_reported_reach(graph, ways):
    walk = graph.library.step_index("walk")
    reach = reach_of(graph, find_candidates(graph), walk, 2.0)
    assert straight_reach(graph, ways, "walk").max() == pytest.approx(reach.max_travel, abs=0.04)


def test_reach_equals_convex_hull_of_ends(graph, ways):
    """Against scipy's hull of all candidates and of standing still, intersected by rays."""
    candidates = widening_candidates(graph, find_candidates(graph))
    walk = graph.library.step_index("walk")
    rows = np.flatnonzero((graph.library.node_step[candidates.node] == walk) & graph.alive[candidates.node])
    ends = turned_displacements(graph, candidates, rows.astype(np.int32), np.zeros(len(rows)))
    heading = graph.node_facing_start[candidates.node[rows]] - candidates.facing[rows]
    assert np.abs(heading).max() < 0.02  # no rotation, so no turn is inserted
    planes = ConvexHull(np.vstack([ends, np.zeros((1, 2))])).equations
    for direction in range(TABLED_DIRECTIONS):
        angle = direction * 2.0 * math.pi / TABLED_DIRECTIONS
        towards = planes[:, :2] @ [math.sin(angle), math.cos(angle)]
        far = (-planes[:, 2] / np.where(towards > 1e-9, towards, np.nan))[towards > 1e-9].min()
        assert straight_reach(graph, ways, "walk")[direction] == pytest.approx(far, abs=0.02)


def test_step_danced_in_place_has_no_reach(graph, ways):
    assert straight_reach(graph, ways, "groove").max() < 0.1


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.5])
def test_travel_is_limited_to_reach_without_turning(graph, ways, heading):
    walk = np.full(3, graph.library.step_index("walk"), np.int32)
    angle = heading + np.array([0.0, 0.4, math.pi / 2])
    way = np.array([4.0, 0.3, 3.0])[:, None] * np.column_stack([np.sin(angle), np.cos(angle)])
    cut = ways.limit_travel(walk, np.full(3, heading), np.zeros(3), way, np.full(3, 0.1))
    assert cut[1] == pytest.approx(way[1])  # near enough
    assert np.hypot(*cut[0]) == pytest.approx(straight_reach(graph, ways, "walk")[0] + 0.1)
    assert np.hypot(*cut[2]) == pytest.approx(straight_reach(graph, ways, "walk")[TABLED_DIRECTIONS // 4] + 0.1)
    across = cut[:, 0] * way[:, 1] - cut[:, 1] * way[:, 0]
    assert np.abs(across).max() < 1e-12


def test_any_step_reaches_as_far_as_farthest_step(graph, ways):
    way = np.array([[0.0, 9.0]])
    zero = np.zeros(1)
    found = ways.limit_travel(np.array([-1], np.int32), zero, zero, way, zero)
    assert found[0, 1] == pytest.approx(straight_reach(graph, ways, "walk")[0])
    assert 0.5 < found[0, 1] < 2.0
