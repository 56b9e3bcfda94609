"""Elements as values: fade-in, fade-out and refused parameters."""

import math

import numpy as np
import pytest

from live.agents.elements.element import Element, line_length, rectangle
from live.base.element_kinds import ATTRACTOR, CROSSING, EVADE, FLOW, FOLLOW, PARTICIPANT, PATH, REPULSOR
from live.base.errors import PersonError


def test_element_fades_in_and_out_over_one_beat():
    element = Element(ATTRACTOR, start_beat=8.0, end_beat=16.0)
    assert [element.level(b) for b in (7.9, 8.0, 9.0, 12.0, 15.5, 16.0)] == [0, 0, 1, 1, 0.5, 0]
    coming = np.array([element.level(8.0 + into) for into in np.linspace(0.0, 1.0, 101)])
    slope = np.diff(coming) / 0.01
    assert (slope > 0.0).all()
    assert (np.diff(slope) < 0.0).all()  # a fast start ...
    assert 3.8 < slope[0] < 4.0  # ... of bounded slope
    assert slope[-1] < 0.01


def test_ended_element_fades_from_its_current_level():
    element = Element(ATTRACTOR, start_beat=8.0, end_beat=16.0).faded_out(8.25)
    begun = 1.0 - 0.75**4
    assert [element.level(b) for b in (8.25, 8.375, 8.25 + begun, 9.0)] == pytest.approx([begun, begun - 0.125, 0, 0])
    late = Element(ATTRACTOR, start_beat=8.0, end_beat=16.0)
    assert late.faded_out(15.9) is late  # already fading out
    endless = Element(ATTRACTOR).faded_out(100.0)
    assert endless.level(100.5) == 0.5


@pytest.mark.parametrize(
    "asked",
    [
        {"kind": 99},
        {"kind": ATTRACTOR, "points": ((math.nan, 0.0),)},
        {"kind": ATTRACTOR, "points": ()},
        {"kind": ATTRACTOR, "points": ((2e6, 0.0),)},
        {"kind": ATTRACTOR, "strength": math.inf},
        {"kind": ATTRACTOR, "start_beat": math.nan},
        {"kind": ATTRACTOR, "end_beat": math.nan},
        {"kind": ATTRACTOR, "radius": -1.0},
        {"kind": ATTRACTOR, "decay": 0.0},
        {"kind": ATTRACTOR, "groups": 0},
        {"kind": ATTRACTOR, "groups": 1 << 64},
        {"kind": REPULSOR, "fair": True},
        {"kind": CROSSING, "points": ((1.0, 1.0),)},
        {"kind": CROSSING, "points": ((1.0, 1.0), (1.0, 1.0))},
        {"kind": CROSSING, "points": ((1.0, 1.0), (1.0, 1.0), (2.0, 2.0))},
        {"kind": PATH, "points": ((1.0, 1.0), (1.0, 1.0), (1.0, 1.0))},
        {"kind": FLOW, "points": ((1.0, 1.0),)},
        {"kind": FLOW, "flow_kind": 9, "points": ((1.0, 1.0), (2.0, 1.0))},
        {"kind": FOLLOW},
        {"kind": EVADE, "target": 1, "target_group": 2},
        {"kind": EVADE, "target_group": 64},
        {"kind": ATTRACTOR, "points": tuple((0.0, float(k % 7)) for k in range(5000))},
    ],
)
def test_invalid_element_is_refused(asked):
    with pytest.raises(PersonError):
        Element(**asked)


def test_shape_helpers_give_expected_points():
    assert line_length(rectangle(0.0, 0.0, 4.0, 2.0)) == pytest.approx(4 + 2 + 4)
    assert Element(ATTRACTOR, fair=True).table_kind == PARTICIPANT
