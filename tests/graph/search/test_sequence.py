"""Tests of sequences in a motion graph: whole steps on the measures, the smoothest valid path, live changes."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.graph.motion_graph import build_graph
from live.graph.search.live_sequence import LiveSequence
from live.graph.search.sequence import NoPath, best_start, find_sequence, parse_sequence
from live.graph.search.sequence_spec import SequenceEntry, specify
from live.graph.step_library import build_library
from tests.fixtures.made_steps import made_clip, made_steps


@pytest.fixture(scope="module")
def graph():
    clips = [*made_steps(), made_clip("long phrase", measures=4, arm=1.05), made_clip("bow", arm=-0.8)]
    return build_graph(build_library(clips), threshold=0.12, prune=False)


def describe_path(graph, nodes):
    """Names and measures of nodes, after a check that they follow each other."""
    for u, v in pairwise(nodes.tolist()):
        assert v in graph.edge_target[graph.edge_start[u] : graph.edge_start[u + 1]]
    return [graph.library.describe(int(node)) for node in nodes]


def search_sequence(graph, text, **options):
    return find_sequence(graph, specify(graph.library, parse_sequence(text, graph.library)), **options)


@pytest.mark.parametrize("method", ["layered", "depth first"])
def test_steps_of_different_lengths_form_one_dance(graph, method):
    path = search_sequence(graph, "sway, phrase, long phrase, spin, phrase", method=method)
    assert describe_path(graph, path.node) == [
        "sway", "phrase 1/2", "phrase 2/2", "long phrase 1/4", "long phrase 2/4", "long phrase 3/4", "long phrase 4/4",
        "spin", "phrase 1/2", "phrase 2/2",
    ]  # fmt: skip
    assert path.cost == 0
    assert path.edge_cost[[0, 2, 4, 5, 6, 9]].tolist() == [0.0] * 6  # the first node, and inside steps
    assert (path.edge_cost[[1, 3, 7, 8]] > 0.0).all()


def test_smoothest_valid_dance_is_found(graph):
    path = search_sequence(graph, "sway,*,spin")
    library = graph.library
    ends = np.flatnonzero(library.node_step == library.steps.index("sway"))
    spins = np.flatnonzero(library.node_step == library.steps.index("spin"))
    cost = {}
    for u in ends:
        for e in range(graph.edge_start[u], graph.edge_start[u + 1]):
            v = graph.edge_target[e]
            for f in range(graph.edge_start[v], graph.edge_start[v + 1]):
                if graph.edge_target[f] in spins:
                    cost[u, v, graph.edge_target[f]] = graph.edge_cost[e] + graph.edge_cost[f]
    assert path.edge_cost.sum() == pytest.approx(min(cost.values()))
    assert cost[tuple(path.node)] == pytest.approx(min(cost.values()))
    thesis = search_sequence(graph, "sway,*,spin", method="depth first")
    assert thesis.cost == 0
    assert thesis.edge_cost.sum() >= path.edge_cost.sum()


def test_infeasible_sequence_gives_nearest_dance(graph):
    """No arms come down to a bow: one measure is wrong with either method."""
    for method in ("layered", "depth first"):
        path = search_sequence(graph, "phrase, bow, sway", method=method)
        assert path.cost == 1
        assert path.wrong.tolist() == [False, False, True, False]
        assert "bow" not in describe_path(graph, path.node)


def test_search_starts_after_given_node(graph):
    library = graph.library
    long_phrase = int(np.flatnonzero(library.node_step == library.steps.index("long phrase"))[0])
    assert search_sequence(graph, "sway", start=long_phrase + 3).cost == 0
    with pytest.raises(NoPath):  # the current step does not end within one measure
        search_sequence(graph, "sway", start=long_phrase)
    nodes = np.flatnonzero(library.node_step == library.steps.index("glide"))
    best = best_start(graph, specify(library, parse_sequence("spin", library)), nodes)
    costs = {int(node): search_sequence(graph, "spin", start=int(node)).edge_cost.sum() for node in nodes}
    assert costs[best] == min(costs.values())


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_greedy_live_choices_are_as_good_as_full_search(graph, seed):
    """The best next node per measure for several dancers is as good as a full search for each of them."""
    chance = np.random.default_rng(seed)
    library = graph.library
    leaves = np.flatnonzero((library.node_measure == library.node_measures - 1) & (np.diff(graph.edge_start) > 0))
    names = chance.choice(["sway", "glide", "spin", "phrase", "*"], 4)
    wanted = parse_sequence(",".join(names), library)
    total = sum(entry.measures for entry in wanted)
    live = LiveSequence(graph, wanted[:2])
    live.extend(wanted[2:])
    nodes = chance.choice(leaves, 3)
    first, paths = nodes.copy(), []
    for _ in range(total):
        ahead = live.costs_ahead()
        nodes = np.array(
            [
                min(graph.edge_target[graph.edge_start[n] : graph.edge_start[n + 1]], key=lambda v: ahead[v])
                for n in nodes
            ]
        )
        paths.append(nodes)
        live.advance()
    assert live.remaining == ()
    spec = specify(library, wanted)
    for dancer, start in enumerate(first):
        path = np.array([nodes[dancer] for nodes in paths], np.int32)
        describe_path(graph, np.concatenate([[start], path]).astype(np.int32))
        wrong = np.count_nonzero(~spec.fits[spec.set_index, path])
        if library.node_measure[path[-1]] == library.node_measures[path[-1]] - 1:
            assert wrong <= find_sequence(graph, spec, start=int(start)).cost


def test_live_sequence_changes_after_current_step(graph):
    library = graph.library
    phrase, sway, spin = (library.steps.index(name) for name in ("phrase", "sway", "spin"))
    live = LiveSequence(graph, [SequenceEntry(phrase, 2), SequenceEntry(spin)])
    live.advance()
    live.replace([SequenceEntry(sway)])
    assert live.remaining == (SequenceEntry(phrase, 2), SequenceEntry(sway))  # a step in progress is finished
    ahead = live.costs_ahead()
    first, second = np.flatnonzero(library.node_step == phrase)
    assert ahead[second] < 1.0 <= ahead[first]
    live.advance()
    assert live.remaining == (SequenceEntry(sway),)
    live.advance()
    live.advance()
    assert live.remaining == ()
    assert live.costs_ahead()[np.flatnonzero(library.node_step == sway)].max() < 1.0


def test_feasible_delay_of_request_is_found(graph):
    library = graph.library
    live = LiveSequence(graph, [])
    at = {
        name: np.flatnonzero(library.node_step == library.steps.index(name)).astype(np.int32) for name in library.steps
    }
    spin_bow = parse_sequence("spin, bow", library)
    assert live.feasible_delay(parse_sequence("spin", library), at["sway"]) == 0
    assert live.feasible_delay(parse_sequence("spin", library), at["phrase"][:1]) == 0  # after the phrase
    assert live.feasible_delay(spin_bow, at["sway"]) is None
    far = build_graph(
        build_library([made_clip("high", arm=1.2), made_clip("middle", arm=1.1), made_clip("low", arm=1.0)]),
        threshold=0.015, prune=False,
    )  # fmt: skip
    live = LiveSequence(far, [])
    high, low = np.array([0], np.int32), parse_sequence("low", far.library)
    assert live.feasible_delay(low, high) == 1  # through the middle step
    assert live.feasible_delay(low, high, max_delay=0) is None
    assert live.feasible_delay(low, np.array([0, 1], np.int32)) == 1
