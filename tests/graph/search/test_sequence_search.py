"""Tests of the sequence searches: the golden example of the thesis, all dances of small graphs, and each other."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.graph.search.depth_first_reference import SearchTooLong, depth_first
from live.graph.search.viterbi import CostToGo, cheapest_path
from tests.graph.made_graphs import MadeGraph, enumerate_dances, made_edges, made_graph, made_specification

ECHAPPE, COURU = 0, 1
V3, V1, V2 = 0, 1, 2


@pytest.fixture
def ballet() -> MadeGraph:
    """Fig 3.12: v1, v2 are Échappé, v3 is Couru; v1 → v2, v1 → v3, v2 → v1. The figure tries v3 first."""
    return MadeGraph(made_edges([[], [V3, V2], [V1]]), [COURU, ECHAPPE, ECHAPPE], [0, 0, 0], [1, 1, 1])


def test_depth_first_search_matches_thesis_example(ballet: MadeGraph) -> None:
    """T066: v3 is left at once, v1 → v3 at depth 2, v1 → v2 → v1 at depth 3; then v2, v1, v3 has cost 0."""
    wanted = made_specification(ballet, [ECHAPPE, ECHAPPE, COURU])
    rejected: list[tuple[int, ...]] = []
    found = depth_first(ballet.edges, wanted, rejected=rejected)
    assert found is not None
    assert found.tolist() == [V2, V1, V3]
    assert rejected == [(V3,), (V1, V3), (V1, V2, V1)]


def test_layered_search_finds_path_of_thesis(ballet: MadeGraph) -> None:
    wanted = made_specification(ballet, [ECHAPPE, ECHAPPE, COURU])
    for wrong in (False, True):
        costs = CostToGo(ballet.edges, wanted, wrong=wrong)
        found = cheapest_path(costs, None)
        assert found is not None
        assert found.tolist() == [V2, V1, V3]
        assert costs.wrong_measures(float(costs.layer(0)[V2])) == 0


def assert_valid_dance(graph: MadeGraph, nodes: np.ndarray, start: int | None) -> None:
    """Each node follows the one before, and steps begin at their first measure and are finished."""
    path = nodes.tolist() if start is None else [start, *nodes.tolist()]
    assert all(v in graph.follows(u) for u, v in pairwise(path))
    assert start is not None or graph.measure[path[0]] == 0
    assert graph.measure[path[-1]] == graph.length[path[-1]] - 1


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), density=st.floats(0.05, 0.8), count=st.integers(1, 4), given_start=st.booleans())
def test_layered_search_equals_exhaustive_search(seed: int, density: float, count: int, given_start: bool) -> None:
    """Fewest wrong measures, then least edge costs, of all dances; both searches agree on cost 0."""
    chance = np.random.default_rng(seed)
    graph = made_graph(chance, density=density, lengths=(1, 1, 2))
    names = [None if chance.random() < 0.2 else int(chance.integers(3)) for _ in range(count)]
    spec = made_specification(graph, names)
    start = int(chance.integers(len(graph.step))) if given_start else None
    dances = [
        (sum(not spec.at(n)[node] for n, node in enumerate(path)), cost, path)
        for path, cost in enumerate_dances(graph, spec.measures, start=start)
    ]
    least = min(((wrong, cost) for wrong, cost, _ in dances), default=None)

    found = cheapest_path(CostToGo(graph.edges, spec, wrong=True), start)
    exact = cheapest_path(CostToGo(graph.edges, spec, wrong=False), start)
    first = depth_first(graph.edges, spec, start=start)
    if least is None:
        assert found is None
        assert exact is None
        assert first is None
        return
    assert found is not None
    assert_valid_dance(graph, found, start)
    costs = {path: (wrong, cost) for wrong, cost, path in dances}
    assert costs[tuple(found.tolist())] == pytest.approx(least)
    assert (exact is not None) == (first is not None) == (least[0] == 0)
    if exact is not None and first is not None:
        assert exact.tolist() == found.tolist()
        assert costs[tuple(first.tolist())][0] == 0


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(5, 12), density=st.floats(0.1, 0.6))
def test_both_searches_agree_on_feasibility(seed: int, count: int, density: float) -> None:
    """T064 against the layered search on longer sequences: a path of cost 0 from both, or from neither."""
    chance = np.random.default_rng(seed)
    graph = made_graph(chance, steps=4, density=density)
    spec = made_specification(graph, [int(chance.integers(4)) for _ in range(count)])
    exact = cheapest_path(CostToGo(graph.edges, spec, wrong=False), None)
    first = depth_first(graph.edges, spec, budget=200_000)
    assert (exact is None) == (first is None)
    for found in (exact, first):
        if found is not None:
            assert_valid_dance(graph, found, None)
            assert spec.fits[spec.set_index, found].all()


@given(seed=st.integers(0, 2**32 - 1), block=st.integers(2, 9), wrong=st.booleans())
def test_recomputed_layers_are_identical(seed: int, block: int, wrong: bool) -> None:
    chance = np.random.default_rng(seed)
    graph = made_graph(chance, density=0.5)
    spec = made_specification(graph, [None if chance.random() < 0.3 else int(chance.integers(3)) for _ in range(14)])
    whole = CostToGo(graph.edges, spec, wrong=wrong)
    parts = CostToGo(graph.edges, spec, wrong=wrong, block=block)
    for measure in range(spec.measures):
        assert np.array_equal(whole.layer(measure), parts.layer(measure))


def test_late_dead_end_is_exponential_only_for_depth_first() -> None:
    """Twenty measures of a step with three fully connected clips, then one that is unreachable."""
    rows = [[0, 1, 2], [0, 1, 2], [0, 1, 2], []]
    graph = MadeGraph(made_edges(rows), [0, 0, 0, 1], [0] * 4, [1] * 4)
    spec = made_specification(graph, [0] * 20 + [1])
    with pytest.raises(SearchTooLong, match=r"gave up after 5000 nodes, 20 of 21 measures deep.*layered"):
        depth_first(graph.edges, spec, budget=5000)
    assert cheapest_path(CostToGo(graph.edges, spec, wrong=False), None) is None
    nearest = cheapest_path(CostToGo(graph.edges, spec, wrong=True), None)
    assert nearest is not None
    assert (nearest == 3).sum() == 0


def test_impossible_length_has_no_dance() -> None:
    graph = MadeGraph(made_edges([[1], []]), [0, 0], [0, 1], [2, 2])
    for count in (1, 3):
        spec = made_specification(graph, [None] * count)
        assert cheapest_path(CostToGo(graph.edges, spec, wrong=True), None) is None
        assert depth_first(graph.edges, spec) is None
