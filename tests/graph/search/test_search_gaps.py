"""Tests of gaps: the fewest joins are found, and they make the sequence feasible."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.graph.search.sequence_diagnostics import find_gaps
from live.graph.search.viterbi import CostToGo, Edges, cheapest_path
from tests.graph.made_graphs import MadeGraph, made_edges, made_graph, made_specification


def add_joins(edges: Edges, joins: set[tuple[int, int]]) -> Edges:
    rows = [
        sorted({*edges.target[edges.start[u] : edges.start[u + 1]].tolist(), *(v for s, v in joins if s == u)})
        for u in range(len(edges.start) - 1)
    ]
    return made_edges(rows)


def fewest_joins(graph: MadeGraph, names: list[int | None], start: int | None) -> float:
    """By relaxation over measures and nodes: an edge costs nothing, any other join of an end to a beginning 1."""
    spec = made_specification(graph, names)
    nodes = range(len(graph.step))
    at = [[n for n in nodes if spec.at(m)[n]] for m in range(spec.measures)]
    ends = {n for n in nodes if graph.measure[n] == graph.length[n] - 1}
    if start is None:
        cost = {n: 0.0 for n in at[0] if graph.measure[n] == 0}
    else:
        cost = {start: 0.0}
    for measure in range(0 if start is not None else 1, spec.measures):
        after: dict[int, float] = {}
        for u, value in cost.items():
            follows = graph.follows(u)
            for v in at[measure]:
                join = 0.0 if v in follows else 1.0 if u in ends and graph.measure[v] == 0 else np.inf
                after[v] = min(after.get(v, np.inf), value + join)
        cost = after
    return min((value for n, value in cost.items() if n in ends), default=np.inf)


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), density=st.floats(0.0, 0.5), count=st.integers(1, 8), given_start=st.booleans())
def test_gaps_are_fewest_joins_and_suffice(seed: int, density: float, count: int, given_start: bool) -> None:
    chance = np.random.default_rng(seed)
    graph = made_graph(chance, steps=3, density=density)
    names = [int(chance.integers(3)) if chance.random() < 0.8 or 1 not in graph.length else None for _ in range(count)]
    spec = made_specification(graph, names)
    ends = [n for n in range(len(graph.step)) if graph.measure[n] == graph.length[n] - 1]
    start = int(chance.choice(ends)) if given_start else None

    def choose(last: np.ndarray, first: np.ndarray) -> tuple[int, int]:
        return int(chance.choice(np.flatnonzero(last))), int(chance.choice(np.flatnonzero(first)))

    gaps = find_gaps(graph.edges, spec, choose, start=start)
    assert (gaps == []) == (cheapest_path(CostToGo(graph.edges, spec, wrong=False), start) is not None)
    joins = {gap.pair for gap in gaps if gap.pair is not None}
    if all(gap.pair is not None for gap in gaps):
        assert len(gaps) == fewest_joins(graph, names, start)
        assert cheapest_path(CostToGo(add_joins(graph.edges, joins), spec, wrong=False), start) is not None
    else:  # free measures that no whole steps fill
        assert fewest_joins(graph, names, start) == np.inf


def test_step_without_clip_is_reported_once() -> None:
    graph = MadeGraph(made_edges([[1], [2], []]), [0, 1, 0], [0, 0, 0], [1, 1, 1])
    spec = made_specification(graph, [0, 1, 0, 1])
    spec.fits[1] = False
    gaps = find_gaps(graph.edges, spec, lambda last, first: (int(np.argmax(last)), int(np.argmax(first))))
    assert [(gap.measure, gap.pair, gap.has_clip) for gap in gaps] == [(1, None, False)]
    spec.fits[3] = False
    spec.fits[0] = False
    gaps = find_gaps(graph.edges, spec, lambda last, first: (0, 0))
    assert [gap.measure for gap in gaps] == [0, 1, 3]


def test_free_measures_without_fitting_step_are_gaps() -> None:
    graph = MadeGraph(made_edges([[1], [0]]), [0, 0], [0, 1], [2, 2])
    for names, measures in (([None], [0]), ([None, 0], [1]), ([0, None], [2])):
        gaps = find_gaps(graph.edges, made_specification(graph, names), lambda last, first: (1, 0))
        assert [(gap.measure, gap.pair) for gap in gaps] == [(m, None) for m in measures]
