"""Takes: which clips may be mixed into which (T044-T047)."""

import numpy as np

from live.graph.library import build_library
from live.graph.takes import NO_TAKE, find_takes
from live.motion.editing.same_step import check_same_structure
from tests.made_steps import made_steps


def test_takes_are_the_same_measure_of_the_same_step_in_another_clip():
    library = build_library(made_steps())
    takes = find_takes(library)
    assert len(takes.node) > 0
    for u in range(library.node_count):
        for v in takes.node[takes.start[u] : takes.start[u + 1]]:
            assert library.node_step[u] == library.node_step[v]
            assert library.node_measure[u] == library.node_measure[v]
            assert library.node_clip[u] != library.node_clip[v]
            check_same_structure(library.clips[library.node_clip[u]], library.clips[library.node_clip[v]])


def test_draws_are_takes_and_reach_them_all():
    takes = find_takes(build_library(made_steps()))
    nodes = np.repeat(np.arange(len(takes.start) - 1, dtype=np.int32), 64)
    chance = np.tile(np.linspace(0, 0.999999, 64), len(takes.start) - 1)
    drawn = takes.draw(nodes, chance).reshape(-1, 64)
    for u, row in enumerate(drawn):
        wanted = set(takes.node[takes.start[u] : takes.start[u + 1]].tolist())
        assert set(row.tolist()) == (wanted or {NO_TAKE})


def test_one_clip_has_no_other_take():
    library = build_library(made_steps()[:1])
    takes = find_takes(library)
    node = np.zeros(3, np.int32)
    assert takes.draw(node, np.array([0.0, 0.5, 0.99])).tolist() == [NO_TAKE] * 3
