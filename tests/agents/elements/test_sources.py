"""Attractors and repulsors: force laws of T105 and nearest-only (T106), against plain numpy and shapely."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from live.agents.elements.element import Element, rectangle
from live.base.element_kinds import ATTRACTOR, REPULSOR
from tests.agents.elements.made_stage import StageHarness

PLACE = st.tuples(st.floats(-6.0, 6.0, width=32), st.floats(-4.0, 4.0, width=32))


def thesis_velocity(agent, kind, points, decay, strength=1.0):
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
def test_force_laws_match_thesis_with_nearest_source_only(agent, sources, kind, decay):
    distances = sorted(np.hypot(*(np.array(sources) - agent).T))
    assume(distances[0] > 1e-3 and (len(distances) == 1 or distances[1] - distances[0] > 1e-3))
    stage = StageHarness([agent], *(Element(kind, (p,), strength=0.8, decay=decay) for p in sources))
    assert stage.wish()[0] == pytest.approx(thesis_velocity(agent, kind, sources, decay, 0.8), abs=1e-4)


def test_attraction_and_repulsion_of_equal_decay_sum_to_one():
    for d in (0.1, 0.7, 2.0, 5.0):
        to = StageHarness([[0, 0]], Element(ATTRACTOR, ((d, 0.0),), decay=1.5)).wish()[0, 0]
        away = StageHarness([[0, 0]], Element(REPULSOR, ((d, 0.0),), decay=1.5)).wish()[0, 0]
        assert to - away == pytest.approx(1.0, abs=1e-6)


@settings(max_examples=50, deadline=None)
@given(PLACE, st.lists(PLACE, min_size=2, max_size=5))
def test_line_attracts_to_its_nearest_point(agent, points):
    line = shapely.LineString(points)
    assume(line.length > 0.1 and line.distance(shapely.Point(agent)) > 0.01)
    wish = StageHarness([agent], Element(ATTRACTOR, tuple(points))).wish()[0]
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
def test_region_attracts_only_agents_outside(region):
    inside = StageHarness([[1.0, 0.3]], region)
    assert (inside.wish() == 0.0).all()
    outside = StageHarness([[5.0, 0.0]], region).wish()[0]
    assert outside[0] < -0.5
    away = StageHarness([[1.0, 0.3]], Element(REPULSOR, region.points, closed=region.closed, radius=region.radius))
    assert np.hypot(*away.wish()[0]) == pytest.approx(1.0)  # out of it, at full speed
    assert away.wish()[0, 1] > 0.0  # by the nearest border


def test_fading_nearest_source_blends_with_the_next():
    elements = Element(ATTRACTOR, ((1.0, 0.0),), start_beat=8.0), Element(ATTRACTOR, ((-3.0, 0.0),))
    stage = StageHarness([[0, 0]], *elements)
    near, far = 1.0 - np.exp(-1.0 / 1.2), -(1.0 - np.exp(-3.0 / 1.2))
    for into in (0.0, 0.25, 0.5, 1.0):
        level = elements[0].level(8.0 + into)
        assert stage.wish(8.0 + into)[0, 0] == pytest.approx(level * near + (1.0 - level) * far, abs=1e-5)


def test_agents_on_repulsor_separate_in_seeded_random_directions():
    stage = StageHarness(np.zeros((4, 2)), Element(REPULSOR, decay=100.0))
    wish = stage.wish()
    assert np.hypot(*wish.T) == pytest.approx(np.ones(4), abs=1e-4)
    assert len({tuple(w) for w in wish.round(3).tolist()}) == 4
    assert (StageHarness(np.zeros((4, 2)), Element(REPULSOR, decay=100.0), seed=2).wish() != wish).any()
