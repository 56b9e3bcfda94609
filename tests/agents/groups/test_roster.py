"""Mirrors and canons (T092, T147)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.agents.groups.roster import Line, mirror_headings, mirror_places

FINITE = st.floats(-20, 20)
LINES = st.builds(Line, FINITE, FINITE, st.floats(-7, 7))


def test_center_line_mirror_swaps_left_and_right():
    assert mirror_places([[2.0, 3.0]], Line()) == pytest.approx(np.array([[-2.0, 3.0]]))
    assert mirror_headings(0.4, Line()) == pytest.approx(-0.4)
    across = Line.through((-1, 2), (1, 2))
    assert mirror_places([[3.0, 5.0]], across) == pytest.approx(np.array([[3.0, -1.0]]))


def test_line_through_equal_points_is_refused():
    with pytest.raises(ValueError, match="two different points"):
        Line.through((1, 1), (1, 1))


@given(LINES, st.lists(st.tuples(FINITE, FINITE), min_size=2, max_size=6), st.floats(-7, 7))
def test_mirror_is_an_isometric_involution_for_places_and_headings(line, places, heading):
    places = np.array(places)
    image = mirror_places(places, line)
    assert mirror_places(image, line) == pytest.approx(places, abs=1e-9)
    assert np.hypot(*np.diff(image, axis=0).T) == pytest.approx(np.hypot(*np.diff(places, axis=0).T), abs=1e-9)
    ahead = places + np.array([math.sin(heading), math.cos(heading)])
    turned = mirror_headings(heading, line)
    assert mirror_places(ahead, line) - image == pytest.approx(
        np.broadcast_to([math.sin(turned), math.cos(turned)], image.shape), abs=1e-8
    )
