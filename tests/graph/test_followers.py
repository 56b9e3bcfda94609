"""Tests of the successors of a step against the edges of the graph."""

from dataclasses import replace

import numpy as np

from live.graph.clusters import successors
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from tests.fixtures.made_steps import made_clip, made_steps


def test_successors_match_graph_with_best_cost():
    library = build_library([*made_steps(), made_clip("arms up", arm=-1.2)])
    graph = build_graph(library, threshold=0.2)
    for step in range(len(library.steps)):
        costs = {}
        for node in np.flatnonzero(library.node_step == step):
            for edge in range(graph.edge_start[node], graph.edge_start[node + 1]):
                target = graph.edge_target[edge]
                if library.node_measure[target] == 0:
                    name = library.steps[library.node_step[target]]
                    costs.setdefault(name, []).append(graph.edge_cost[edge])
        found = {f.step: f for f in successors(library, step, threshold=0.2)}
        if costs:  # alive in the graph
            assert found.keys() == costs.keys()
            for name, own in costs.items():
                assert found[name].pairs == len(own)
                assert found[name].distance_m == min(own)


def test_successors_are_sorted_and_match_structure():
    library = build_library([made_clip("a"), made_clip("b", arm=1.3), replace(made_clip("c"), begin_pose="x")])
    names = [f.step for f in successors(library, 0, threshold=0.2)]
    assert names == ["a", "c", "b"]
    ends = build_library(
        [replace(made_clip("a"), end_pose="y"), made_clip("b"), replace(made_clip("c"), begin_pose="x")]
    )
    assert [f.step for f in successors(ends, 0, threshold=0.2)] == ["a", "b"]
    assert successors(library, 0, threshold=-1.0) == []
