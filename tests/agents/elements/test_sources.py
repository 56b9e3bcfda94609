"""Attractors and repulsors: the force laws of T105 and nearest-only (T106), against plain numpy and shapely."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from live.agents.elements.element import Element, rectangle
from live.agents.elements.element_kinds import ATTRACTOR, REPULSOR
from tests.agents.elements.made_stage import MadeStage

PLACE = st.tuples(st.floats(-6.0, 6.0, width=32), st.floats(-4.0, 4.0, width=32))


def expected(agent, kind, points, decay, strength=1.0):
    """T105 with the nearest of `points` only, in numpy."""
    points, agent = np.array(points), np.array(agent)
    way = points - agent
    d = np.hypot(*way.T)
    k = d.argmin()
    if kind == ATTRACTOR:
        return strength * (1.0 - np.exp(-d[k] / decay)) * way[k] / d[k]
    return -strength * np.exp(-d[k] / decay) * way[k] / d[k]


@settings(max_examples=80, deadline=None)
@given(PLACE, st.lists(PLACE, min_size=1, max_size=6), st.sampled_from((ATTRACTOR, REPULSOR)), st.floats(0.3, 4.0))
def test_force_laws_and_nearest_only_are_those_of_the_thesis(agent, sources, kind, decay):
    distances = sorted(np.hypot(*(np.array(sources) - agent).T))
    assume(distances[0] > 1e-3 and (len(distances) == 1 or distances[1] - distances[0] > 1e-3))
    stage = MadeStage([agent], *(Element(kind, (p,), strength=0.8, decay=decay) for p in sources))
    assert stage.wish()[0] == pytest.approx(expected(agent, kind, sources, decay, 0.8), abs=1e-4)


def test_attraction_and_repulsion_of_one_decay_add_up_to_one():
    for d in (0.1, 0.7, 2.0, 5.0):
        to = MadeStage([[0, 0]], Element(ATTRACTOR, ((d, 0.0),), decay=1.5)).wish()[0, 0]
        away = MadeStage([[0, 0]], Element(REPULSOR, ((d, 0.0),), decay=1.5)).wish()[0, 0]
        assert to - away == pytest.approx(1.0, abs=1e-6)


@settings(max_examples=50, deadline=None)
@given(PLACE, st.lists(PLACE, min_size=2, max_size=5))
def test_a_line_attracts_to_its_nearest_point(agent, points):
    line = shapely.LineString(points)
    assume(line.length > 0.1 and line.distance(shapely.Point(agent)) > 0.01)
    wish = MadeStage([agent], Element(ATTRACTOR, tuple(points))).wish()[0]
    d = line.distance(shapely.Point(agent))
    assert np.hypot(*wish) == pytest.approx(1.0 - np.exp(-d / 1.2), abs=1e-3)


@pytest.mark.parametrize(
    "region",
    [
        Element(ATTRACTOR, ((1.0, 0.0),), radius=1.5),
        Element(ATTRACTOR, rectangle(1.0, 0.0, 3.0, 2.0), closed=True),
        Element(ATTRACTOR, ((0.0, 0.0), (2.0, 0.0)), radius=1.0),
        Element(ATTRACTOR, rectangle(1.0, 0.0, 1.0, 1.0), closed=True, radius=0.5),
    ],
)
def test_a_region_attracts_until_inside_and_then_lets_free(region):
    inside = MadeStage([[1.0, 0.3]], region)
    assert (inside.wish() == 0.0).all()
    outside = MadeStage([[5.0, 0.0]], region).wish()[0]
    assert outside[0] < -0.5
    away = MadeStage([[1.0, 0.3]], Element(REPULSOR, region.points, closed=region.closed, radius=region.radius))
    assert np.hypot(*away.wish()[0]) == pytest.approx(1.0)  # out of it, at full speed
    assert away.wish()[0, 1] > 0.0  # by the nearest border


def test_a_fading_nearest_source_hands_over_to_the_next():
    elements = Element(ATTRACTOR, ((1.0, 0.0),), start_beat=8.0), Element(ATTRACTOR, ((-3.0, 0.0),))
    stage = MadeStage([[0, 0]], *elements)
    near, far = 1.0 - np.exp(-1.0 / 1.2), -(1.0 - np.exp(-3.0 / 1.2))
    for into in (0.0, 0.25, 0.5, 1.0):
        level = elements[0].level(8.0 + into)
        assert stage.wish(8.0 + into)[0, 0] == pytest.approx(level * near + (1.0 - level) * far, abs=1e-5)


def test_on_the_source_itself_repelled_agents_part_by_seeded_chance():
    stage = MadeStage(np.zeros((4, 2)), Element(REPULSOR, decay=100.0))
    wish = stage.wish()
    assert np.hypot(*wish.T) == pytest.approx(np.ones(4), abs=1e-4)
    assert len({tuple(w) for w in wish.round(3).tolist()}) == 4
    assert (MadeStage(np.zeros((4, 2)), Element(REPULSOR, decay=100.0), seed=2).wish() != wish).any()
