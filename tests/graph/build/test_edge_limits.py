"""Tests of sparse graphs: what is connected stays connected, and takes come and go as if they had always been there."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.graph.build.components import strong_components
from live.graph.build.nearest_pairs import ALL_EDGES, EdgeLimits
from live.graph.library_insert import insert_clips, without_clips
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from tests.fixtures.made_steps import made_clip
from tests.graph.test_insertion import assert_same

SPARSE = EdgeLimits(per_node=2, per_variation=1, into=0)


@st.composite
def many_clips(draw):
    """Clips whose arms wander, so that some lead to others only by way of a third."""
    names = draw(st.lists(st.sampled_from(["sway", "glide", "phrase"]), min_size=4, max_size=24))
    chance = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    clips = []
    for name in names:
        measures = 2 if name == "phrase" else 1
        way = (0.0, float(chance.integers(-1, 2)) * 0.4)
        direction = ("short back", "in place", "short forward")[int(np.sign(way[1])) + 1]
        clips.append(
            made_clip(name, way=way, measures=measures, arm=float(chance.uniform(-1.2, 1.2)), direction=direction)
        )
    return clips


def edges_of(graph):
    return set(zip(graph.joins.source.tolist(), graph.joins.target.tolist(), strict=True))


def _steps_that_follow(graph):
    """Pairs of a node and a step that can come next."""
    library = graph.library
    return {(s, int(library.node_step[t])) for s, t in edges_of(graph) if library.node_measure[t] == 0}


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(many_clips(), st.sampled_from([0.03, 0.06, 0.15]))
def test_components_are_those_of_all_edges(clips, threshold):
    library = build_library(clips)
    whole = build_graph(library, threshold=threshold, prune=False, limits=ALL_EDGES)
    sparse = build_graph(library, threshold=threshold, prune=False, limits=SPARSE)
    assert edges_of(sparse) <= edges_of(whole)
    assert _steps_that_follow(sparse) == _steps_that_follow(whole) or len(library.steps) > SPARSE.per_node
    labels = [strong_components(library.node_count, g.joins.source, g.joins.target) for g in (whole, sparse)]
    assert len(set(zip(*map(np.ndarray.tolist, labels), strict=True))) == len(set(labels[0].tolist()))


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(many_clips(), st.sampled_from([0.05, 0.15]), st.integers(1, 3))
def test_insertion_into_a_sparse_graph_equals_full_build(clips, threshold, new):
    limits = EdgeLimits(per_node=3, per_variation=1, into=1)
    graph = build_graph(build_library(clips[:-new]), threshold=threshold, prune=False, limits=limits)
    assert_same(
        insert_clips(graph, clips[-new:]),
        build_graph(build_library(clips), threshold=threshold, prune=False, limits=limits),
    )


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(many_clips(), st.sampled_from([0.05, 0.15]), st.integers(1, 3))
def test_removal_from_a_sparse_graph_restores_what_was_left_out(clips, threshold, gone):
    """The edges among the others are those of a graph that never had the removed clips."""
    limits = EdgeLimits(per_node=3, per_variation=1, into=0)
    graph = build_graph(build_library(clips), threshold=threshold, prune=False, limits=limits)
    left = without_clips(graph, range(len(clips) - gone, len(clips)))
    expected = build_graph(build_library(clips[:-gone]), threshold=threshold, prune=False, limits=limits)
    count = expected.library.node_count
    among = {(a, b) for a, b in edges_of(left) if a < count and b < count}
    links = among ^ edges_of(expected)  # a dancer who leaves needs a way on, so links to the others may differ
    label = strong_components(count, expected.joins.source, expected.joins.target)
    assert all(label[a] != label[b] for a, b in links)


@pytest.mark.long
def test_limits_bound_a_library_of_alike_measures():
    """Three hundred measures that can all follow each other keep some edges each, in every direction."""
    chance = np.random.default_rng(1)
    ways = {"in place": (0.0, 0.0), "long forward": (0.0, 0.8), "long left": (0.8, 0.0), "long back": (0.0, -0.8)}
    clips = [
        made_clip("groove", way=way, direction=name, arm=1.1 + 0.01 * chance.normal())
        for _ in range(75)
        for name, way in ways.items()
    ]
    limits = EdgeLimits()
    graph = build_graph(build_library(clips), threshold=0.3)
    assert graph.alive.all()
    assert graph.edge_count <= len(clips) * (len(ways) * limits.per_variation + limits.into)
    for node in range(0, 300, 17):
        targets = graph.edge_target[graph.edge_start[node] : graph.edge_start[node + 1]]
        assert {clips[graph.library.node_clip[t]].direction for t in targets} == set(ways)
    assert np.bincount(graph.edge_target, minlength=300).min() >= limits.into


@pytest.mark.parametrize("count", [1, 2])
def test_smallest_libraries_have_a_graph(count):
    graph = build_graph(build_library([made_clip("sway")] * count))
    assert graph.edge_count == count * count
