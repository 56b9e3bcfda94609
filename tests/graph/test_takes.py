"""Tests of takes: which clips may be mixed into which (T044-T047)."""

import contextlib
from dataclasses import replace

import numpy as np

from live.graph.step_library import build_library
from live.graph.takes import MAX_TAKES, NO_TAKE, find_takes
from live.motion.mirror import mirror_step
from live.motion.step_clip import check_same_structure
from tests.fixtures.made_steps import made_clip, made_steps


def test_takes_are_same_measure_of_step_in_other_clips():
    library = build_library(made_steps())
    takes = find_takes(library)
    assert len(takes.node) > 0
    for u in range(library.node_count):
        for v in takes.node[takes.start[u] : takes.start[u + 1]]:
            assert library.node_step[u] == library.node_step[v]
            assert library.node_measure[u] == library.node_measure[v]
            assert library.node_clip[u] != library.node_clip[v]
            check_same_structure(library.clips[library.node_clip[u]], library.clips[library.node_clip[v]])


def test_draws_cover_all_takes():
    takes = find_takes(build_library(made_steps()))
    nodes = np.repeat(np.arange(len(takes.start) - 1, dtype=np.int32), 64)
    chance = np.tile(np.linspace(0, 0.999999, 64), len(takes.start) - 1)
    drawn = takes.draw(nodes, chance).reshape(-1, 64)
    for u, row in enumerate(drawn):
        wanted = set(takes.node[takes.start[u] : takes.start[u + 1]].tolist())
        assert set(row.tolist()) == (wanted or {NO_TAKE})


def test_single_clip_has_no_other_take():
    library = build_library(made_steps()[:1])
    takes = find_takes(library)
    node = np.zeros(3, np.int32)
    assert takes.draw(node, np.array([0.0, 0.5, 0.99])).tolist() == [NO_TAKE] * 3


def test_takes_match_pairs_accepted_by_structure_check():
    """Against `check_same_structure` on every pair of a mixed library."""
    chance = np.random.default_rng(3)
    clips = [
        replace(
            made_clip(str(chance.choice(["a", "b"])), measures=int(chance.integers(1, 3))),
            leading_foot=str(chance.choice(["", "left", "right"])),
            mirrored=bool(chance.integers(2)),
            end_pose=str(chance.choice(["", "plié"])),
        )
        for _ in range(30)
    ]
    library = build_library(clips)
    takes = find_takes(library)
    for u in range(library.node_count):
        expected = []
        for v in range(library.node_count):
            a, b = library.node_clip[u], library.node_clip[v]
            if a != b and library.node_measure[u] == library.node_measure[v]:
                with contextlib.suppress(ValueError):
                    check_same_structure(clips[a], clips[b])
                    expected.append(v)
        assert takes.node[takes.start[u] : takes.start[u + 1]].tolist() == expected


def test_stream_measures_are_not_takes_of_each_other():
    library = build_library([replace(made_clip("stream"), in_stream=True) for _ in range(3)])
    assert find_takes(library).count(np.arange(3, dtype=np.int32)).tolist() == [0, 0, 0]


def test_takes_of_a_step_danced_often_are_some_evenly_over_all():
    """A hundred alike and forty mirrored: each has so many takes of its side, and each is a take of another."""
    clips = [made_clip("groove") for _ in range(100)] + [mirror_step(made_clip("groove")) for _ in range(40)]
    library = build_library(clips)
    takes = find_takes(library)
    assert takes.count(np.arange(140, dtype=np.int32)).tolist() == [MAX_TAKES] * 100 + [39] * 40
    for node in range(140):
        own = takes.node[takes.start[node] : takes.start[node + 1]].tolist()
        assert len(set(own)) == len(own)
        assert node not in own
        assert all((other < 100) == (node < 100) for other in own)
    assert set(takes.node.tolist()) == set(range(140))
