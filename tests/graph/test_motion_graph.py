"""Tests of the motion graph: edges, pruning, hops."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.graph.build.components import largest_component
from live.graph.build.metric import Metric
from live.graph.build.transitions import all_pairs, transition_windows
from live.graph.motion_graph import UNREACHABLE, build_graph
from live.graph.step_library import build_library
from live.graph.structure_rules import may_follow_between
from tests.fixtures.made_steps import made_clip, made_steps


@pytest.fixture(scope="module")
def graph():
    return build_graph(build_library(made_steps()), threshold=0.2)


def test_two_measure_step_is_danced_whole(graph):
    library = graph.library
    phrase = library.steps.index("phrase")
    first, second = np.flatnonzero(library.node_step == phrase)
    targets = graph.edge_target[graph.edge_start[first] : graph.edge_start[first + 1]]
    assert targets.tolist() == [second]
    assert graph.edge_transform[graph.edge_start[first]].tolist() == [0, 0, 0]
    assert not np.isin(second, np.delete(graph.edge_target, graph.edge_start[first]))


def allowed_edges(library, transitions, threshold):
    """Which ordered pairs of nodes may follow each other, before dead ends are pruned, shape (N, N)."""
    nodes = np.arange(library.node_count)
    leaves, enters = library.node_measure == library.node_measures - 1, library.node_measure == 0
    allowed = (transitions.distance <= threshold) & leaves[:, None] & enters & may_follow_between(library, nodes, nodes)
    inside = np.flatnonzero(~leaves)
    allowed[inside, inside + 1] = True  # the measures of one clip are neighbours in the library
    return allowed


@pytest.mark.parametrize("threshold", [0.02, 0.1, 0.3])
def test_edges_equal_edges_of_dense_table(threshold):
    """Against all pairs at once, the structure of each, and pruning of unreachable nodes and dead ends."""
    library = build_library([*made_steps(), made_clip("arms up", arm=-1.2)])
    graph = build_graph(library, threshold=threshold)
    table = all_pairs(*transition_windows(library, graph.window))
    allowed = allowed_edges(library, table, threshold)
    assert np.argwhere(allowed).tolist() == np.column_stack([graph.joins.source, graph.joins.target]).tolist()
    allowed &= graph.alive[:, None] & graph.alive[None]
    source, target = np.nonzero(allowed)
    assert graph.edge_target.tolist() == target.tolist()
    assert graph.edge_start.tolist() == np.searchsorted(source, np.arange(library.node_count + 1)).tolist()
    between = library.node_measure[target] == 0
    assert graph.edge_cost[between] == pytest.approx(table.distance[source, target][between], abs=1e-7)
    assert graph.edge_transform[between][:, :2] == pytest.approx(table.shift[source, target][between], abs=1e-7)


def test_joint_weights_decide_which_steps_connect():
    """Different arms keep two steps apart only while the arms have weight."""
    library = build_library([made_clip("sway"), made_clip("reach", arm=0.4)])
    arms = {side + part: 0.0 for side in ("left", "right") for part in ("UpperArm", "LowerArm", "Hand")}
    assert build_graph(library, threshold=0.05).edge_count == 1
    assert build_graph(library, threshold=0.05, metric=Metric.of(arms)).edge_count == 4


def test_dead_end_steps_are_pruned_and_reported():
    arms_up = made_clip("arms up", arm=-1.2)
    graph = build_graph(build_library([*made_steps(), arms_up]), threshold=0.1)
    index = graph.library.steps.index("arms up")
    assert not graph.alive[graph.library.node_step == index].any()
    assert len(graph.missing) == 1
    assert "arms up" in graph.missing[0]
    assert not np.isin(np.flatnonzero(graph.library.node_step == index), graph.edge_target).any()


def test_unconnected_library_is_refused():
    once = made_clip("once", measures=2)
    root = once.clip.root_position.copy()
    root[:, 1] += np.linspace(0.0, 1.0, len(root), dtype=np.float32)  # the dancer rises and does not come down
    rising = replace(once, clip=replace(once.clip, root_position=root))
    with pytest.raises(ValueError, match="once"):
        build_graph(build_library([rising]), threshold=0.1)


def test_mixed_meters_and_empty_library_are_refused():
    with pytest.raises(ValueError, match="no steps"):
        build_library([])
    with pytest.raises(ValueError, match="'waltz' has 3"):
        build_library([made_clip("sway"), made_clip("waltz", beats=3)])


@given(st.integers(1, 12), st.integers(0, 2**32 - 1), st.floats(0.05, 0.5))
def test_largest_component_is_strongly_connected(count, seed, density):
    """Against reachability by repeated squaring of the adjacency matrix."""
    allowed = np.random.default_rng(seed).random((count, count)) < density
    reach = np.eye(count, dtype=bool) | allowed
    for _ in range(count):
        reach = (reach.astype(int) @ reach.astype(int)) > 0
    together = reach & reach.T
    alive = largest_component(count, *np.nonzero(allowed))
    assert alive.sum() == together.sum(axis=1).max()
    assert together[np.ix_(alive, alive)].all()


def test_node_with_self_loop_is_kept_and_isolated_node_pruned():
    allowed = np.zeros((3, 3), np.bool_)
    allowed[2, 2] = True
    assert largest_component(3, *np.nonzero(allowed)).tolist() == [False, False, True]


def test_hops_count_measures_to_step(graph):
    """Against a search along the edges, node by node."""
    library = graph.library
    for step in range(len(library.steps)):
        for node in range(library.node_count):
            seen, front, distance = {node}, {node}, 0
            while front and not any(library.node_step[n] == step and library.node_measure[n] == 0 for n in front):
                front = {
                    int(t) for n in front for t in graph.edge_target[graph.edge_start[n] : graph.edge_start[n + 1]]
                } - seen
                seen |= front
                distance += 1
            assert graph.hops[step, node] == (distance if front else UNREACHABLE)


def test_node_facing_equals_body_heading(graph):
    library = graph.library
    spin = np.flatnonzero(library.node_step == library.steps.index("spin"))[0]
    still = np.flatnonzero(library.node_step != library.steps.index("spin"))
    assert np.abs(graph.node_facing[still]).max() < 1e-3
    # the heading is averaged over the window before the line: half a window's turn behind it
    behind = -2 * math.pi * graph.window / 2
    assert graph.node_facing_start[spin] == pytest.approx(behind, abs=0.02)
