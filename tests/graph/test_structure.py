"""Tests of structure rules between steps: poses at both ends (T136), weight transfer (T135)."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.graph.structure_rules import initial_side, may_follow_between, plain_pose, unmatched_poses
from live.motion.mirror import mirror_step
from tests.fixtures.made_steps import made_clip


def connected_clips(graph, first, second):
    """Pairs of clip numbers in the library joined by an edge, from the end of one to the start of the other."""
    library = graph.library
    pairs = set()
    for node in range(library.node_count):
        for edge in range(graph.edge_start[node], graph.edge_start[node + 1]):
            target = graph.edge_target[edge]
            if library.node_measure[target] == 0:
                pairs.add((int(library.node_clip[node]), int(library.node_clip[target])))
    return {(u, v) for u, v in pairs if u in first and v in second}


def test_steps_connect_if_poses_match_or_are_missing():
    """Small version of Fig 5.9 of the thesis: échappé ends in plié, couru in either (T136, T137)."""
    clips = [
        replace(made_clip("échappé"), begin_pose="sous-sus", end_pose="plié"),
        replace(made_clip("couru"), begin_pose="plié", end_pose="sous-sus"),
        replace(made_clip("couru"), begin_pose="plié", end_pose="Plié "),
        made_clip("walk"),
    ]
    graph = build_graph(build_library(clips), threshold=0.2)
    everything = range(4)
    assert connected_clips(graph, everything, everything) == {
        (0, 1), (0, 2), (1, 0), (2, 1), (2, 2), (0, 3), (1, 3), (2, 3), (3, 0), (3, 1), (3, 2), (3, 3),
    }  # fmt: skip


def test_weight_transfer_step_repeats_on_other_side():
    left = replace(made_clip("spring point"), leading_foot="left", weight_transfer=True)
    graph = build_graph(build_library([left, mirror_step(left), made_clip("sway")]), threshold=0.2)
    assert connected_clips(graph, (0, 1), (0, 1)) == {(0, 1), (1, 0)}
    assert connected_clips(graph, (0, 1, 2), (2,)) == {(0, 2), (1, 2), (2, 2)}


def test_mirrored_step_is_other_side_without_leading_foot():
    step = replace(made_clip("spring point"), weight_transfer=True)
    other = replace(made_clip("spring point"), weight_transfer=True)
    graph = build_graph(build_library([step, other, mirror_step(step), made_clip("sway")]), threshold=0.2)
    assert connected_clips(graph, (0, 1, 2), (0, 1, 2)) == {(0, 2), (1, 2), (2, 0), (2, 1)}


def test_rules_do_not_apply_inside_step():
    long = replace(made_clip("phrase", measures=3), begin_pose="a", end_pose="b", weight_transfer=True)
    back = replace(made_clip("back"), begin_pose="b", end_pose="a")
    graph = build_graph(build_library([long, back]), threshold=0.2)
    assert graph.edge_target.tolist() == [1, 2, 3, 0]


def test_unmatched_pose_is_reported_with_step():
    lost = replace(made_clip("lost"), begin_pose="plié", end_pose="the air")
    closed = replace(made_clip("sway"), begin_pose="plié", end_pose="plié")
    library = build_library([lost, closed])
    assert unmatched_poses(library) == {"lost": "ends in 'the air', in which no step begins"}
    assert build_graph(library, threshold=0.2).missing == ("lost: ends in 'the air', in which no step begins",)
    begins = build_library([replace(lost, begin_pose="x", end_pose="plié"), closed])
    assert unmatched_poses(begins) == {"lost": "begins in 'x', in which no step ends"}
    assert unmatched_poses(build_library([lost, closed, made_clip("walk")])) == {}
    with pytest.raises(ValueError, match="lost ends in 'the air', in which no step begins"):
        build_graph(build_library([lost]), threshold=0.2)


@pytest.mark.long
@given(st.integers(0, 2**32 - 1))
def test_allowed_pairs_equal_direct_rules(seed):
    chance = np.random.default_rng(seed)
    poses = ("", "a", "b", "A ")
    clips = [
        replace(
            made_clip(str(chance.choice(["one", "two"]))),
            begin_pose=str(chance.choice(poses)),
            end_pose=str(chance.choice(poses)),
            weight_transfer=bool(chance.integers(2)),
            leading_foot=str(chance.choice(["", "left", "right"])),
            mirrored=bool(chance.integers(2)),
        )
        for _ in range(6)
    ]
    nodes = np.arange(len(clips))
    table = may_follow_between(build_library(clips), nodes, nodes)
    for u, first in enumerate(clips):
        for v, second in enumerate(clips):
            end, begin = plain_pose(first.end_pose), plain_pose(second.begin_pose)
            fits = not end or not begin or end == begin
            repeat = first.step == second.step and first.weight_transfer and second.weight_transfer
            assert table[u, v] == (fits and not (repeat and initial_side(first) == initial_side(second)))
