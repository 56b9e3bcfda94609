"""Tests of inserting a take into a graph in use: the same result as building the whole graph."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.graph.build.metric import FlatClouds
from live.graph.build.transitions import Boundaries, Joins
from live.graph.library_insert import insert_clips, stranded
from live.graph.motion_graph import MotionGraph, build_graph
from live.graph.node_features import Moments
from live.graph.step_library import StepLibrary, build_library
from live.graph.takes import Takes
from live.motion.pose.pose_pipeline import ClipStore
from tests.fixtures.made_steps import made_clip, made_steps


def assert_same(one, other):
    """Compares every array of two graphs, libraries included."""
    assert type(one) is type(other)
    for field in fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, (StepLibrary, Joins, Takes, ClipStore, Boundaries, FlatClouds, Moments)):
            assert_same(a, b)
        elif isinstance(a, np.ndarray):
            assert a.dtype == b.dtype, field.name
            assert a.shape == b.shape, field.name
            # distances near 0 are roots of differences, with a float64 accuracy of 1e-7 m
            assert np.allclose(a, b, rtol=1e-6, atol=2e-6), field.name
        elif field.name == "clips":
            assert all(x is y for x, y in zip(a, b, strict=True))
        elif field.name != "rule":
            assert a == b, field.name


@st.composite
def made_libraries(draw):
    """Clips in any order, some of them dead ends, some of the same step, split in two lists."""
    kinds = st.builds(
        made_clip,
        st.sampled_from(["sway", "glide", "phrase", "new"]),
        way=st.sampled_from([(0.0, 0.0), (0.4, 0.0), (0.0, -0.3)]),
        measures=st.sampled_from([1, 1, 2]),
        arm=st.sampled_from([1.2, 1.1, -0.8]),
        turn=st.sampled_from([0.0, 0.5]),
    )
    return made_steps()[: draw(st.integers(1, 8))], draw(st.lists(kinds, min_size=1, max_size=4))


@pytest.mark.long
@settings(max_examples=20, deadline=None)
@given(made_libraries(), st.sampled_from([0.03, 0.1, 0.5]))
def test_insertion_equals_full_build(clips, threshold):
    before, new = clips
    graph = build_graph(build_library(before), threshold=threshold)
    assert_same(insert_clips(graph, new), build_graph(build_library([*before, *new]), threshold=threshold))


def test_insertion_leaves_old_graph_unchanged():
    graph = build_graph(build_library(made_steps()))
    kept = build_graph(build_library(made_steps()))
    new = insert_clips(graph, [made_clip("new"), made_clip("sway", arm=1.18)])
    for clip, other in zip(graph.library.clips, kept.library.clips, strict=True):
        assert np.array_equal(clip.clip.rotation, other.clip.rotation)
    assert graph.library.steps == kept.library.steps
    for name in ("clip_rotation", "node_first", "node_step"):
        assert np.array_equal(getattr(graph.library, name), getattr(kept.library, name))
        assert not np.shares_memory(getattr(graph.library, name), getattr(new.library, name))
    assert np.array_equal(graph.edge_target, kept.edge_target)
    old = graph.library.node_count
    assert [new.library.describe(n) for n in range(old)] == [graph.library.describe(n) for n in range(old)]


def test_inserted_take_revives_dead_end():
    """A dead end step becomes alive with a take that leads away from it."""
    alone = made_clip("lifted", arm=-1.2)
    graph = build_graph(build_library([*made_steps(), alone]), threshold=0.05)
    lifted = graph.library.node_step == graph.library.steps.index("lifted")
    assert not graph.alive[lifted].any()
    more = [made_clip("lifted", arm=-1.2 + 0.1 * n) for n in range(1, 25)]
    assert insert_clips(graph, more).alive[: graph.library.node_count][lifted].all()


def test_different_meter_is_refused():
    graph = build_graph(build_library(made_steps()))
    with pytest.raises(ValueError, match="'waltz' has 3 beats a measure, the library it should join has 4"):
        insert_clips(graph, [made_clip("waltz", beats=3)])
    with pytest.raises(ValueError, match="no steps"):
        insert_clips(graph, [])


def test_insertion_in_thread_gives_same_graph():
    graph = build_graph(build_library(made_steps()))
    clips = [made_clip("new", arm=1.0 + 0.01 * n) for n in range(4)]
    with ThreadPoolExecutor(2) as pool:
        results = list(pool.map(lambda clip: insert_clips(graph, [clip]), clips))
    for clip, result in zip(clips, results, strict=True):
        assert_same(result, insert_clips(graph, [clip]))


def test_dancers_on_dead_nodes_are_stranded():
    graph = build_graph(build_library([*made_steps(), made_clip("arms up", arm=-1.2)]), threshold=0.1)
    nodes = np.arange(graph.library.node_count, dtype=np.int32)
    assert isinstance(graph, MotionGraph)
    assert stranded(graph, nodes).tolist() == (~graph.alive).tolist()
