"""Tests of candidates: mixed clips and their ends, against clips that are rendered."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.graph.motion_graph import build_graph
from live.graph.render_dance import render_dance
from live.graph.select.candidates import (
    OPPOSITE,
    find_candidates,
    is_opposite,
    measure_displacements,
    starting_placement,
)
from live.graph.step_library import build_library
from live.graph.takes import NO_TAKE
from live.motion.editing.interpolate import interpolate
from live.motion.editing.turn_insertion import insert_rotation
from live.motion.step_clip import travel
from tests.fixtures.made_steps import made_clip
from tests.fixtures.steps_of_the_project import project_steps


@pytest.fixture(scope="module")
def graph():
    return build_graph(build_library(project_steps("walk")))


@pytest.fixture(scope="module")
def candidates(graph):
    return find_candidates(graph)


@pytest.mark.long
def test_first_candidate_of_node_is_its_clip(graph, candidates):
    first = candidates.first[:-1]
    assert candidates.node[first].tolist() == list(range(graph.library.node_count))
    assert (candidates.take[first] == NO_TAKE).all()
    assert (np.diff(candidates.first) >= 1).all()
    assert candidates.first[-1] == len(candidates.node)


@pytest.mark.long
def test_only_opposite_directions_are_never_mixed(graph, candidates):
    way = measure_displacements(graph)
    names = {}
    for node, take in zip(candidates.node, candidates.take, strict=True):
        if take != NO_TAKE:
            a, b = way[node], way[take]
            if min(np.hypot(*a), np.hypot(*b)) > 0.1:
                assert a @ b > math.cos(OPPOSITE) * np.hypot(*a) * np.hypot(*b)
            library = graph.library
            pair = (library.clips[library.node_clip[node]].direction, library.clips[library.node_clip[take]].direction)
            names.setdefault(pair[0], set()).add(pair[1])
    assert names["long forward"] == {
        "in place",
        "short forward",
        "short left",
        "short right",
        "long left",
        "long right",
    }
    assert names["in place"] >= {"short back", "long back", "long forward", "long left", "long right"}


@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi), st.floats(0.1, 3.0), st.floats(0.1, 3.0))
def test_opposite_is_symmetric_and_depends_on_angle(a, b, length, other):
    ways = np.array([[length * math.sin(a), length * math.cos(a)], [other * math.sin(b), other * math.cos(b)]])
    apart = abs(math.remainder(a - b, 2 * math.pi))
    assert is_opposite(ways[0], ways[1:])[0] == is_opposite(ways[1], ways[:1])[0]
    if abs(apart - OPPOSITE) > 1e-6:
        assert is_opposite(ways[0], ways[1:])[0] == (apart > OPPOSITE)


def test_zero_displacement_has_no_opposite():
    assert not is_opposite(np.zeros(2), np.array([[0.0, -1.0], [0.0, 1.0]])).any()
    assert not is_opposite(np.array([0.0, 1.0]), np.zeros((1, 2))).any()


def test_candidate_ends_match_rendered_motion(graph, candidates):
    """Every candidate with a turn of its own, rendered as a clip and measured."""
    chance = np.random.default_rng(1)
    rows = chance.choice(len(candidates.node), 40, replace=False).astype(np.int32)
    most = candidates.max_turn(2.0)[candidates.node[rows]]
    angle = chance.uniform(-1.0, 1.0, len(rows)) * np.minimum(most, 1.2)
    start = np.tile([0.3, -0.8], (len(rows), 1))
    placement = starting_placement(graph, candidates.node[rows], start, np.full(len(rows), 0.5))
    hips, heading = candidates.turned_end(rows, placement, angle)
    for n, row in enumerate(rows):
        made = render_dance(
            graph, [candidates.node[row]], bpm=120.0, turns=angle[n : n + 1], start=(0.3, -0.8, 0.5),
            takes=([candidates.take[row]], [candidates.share[row]]), hold_feet=False,
        )  # fmt: skip
        np.testing.assert_allclose(made.clip.root_position[-1, [0, 2]], hips[n], atol=2e-3)
        assert made.end[0, 2] == pytest.approx(heading[n])


@pytest.mark.long
def test_candidate_ends_match_offline_tools(graph, candidates):
    """Interpolation (T045) and rotation insertion (T048-T050), which work sample by sample on whole clips."""
    library = graph.library
    for row in np.random.default_rng(2).choice(len(candidates.node), 25, replace=False):
        node, take = candidates.node[row], candidates.take[row]
        clip = library.clips[library.node_clip[node]]
        mixed = clip
        if take != NO_TAKE:
            mixed = interpolate(clip, library.clips[library.node_clip[take]], float(candidates.share[row]))
        np.testing.assert_allclose(candidates.end[row] - graph.node_start[node], travel(mixed), atol=0.03)
    for node in (0, 4, 9, 13):
        clip = library.clips[library.node_clip[node]]
        row = candidates.first[node : node + 1]
        turned = insert_rotation(clip, 0.6, measure=0, window=graph.window, softness=0.3)
        place = np.zeros((1, 3))
        end, _ = candidates.turned_end(row, place, np.array([0.6]))
        begin = turned.clip.root_position[round(turned.first), [0, 2]]
        np.testing.assert_allclose(end[0] - begin, travel(turned), atol=0.02)


def test_number_of_mixed_takes_is_limited():
    clips = [made_clip("glide", way=(0.0, 0.3 + 0.01 * n)) for n in range(40)]
    candidates = find_candidates(build_graph(build_library(clips), threshold=0.3))
    assert np.diff(candidates.first).max() == 1 + 24 * 3
