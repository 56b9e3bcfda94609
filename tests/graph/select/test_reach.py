"""Tests of step reach: missing directions, and messages for paths that cannot be followed."""

import math

import numpy as np
import pytest

from live.graph.motion_graph import build_graph
from live.graph.search.path_diagnostics import path_problems
from live.graph.search.path_following import follow_line, follow_path
from live.graph.select.candidates import find_candidates
from live.graph.select.reachability import DIRECTION_NAMES, direction_of, reach_of
from live.graph.step_library import build_library
from tests.fixtures.made_steps import made_clip


def make_graph(ways, step="glide"):
    graph = build_graph(build_library([made_clip(step, way=way) for way in ways]), threshold=0.6)
    return graph, find_candidates(graph)


@pytest.mark.parametrize("n", range(8))
def test_directions_are_relative_to_dancer(n):
    """Facing +z, the dancer has her left at +x."""
    angle = n * math.pi / 4
    assert direction_of(np.array([math.sin(angle), math.cos(angle)])) == DIRECTION_NAMES[n]
    assert DIRECTION_NAMES[2] == "to the left"


def test_reach_covers_clips_and_mixtures():
    graph, candidates = make_graph([(0.0, 0.0), (0.0, 0.8), (0.6, 0.0)])
    reach = reach_of(graph, candidates, 0, 2.0)
    assert len(reach.clips) == 3
    assert len(reach.mixed) == 3 * 2 * 3
    np.testing.assert_allclose(sorted(np.hypot(*reach.clips.T)), [0.0, 0.6, 0.8], atol=1e-5)
    np.testing.assert_allclose(reach.straight[[0, 2]], [0.8, 0.6], atol=1e-5)
    # half forward, half to the left is 36.9 degrees off: forward left; three quarters forward is (0.15, 0.6)
    assert reach.straight[1] == pytest.approx(np.hypot(0.3, 0.4), abs=1e-4)
    assert reach.max_travel == pytest.approx(0.8, abs=1e-5)
    assert set(reach.missing) == set(DIRECTION_NAMES[3:])
    assert reach.turned.shape == (3 + 18, 33, 2)
    middle = reach.turned[:, 16]
    np.testing.assert_allclose(
        middle, np.concatenate([reach.clips, reach.mixed])[_matching_order(reach, middle)], atol=1e-6
    )


def _matching_order(reach, middle):
    """Rows of clips and mixtures in the order of `middle`: without a turn their displacements are equal."""
    everything = np.concatenate([reach.clips, reach.mixed])
    return [int(np.argmin(np.hypot(*(everything - way).T))) for way in middle]


def test_reach_is_independent_of_clip_facing():
    graph, candidates = make_graph([(0.0, 0.0), (0.7, 0.0)])
    turned, others = build_graph(
        build_library([made_clip("glide"), _facing_left(made_clip("glide", way=(0.7, 0.0)))]), threshold=2.0
    ), None  # fmt: skip
    others = find_candidates(turned)
    assert reach_of(graph, candidates, 0, 2.0).straight.argmax() == 2
    assert reach_of(turned, others, 0, 2.0).straight.argmax() == 0


def _facing_left(clip):
    """The clip with its body turned by 90 degrees about the hips and its travel unchanged."""
    from dataclasses import replace

    rotation = clip.clip.rotation.copy()
    rotation[:, 0] = math.cos(math.pi / 4), 0.0, math.sin(math.pi / 4), 0.0
    return replace(clip, clip=replace(clip.clip, rotation=rotation))


def test_path_within_reach_has_no_problems():
    graph, candidates = make_graph([(0.0, 0.0), (0.0, 0.8)])
    targets = follow_line([(0, 0), (0, 4)], 10)
    followed = follow_path(graph, targets, seconds=2.0, candidates=candidates)
    assert path_problems(graph, candidates, targets, followed, seconds=2.0) == []


def test_too_fast_path_is_reported_with_possible_speed():
    graph, candidates = make_graph([(0.0, 0.0), (0.0, 0.8)])
    targets = follow_line([(0, 0), (0, 20)], 10)
    followed = follow_path(graph, targets, seconds=2.0, candidates=candidates)
    (lack,) = path_problems(graph, candidates, targets, followed, seconds=2.0)
    assert lack.text == (
        "the path goes 2.00 m a measure, but 'glide' travels 0.80 m at most: "
        "give this path 25 measures instead of 10, or choose a step that travels farther"
    )
    # the suggested number of measures is feasible
    targets = follow_line([(0, 0), (0, 20)], 25)
    followed = follow_path(graph, targets, seconds=2.0, candidates=candidates)
    assert path_problems(graph, candidates, targets, followed, seconds=2.0) == []


def test_step_without_travel_is_reported():
    graph, candidates = make_graph([(0.0, 0.0)], step="bow")
    targets = follow_line([(0, 0), (0, 3)], 4)
    followed = follow_path(graph, targets, seconds=2.0, candidates=candidates)
    (lack,) = path_problems(graph, candidates, targets, followed, seconds=2.0)
    assert "record 'bow' with travel" in lack.text


def test_missing_direction_is_reported_with_measures():
    """Clips go forward and back, none to the sides; the path goes forward, then to the right."""
    graph, candidates = make_graph([(0.0, 0.0), (0.0, 0.8), (0.0, -0.8)])
    targets = follow_line([(0, 0), (0, 2.4), (-2.4, 2.4)], 6)
    followed = follow_path(graph, targets, seconds=2.0, candidates=candidates)
    lacks = path_problems(graph, candidates, targets, followed, seconds=2.0)
    assert [lack.direction for lack in lacks] == ["to the right"]
    assert lacks[0].measures == (4, 5, 6)
    assert "record 'glide' to the right, 1.0 m a measure" in lacks[0].text
    assert "measures 4, 5, 6" in lacks[0].text
    assert "0.80" not in lacks[0].text


def test_unknown_step_is_refused():
    graph, candidates = make_graph([(0.0, 0.0)])
    with pytest.raises(ValueError, match="no measure"):
        reach_of(graph, candidates, 7, 2.0)
