"""Tests of clusters, structural variations and joins between steps against loops over the joins."""

from dataclasses import replace

import numpy as np
import pytest

from live.graph.build.transitions import all_pairs, transition_windows
from live.graph.clusters import connectivity, join_summaries, nearest_steps, structural_components
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.graph.structure_rules import may_follow_between
from tests.fixtures.made_steps import made_clip, made_steps


@pytest.fixture(scope="module")
def graph():
    clips = [
        *made_steps(),
        made_clip("arms up", arm=-1.2),
        replace(made_clip("échappé"), end_pose="Plié", begin_pose="Sous-sus"),
        replace(made_clip("échappé", arm=1.1), end_pose="plié ", begin_pose="Sous-sus"),
        replace(made_clip("échappé"), mirrored=True, begin_pose="Sous-sus"),
        replace(made_clip("spring", arm=1.15), weight_transfer=True, leading_foot="left", end_pose="Sous-sus"),
    ]
    return build_graph(build_library(clips), threshold=0.1, prune=False)


def test_components_are_structural_variations(graph):
    library = graph.library
    found = structural_components(library)
    assert sorted(node for one in found for node in one.nodes) == list(range(library.node_count))
    own = [one for one in found if library.steps[one.step] == "échappé"]
    assert {(one.side, one.begin_pose, one.end_pose, len(one.nodes)) for one in own} == {
        ("as danced", "sous-sus", "plié", 2),
        ("mirrored", "sous-sus", "", 1),
    }


def test_join_summaries_count_every_join_between_steps(graph):
    library, joins = graph.library, graph.joins
    counted: dict[tuple[int, int], list[float]] = {}
    for source, target, cost in zip(joins.source, joins.target, joins.cost, strict=True):
        if library.node_measure[target] == 0:
            pair = (int(library.node_step[source]), int(library.node_step[target]))
            counted.setdefault(pair, []).append(float(cost))
    found = join_summaries(graph, library.node_step, len(library.steps))
    assert {(one.source, one.target): (one.join_count, one.nearest) for one in found} == {
        pair: (len(costs), min(costs)) for pair, costs in counted.items()
    }


def test_nearest_steps_are_minima_of_dense_table(graph):
    library = graph.library
    table = all_pairs(*transition_windows(library, graph.window)).distance
    nodes = np.arange(library.node_count)
    table[~may_follow_between(library, nodes, nodes)] = np.inf
    table[library.node_measure < library.node_measures - 1] = np.inf
    table[:, library.node_measure > 0] = np.inf
    expected = [
        [table[np.ix_(library.node_step == a, library.node_step == b)].min() for b in range(len(library.steps))]
        for a in range(len(library.steps))
    ]
    assert nearest_steps(graph) == pytest.approx(np.array(expected), abs=1e-6)
    spring = library.steps.index("spring")
    assert np.isinf(nearest_steps(graph)[spring, spring])  # a repeat needs the other side


def test_successors_and_predecessors_are_distinguished(graph):
    whole, library = connectivity(graph), graph.library
    pruned = build_graph(library, threshold=0.1)
    assert np.array_equal(whole.alive, pruned.alive)
    arms_up = int(np.flatnonzero(library.node_step == library.steps.index("arms up"))[0])
    assert (whole.label == whole.label[arms_up]).sum() == 1
    for node in range(library.node_count):
        assert whole.has_successor[node] == (node in graph.joins.source)
        assert whole.has_predecessor[node] == (node in graph.joins.target)


def test_graph_without_edges_has_no_live_nodes():
    steps = [replace(made_clip("a"), end_pose="x", begin_pose="y")]
    assert not connectivity(build_graph(build_library(steps), prune=False)).alive.any()
