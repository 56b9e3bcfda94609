"""Tests of random walks: every measure follows an edge, and the same seed gives the same dance."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.graph.motion_graph import build_graph
from live.graph.random_walk import random_walk
from live.graph.step_library import build_library
from tests.fixtures.made_steps import made_clip, made_steps


@pytest.fixture(scope="module")
def graph():
    return build_graph(build_library([*made_steps(), made_clip("arms up", arm=-1.2)]), threshold=0.1)


@given(seed=st.integers(0, 2**32 - 1), measures=st.integers(1, 60))
def test_walk_follows_edges_and_keeps_measures_in_order(graph, seed, measures):
    walk = random_walk(graph, measures, seed=seed)
    library = graph.library
    assert len(walk) == measures
    assert graph.alive[walk].all()
    assert library.node_measure[walk[0]] == 0
    for u, v in itertools.pairwise(walk):
        assert v in graph.edge_target[graph.edge_start[u] : graph.edge_start[u + 1]]
        assert library.node_measure[v] == (library.node_measure[u] + 1) % library.node_measures[u]
    assert np.array_equal(walk, random_walk(graph, measures, seed=seed))


def test_long_walk_visits_every_live_node(graph):
    assert set(random_walk(graph, 2000, seed=1).tolist()) == set(np.flatnonzero(graph.alive).tolist())


def test_impossible_walk_is_refused(graph):
    with pytest.raises(ValueError, match="0 measures: at least 1"):
        random_walk(graph, 0, seed=1)
    dead = int(np.flatnonzero(~graph.alive)[0])
    for start in (dead, -1, graph.library.node_count):
        with pytest.raises(ValueError, match=f"cannot begin at node {start}"):
            random_walk(graph, 4, seed=1, start=start)
    unpruned = build_graph(graph.library, threshold=1e-6, prune=False)
    nodes = np.arange(graph.library.node_count)
    stuck = int(nodes[np.diff(unpruned.edge_start) == 0][0]) if (np.diff(unpruned.edge_start) == 0).any() else None
    if stuck is not None:
        with pytest.raises(ValueError, match="the walk ends after measure 1: nothing follows"):
            random_walk(unpruned, 4, seed=1, start=stuck)
