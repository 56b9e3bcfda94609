"""Tests of pointer strokes: every tool creates an event that the registry accepts."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.control.events import events
from live.control.osc.osc_codec import decode, encode
from live.control.pointer import MAX_POINTS, MIN_STROKE, TOOLS, event_for_place, event_for_stroke
from live.control.registry.registry import REGISTRY

STAMP = {"time": 4.0, "source": "pointer"}
STROKE = [(0.0, 0.0), (0.5, 0.5), (2.0, 0.0)]


def test_first_tool_attracts_and_shift_repels():
    assert event_for_place("A", 1.5, -2.0, False, 4.0) == events.PlaceElement(
        kind="attract", points=((1.5, -2.0),), **STAMP
    )
    assert event_for_place("A", 1.5, -2.0, True, 4.0) == events.PlaceElement(
        kind="repel", points=((1.5, -2.0),), **STAMP
    )
    assert event_for_place("L", 1.5, -2.0, False, 4.0) is None
    assert next(iter(TOOLS)) == "A"


def test_walk_tool_creates_walk_events_while_drawing():
    place = {"x": 1.5, "z": -2.0, "partner": "*", **STAMP}
    assert event_for_place("0", 1.5, -2.0, True, 4.0) == events.WalkOn(anew=True, **place)
    assert event_for_place("0", 1.5, -2.0, False, 4.0) == events.WalkOn(**place)


def test_numpy_floats_become_plain_floats():
    event = event_for_place("A", np.float32(1.5), np.float64(-2.0), False, 4.0)
    assert event == events.PlaceElement(kind="attract", points=((1.5, -2.0),), **STAMP)
    assert [type(number) for number in event.points[0]] == [float, float]


@pytest.mark.parametrize(("x", "z"), [(math.nan, 0.0), (0.0, math.inf), (1e9, 0.0), (0.0, -100.5)])
def test_click_outside_the_floor_creates_no_event(x, z):
    assert event_for_place("A", x, z, False, 4.0) is None
    assert all(event_for_stroke(tool, [(0.0, 0.0), (x, z)], False, 4.0) is None for tool in ("L", "X", "U"))


@pytest.mark.parametrize("shift", [False, True])
@pytest.mark.parametrize("tool", TOOLS)
def test_every_tool_creates_an_event(tool, shift):
    event = event_for_stroke(tool, STROKE, shift, 4.0)
    assert event is not None
    assert event.source == "pointer"


@pytest.mark.parametrize(
    ("tool", "shift", "event"),
    [
        ("L", False, events.PlaceElement(kind="attract", points=((0.0, 0.0), (2.0, 0.0)), **STAMP)),
        ("L", True, events.PlaceElement(kind="repel", points=((0.0, 0.0), (2.0, 0.0)), **STAMP)),
        ("D", False, events.PlaceElement(kind="attract", points=((0.0, 0.0), (0.5, 0.5), (2.0, 0.0)), **STAMP)),
        ("R", False, events.PlaceElement(kind="attract", points=((0.0, 0.0),), radius=2.0, **STAMP)),
        ("X", False, events.PlaceElement(kind="cross", points=((0.0, 0.0), (2.0, 0.0)), **STAMP)),
        ("V", True, events.PlaceElement(kind="flow", flow="radial", points=((0.0, 0.0),), **STAMP)),
        ("T", False, events.Travel(points=((0.0, 0.0), (0.5, 0.5), (2.0, 0.0)), **STAMP)),
    ],
)
def test_strokes_create_the_expected_elements(tool, shift, event):
    assert event_for_stroke(tool, STROKE, shift, 4.0) == event


def test_click_creates_small_region_but_no_line():
    assert event_for_stroke("L", [(1.0, 1.0)], False, 4.0) is None
    assert event_for_stroke("P", [(1.0, 1.0)] * 9, False, 4.0) is None
    assert event_for_stroke("R", [(1.0, 1.0)], False, 4.0).radius == MIN_STROKE
    assert event_for_stroke("R", [], False, 4.0) is None


@given(st.lists(st.tuples(st.floats(-99.99, 99.99), st.floats(-99.99, 99.99)), min_size=2, max_size=300))
def test_long_stroke_is_thinned_to_point_limit(points):
    event = event_for_stroke("D", points, False, 4.0)
    far = sum(math.dist(a, b) for a, b in itertools.pairwise(points))
    assert (event is not None) == (far >= MIN_STROKE)
    if event is not None:
        assert 2 <= len(event.points) <= MAX_POINTS


@pytest.mark.parametrize("scale", [1.0, 60.0])
def test_a_stroke_of_512_points_is_kept_whole_also_by_osc(scale):
    points = [(round(scale * math.cos(k / 40), 2), round(-scale * math.sin(k / 25), 2)) for k in range(512)]
    assert event_for_stroke("D", points, False, 4.0).points == tuple(points)
    text = ", ".join(f"{x:g} {z:g}" for x, z in points)
    (message,) = decode(encode("/dance/attract/drawn", (text,)))
    assert REGISTRY.call(message.address, message.arguments, 4.0, "osc").points == tuple(points)
