"""Tests of the choice of the next measure and its end against a slow loop over all candidates."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.graph.motion_graph import build_graph
from live.graph.select import selector as tuned
from live.graph.select.candidates import MAX_TURN_RATE
from live.graph.select.selector import StepSelector, with_direction
from live.graph.step_library import build_library
from live.graph.takes import NO_TAKE
from tests.fixtures.steps_of_the_project import project_steps

SECONDS = 2.0
TURN = math.radians(50.0)
REACH_MARGIN = 0.2
TABLE_TOLERANCE = 0.003
"""Largest error [m] of the tabulated displacement of a turn."""


@pytest.fixture(scope="module")
def graph():
    return build_graph(build_library(project_steps("walk", "groove")))


@pytest.fixture(scope="module")
def step_selector(graph):
    made = StepSelector.of(graph)
    made.set_limits(seconds=SECONDS, turn=TURN, correction=REACH_MARGIN)
    return made


def random_questions(graph, seed, count=3):
    """Questions of dancers at random placements with random wishes."""
    chance = np.random.default_rng(seed)
    steps = len(graph.library.steps)
    away = (graph.library.node_step != np.arange(steps)[:, None]).astype(np.float64)
    return {
        "node": chance.choice(np.flatnonzero(graph.alive), count).astype(np.int32),
        "placement": with_direction(chance.uniform(-3, 3, (count, 3))),
        "wish": with_direction(np.column_stack([chance.uniform(-2.5, 2.5, (count, 2)), chance.uniform(-9, 9, count)])),
        "row": chance.integers(0, steps + 1, count).astype(np.int32),
        "ahead": np.vstack([away, np.zeros(graph.library.node_count)]),
        "side": chance.integers(-1, 2, count).astype(np.int32),
        "manner": np.column_stack(
            [chance.integers(0, 2, count), chance.choice([0.0, 0.0, 1.0, 0.5], count), chance.uniform(0, 1, count)]
        ).astype(np.float64),
    }


def run_selector(step_selector, question, *, slices=None):
    count = len(question["node"])
    out = (
        np.full((count, 2), -9, np.int32), np.full((count, 2), -9, np.int32), np.full((count, 2, 5), np.nan),
        np.full((count, 4), np.nan),
    )  # fmt: skip
    for rows in slices or [slice(0, count)]:
        step_selector.choose(rows, *question.values(), out)
    return out


def evaluate_candidates(graph, step_selector, question, n):
    """Cost terms and end of all candidates on all edges of dancer n, by complex numbers: {(e, k): ...}."""
    candidates, found = step_selector.candidates, {}
    x, z, yaw = question["placement"][n, :3]
    wish_x, wish_z, heading = question["wish"][n, :3]
    support, average, share = question["manner"][n]
    for e in range(graph.edge_start[question["node"][n]], graph.edge_start[question["node"][n] + 1]):
        v = graph.edge_target[e]
        origin = complex(z, x) + complex(graph.edge_transform[e, 1], graph.edge_transform[e, 0]) * np.exp(1j * yaw)
        turned = yaw + graph.edge_transform[e, 2]
        most = min(TURN, MAX_TURN_RATE * SECONDS / graph.node_peak_turn_rate[v])
        for k in range(candidates.first[v], candidates.first[v + 1]):
            facing = candidates.facing[k]
            ahead_of = math.remainder(graph.node_facing_mean[v] - facing, 2 * math.pi)
            want = math.remainder(heading - turned - facing - average * ahead_of, 2 * math.pi)
            turn = min(max(want, -most), most)
            if support:
                one = np.array([k], np.int32)
                hips, _ = candidates.turned_end(one, np.array([[origin.imag, origin.real, turned]]), np.array([turn]))
                end = complex(hips[0, 1], hips[0, 0])
            else:
                end = origin + complex(candidates.end[k, 1], candidates.end[k, 0]) * np.exp(1j * turned)
            off = abs(end - complex(wish_z, wish_x))
            within = min(off, share * REACH_MARGIN)
            side = question["side"][n] * (1 if graph.library.clips[graph.library.node_clip[v]].mirrored else -1) < 0
            terms = (
                tuned.CORRECTION_COST * within**2 + tuned.PLACE_COST * (off**2 - within**2),
                tuned.HEADING_COST * (want - turn) ** 2 + tuned.TURN_COST * turn**2,
                tuned.POSE_COST * graph.edge_cost[e],
                tuned.WRONG_COST * question["ahead"][question["row"][n], v],
                tuned.SIDE_COST * side
                + tuned.MIXTURE_COST * (candidates.take[k] != NO_TAKE)
                + step_selector.facts[v, 2],
            )
            found[e, k] = terms, off, (end.imag, end.real, turn, want - turn)
    return found


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_cheapest_candidate_and_best_alternative_are_chosen(graph, step_selector, seed):
    question = random_questions(graph, seed)
    edge, candidate, terms, end = run_selector(step_selector, question)
    for n in range(len(edge)):
        found = evaluate_candidates(graph, step_selector, question, n)
        cost = {key: sum(row[0]) for key, row in found.items()}
        for rank in range(2):
            others = {key: value for key, value in cost.items() if not rank or key[0] != edge[n, 0]}
            if not others:
                assert edge[n, rank] == candidate[n, rank] == -1
                continue
            mine = edge[n, rank], candidate[n, rank]
            allowed = (
                2.5 * TABLE_TOLERANCE * (max(found[mine][1], found[min(others, key=others.get)][1]) + TABLE_TOLERANCE)
            )
            assert others[mine] <= min(others.values()) + allowed
            tolerance = [2.5 * TABLE_TOLERANCE * (found[mine][1] + TABLE_TOLERANCE), *[1e-9] * 4]
            assert (np.abs(terms[n, rank] - found[mine][0]) <= tolerance).all()
        assert np.abs(end[n, :2] - found[edge[n, 0], candidate[n, 0]][2][:2]).max() < TABLE_TOLERANCE
        assert end[n, 2:] == pytest.approx(found[edge[n, 0], candidate[n, 0]][2][2:], abs=1e-9)


@pytest.mark.long
def test_sliced_choice_is_bit_identical(graph, step_selector):
    question = random_questions(graph, 5, count=11)
    whole = run_selector(step_selector, question)
    parts = run_selector(step_selector, question, slices=[slice(7, 11), slice(0, 3), slice(3, 7)])
    for one, other in zip(whole, parts, strict=True):
        assert one.tobytes() == other.tobytes()


def single_question(graph, node, wish):
    """Question of one dancer in `node`, with walk as wanted step and `wish` (3,) as wanted end."""
    library = graph.library
    ahead = (library.node_step != library.step_index("walk")).astype(np.float64)[None]
    return {
        "node": np.array([node], np.int32), "placement": with_direction(np.zeros((1, 3))),
        "wish": with_direction(np.array([wish])), "row": np.zeros(1, np.int32), "ahead": ahead,
        "side": np.zeros(1, np.int32), "manner": np.array([[1.0, 0.0, 0.0]]),
    }  # fmt: skip


@pytest.mark.long
def test_mixtures_fill_gaps_between_clips(graph, step_selector):
    """On a grid of places within the longest steps: with mixtures every place is near an end, without them not."""
    candidates = step_selector.candidates
    begin = int(graph.entries(graph.library.step_index("walk"))[0])
    there = graph.node_end[begin]
    mixed, plain = [], []
    for x in np.linspace(-0.5, 0.5, 5):
        for z in np.linspace(-0.5, 0.9, 6):
            question = single_question(graph, begin, [there[0] + x, there[1] + z, graph.node_facing[begin]])
            end = run_selector(step_selector, question)[3]
            mixed.append(math.hypot(*(end[0, :2] - question["wish"][0, :2])))
            found = evaluate_candidates(graph, step_selector, question, 0)
            walks = [row[1] for (_, k), row in found.items() if candidates.take[k] == NO_TAKE and row[0][3] == 0.0]
            plain.append(min(walks))
    assert np.mean(mixed) < 0.5 * np.mean(plain)
    assert np.mean(mixed) < 0.1


def test_exact_clip_end_needs_no_mixture(graph, step_selector):
    candidates = step_selector.candidates
    begin = int(graph.entries(graph.library.step_index("walk"))[0])
    question = single_question(graph, begin, [0.0, 0.0, graph.node_facing[begin]])
    for (_, k), (terms, _, end) in evaluate_candidates(graph, step_selector, question, 0).items():
        if candidates.take[k] == NO_TAKE and terms[3] == 0.0:
            row = run_selector(
                step_selector, single_question(graph, begin, [end[0], end[1], graph.node_facing[begin]])
            )[1][0, 0]
            assert candidates.take[row] == NO_TAKE or candidates.node[row] != candidates.node[k]


def test_chosen_turns_stay_within_limits(graph, step_selector):
    question = random_questions(graph, 9, count=40)
    edge, _, _, end = run_selector(step_selector, question)
    node = graph.edge_target[edge[:, 0]]
    assert (np.abs(end[:, 2]) <= step_selector.max_turns[node, 0] + 1e-12).all()
    assert (step_selector.max_turns[:, 0] <= TURN).all()


def test_mixture_spread_bound_is_never_too_small(graph, step_selector):
    """The bound used to skip mixtures, against mixtures turned at random."""
    candidates, chance = step_selector.candidates, np.random.default_rng(2)
    for _ in range(40):
        v = int(chance.integers(graph.library.node_count))
        rows = np.arange(candidates.first[v], candidates.first[v + 1], dtype=np.int32)
        heading = chance.uniform(-TURN, TURN) * 0.8
        turn = np.clip(heading - candidates.facing[rows] + candidates.facing[rows[0]], -TURN, TURN)
        hips, _ = candidates.turned_end(rows, np.zeros((len(rows), 3)), turn)
        assert np.hypot(*(hips - hips[0]).T).max() <= step_selector.facts[v, 1] + 1e-9
