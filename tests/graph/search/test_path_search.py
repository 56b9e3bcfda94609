"""Tests of path following: squares and circles with the project's steps, wanted steps, and an exhaustive search."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.graph.motion_graph import build_graph
from live.graph.render_dance import edge_between, render_dance
from live.graph.search.path_following import WRONG_COST, Targets, follow_line, follow_path, smoothed
from live.graph.search.sequence_diagnostics import ANY, cost_to_go
from live.graph.select.candidates import find_candidates
from live.graph.step_library import build_library
from live.graph.takes import NO_TAKE
from tests.fixtures.made_steps import made_clip, made_steps
from tests.fixtures.steps_of_the_project import project_steps

SQUARE = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0), (-2.0, -2.0)]
ROUND = np.linspace(0.0, 2.0 * np.pi, 361)
CIRCLE = 2.0 * np.column_stack([np.sin(ROUND), np.cos(ROUND)])


@pytest.fixture(scope="module")
def graph():
    return build_graph(build_library(project_steps("walk", "samba")))


@pytest.fixture(scope="module")
def candidates(graph):
    return find_candidates(graph)


@pytest.fixture(scope="module")
def made():
    return build_graph(build_library(made_steps()), threshold=0.2)


@pytest.mark.long
@pytest.mark.parametrize(
    ("step", "line", "facing"),
    [
        ("walk", "square", "public"),
        ("walk", "circle", "path"),
        ("samba", "square", "path"),
        ("samba", "circle", "public"),
    ],
)
def test_followed_path_stays_within_15_cm_for_32_measures(graph, candidates, step, line, facing):
    """At every measure line, in the plan and in the rendered motion."""
    targets = smoothed(follow_line(SQUARE if line == "square" else CIRCLE, 32, facing=facing))
    wanted = np.full(32, graph.library.steps.index(step))
    followed = follow_path(graph, targets, seconds=2.0, wanted=wanted, candidates=candidates, beam=24)
    assert not followed.wrong.any()
    assert (graph.library.node_step[followed.node] == wanted).all()
    assert followed.error.max() <= 0.15
    assert followed.error[-8:].mean() <= 0.1  # no drift at the end
    made = render_dance(
        graph, followed.node, bpm=120.0, turns=followed.turn, takes=(followed.take, followed.share),
        start=(*targets.place[0], targets.heading[0]), hold_feet=False,
    )  # fmt: skip
    lines = np.round(made.line_time[1:] * 60.0).astype(int)
    hips = made.clip.root_position[lines][:, [0, 2]]
    np.testing.assert_allclose(hips, followed.place, atol=5e-3)
    np.testing.assert_allclose(np.hypot(*(hips - targets.place[1:]).T), followed.error, atol=5e-3)


def test_exactly_feasible_path_is_followed_exactly(made):
    """Glides of 0.8 m to the left, one after another."""
    followed = follow_path(made, follow_line([(1, 2), (5, 2)], 5), seconds=2.0)
    np.testing.assert_allclose(followed.error, 0.0, atol=1e-4)
    np.testing.assert_allclose(followed.place, [(1.8, 2), (2.6, 2), (3.4, 2), (4.2, 2), (5, 2)], atol=1e-4)
    assert (followed.take == NO_TAKE).all()
    np.testing.assert_allclose(followed.turn, 0.0, atol=1e-4)


def exhaustive_path_cost(graph, candidates, targets, measures):
    """Cost of the best of all paths, one by one in scalars; errors are taken at the start of each next clip."""

    def line_cost(n, x, z, heading):
        error = math.hypot(x - targets.place[n, 0], z - targets.place[n, 1])
        off = math.remainder(heading - targets.heading[n], 2 * math.pi)
        return error**2 + 20.0 * max(error - 0.1, 0.0) ** 2 + 0.05 * off**2

    def laid(x, z, yaw, point):
        c, s = math.cos(yaw), math.sin(yaw)
        return x + point[0] * c + point[1] * s, z + point[1] * c - point[0] * s

    best = math.inf
    for path in itertools.product(range(graph.library.node_count), repeat=measures):
        total, x, z, yaw = 0.0, *targets.place[0], 0.0
        for n, node in enumerate(path):
            if n == 0:
                yaw = targets.heading[0] - graph.node_facing_start[node]
                x, z = laid(*targets.place[0], yaw, -graph.node_start[node])
            else:
                edge = edge_between(graph, path[n - 1], node)
                (x, z), yaw = laid(x, z, yaw, graph.edge_transform[edge]), yaw + graph.edge_transform[edge, 2]
                begin = laid(x, z, yaw, graph.node_start[node])
                total += 0.05 * graph.edge_cost[edge] + line_cost(n, *begin, yaw + graph.node_facing_start[node])
            turn = math.remainder(targets.heading[n + 1] - yaw - graph.node_facing[node], 2 * math.pi)
            row = candidates.first[node : node + 1]
            hips, heading = candidates.turned_end(row, np.array([[x, z, yaw]]), np.array([turn]))
            total += 0.005 * turn**2
            yaw = heading[0] - graph.node_facing[node]
            x, z = laid(*hips[0], yaw, -graph.node_end[node])
        best = min(best, total + line_cost(measures, *hips[0], heading[0]))
    return best


def followed_path_cost(graph, targets, followed):
    """Cost of the followed path from its own reported errors."""
    over = np.maximum(followed.error - 0.1, 0.0)
    edges = [edge_between(graph, u, v) for u, v in itertools.pairwise(followed.node.tolist())]
    lines = followed.error**2 + 20.0 * over**2 + 0.05 * followed.heading_error**2
    return float(lines.sum() + 0.05 * graph.edge_cost[edges].sum() + 0.005 * (followed.turn**2).sum())


@pytest.mark.long
@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_beam_search_equals_exhaustive_search(seed):
    """Three measures of three glides of different steps (no mixtures): the beam finds the best path."""
    chance = np.random.default_rng(seed)
    clips = [made_clip(f"glide {n}", way=tuple(way)) for n, way in enumerate(chance.uniform(-0.8, 0.8, (3, 2)))]
    graph = build_graph(build_library(clips), threshold=1.0)
    places = np.concatenate([np.zeros((1, 2)), np.cumsum(chance.uniform(-0.6, 0.6, (3, 2)), axis=0)])
    targets = Targets(places, chance.uniform(-0.3, 0.3, 4))
    candidates = find_candidates(graph)
    followed = follow_path(graph, targets, seconds=2.0, candidates=candidates)
    best = exhaustive_path_cost(graph, candidates, targets, 3)
    assert followed_path_cost(graph, targets, followed) == pytest.approx(best, rel=1e-6, abs=1e-9)


def test_path_errors_do_not_accumulate(made):
    """Only glides of 0.8 m, no mixtures, along a line of 0.5 m a measure: the error never exceeds that of one step."""
    library = build_library([made_clip("stay"), made_clip("go", way=(0.0, 0.8))])
    graph = build_graph(library, threshold=0.5)
    followed = follow_path(graph, follow_line([(0, 0), (0, 20)], 40), seconds=2.0)
    assert followed.error.max() <= 0.45
    assert followed.error[-1] <= 0.45


@pytest.mark.long
def test_wanted_steps_take_priority_over_path(graph, candidates):
    steps = graph.library.steps
    wanted = np.array([steps.index("walk"), ANY, steps.index("samba"), steps.index("samba"), ANY, ANY])
    followed = follow_path(
        graph, follow_line([(0, 0), (30, 0)], 6), seconds=2.0, wanted=wanted, candidates=candidates, beam=8
    )
    constrained = wanted != ANY
    assert (graph.library.node_step[followed.node][constrained] == wanted[constrained]).all()
    assert (np.diff(followed.error) > 0).all()


def test_two_measure_phrase_is_danced_whole(made):
    library = made.library
    phrase, sway = library.steps.index("phrase"), library.steps.index("sway")
    wanted, part = np.array([sway, phrase, phrase, phrase, phrase, sway]), [0, 0, 1, 0, 1, 0]
    fits = (library.node_step == wanted[:, None]) & (library.node_measure == np.array(part)[:, None])
    followed = follow_path(made, follow_line([(0, 0), (0, 0)], 6), seconds=2.0, fits=fits)
    assert not followed.wrong.any()
    assert library.node_measure[followed.node].tolist() == part
    # a phrase takes two measures: if wanted for only one, one is wrong
    followed = follow_path(made, follow_line([(0, 0), (0, 0)], 3), seconds=2.0, wanted=[sway, phrase, sway])
    assert followed.wrong.sum() == 1


@pytest.mark.long
@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_cost_to_go_is_lower_bound_and_reached(made_seed, measures):
    graph = _MADE
    chance = np.random.default_rng(made_seed)
    wrong = chance.uniform(size=(measures, graph.library.node_count)) < 0.6
    left = cost_to_go(graph, wrong)

    def fewest(n, u):
        if n == measures - 1:
            return 0.0
        targets = graph.edge_target[graph.edge_start[u] : graph.edge_start[u + 1]]
        return min((wrong[n + 1, v] + fewest(n + 1, v) for v in targets[:4]), default=math.inf)

    for u in range(graph.library.node_count):
        assert left[0, u] <= fewest(0, u)  # the minimum over all edges is at most that over four
    if measures == 1:
        assert (left == 0.0).all()
    # the bound is reached: following it greedily has exactly this cost
    u, spent = int(np.argmin(left[0] + np.where(np.diff(graph.edge_start) > 0, 0.0, np.inf))), 0.0
    begin = left[0, u]
    for n in range(1, measures):
        targets = graph.edge_target[graph.edge_start[u] : graph.edge_start[u + 1]]
        u = int(targets[np.argmin(wrong[n, targets] + left[n, targets])])
        spent += wrong[n, u]
    assert spent == begin


_MADE = build_graph(build_library(made_steps()), threshold=0.2)


@pytest.mark.long
def test_corrections_reduce_path_error(graph, candidates):
    targets = smoothed(follow_line(SQUARE, 16))
    walk = np.full(16, graph.library.steps.index("walk"))
    plain, corrected = (
        follow_path(graph, targets, seconds=2.0, wanted=walk, candidates=candidates, correction_m=most, beam=8)
        for most in (0.0, 0.08)
    )
    assert corrected.error.max() < plain.error.max()
    assert np.hypot(*corrected.correction.T).max() <= 0.08 + 1e-9
    assert not plain.correction.any()


def test_excess_candidates_are_limited_to_nearest(graph, candidates, monkeypatch):
    """At most 1500 rows in all, for some 900 of each hypothesis: the path is still followed."""
    monkeypatch.setattr("live.graph.search.path_following.MAX_CANDIDATES", 1500)
    targets = smoothed(follow_line(SQUARE, 32))
    walk = np.full(32, graph.library.steps.index("walk"))
    followed = follow_path(graph, targets, seconds=2.0, wanted=walk, candidates=candidates, beam=24)
    assert not followed.wrong.any()
    assert followed.error.max() <= 0.2


def test_turns_stay_within_maximum_turn(graph, candidates):
    targets = follow_line([(0, 0), (0, 0)], 4, facing=(0.0, math.pi))
    followed = follow_path(graph, targets, seconds=0.4, candidates=candidates, beam=8)
    assert (np.abs(followed.turn) <= candidates.max_turn(0.4)[followed.node] + 1e-12).all()
    assert np.abs(followed.turn).max() < math.pi / 2


def test_path_search_is_deterministic(graph, candidates):
    targets = follow_line(CIRCLE, 6, facing="path")
    first, second = (follow_path(graph, targets, seconds=2.0, candidates=candidates, beam=8) for _ in range(2))
    for name in first.__slots__:
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_inconsistent_arguments_are_refused(made):
    targets = follow_line([(0, 0), (0, 1)], 3)
    with pytest.raises(ValueError, match="wanted"):
        follow_path(made, targets, seconds=2.0, wanted=[0, 0])
    with pytest.raises(ValueError, match="fits"):
        follow_path(made, targets, seconds=2.0, fits=np.ones((3, 2), np.bool_))
    with pytest.raises(ValueError, match="longer than 0"):
        follow_path(made, targets, seconds=0.0)
    with pytest.raises(ValueError, match="at least one"):
        follow_path(made, Targets(np.zeros((1, 2)), np.zeros(1)), seconds=2.0)
    assert WRONG_COST > 1000.0
