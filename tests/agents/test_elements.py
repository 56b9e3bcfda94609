"""Elements: fading, ends, bounds."""

import numpy as np
import pytest

from live.agents.elements import ATTRACTOR, SPREADER, Element, ElementField
from live.base.stage_view import StageView


def test_an_element_fades_over_a_beat_at_both_ends():
    element = Element(ATTRACTOR, start_beat=8.0, end_beat=16.0)
    assert [element.level(b) for b in (7.9, 8.0, 8.5, 9.0, 12.0, 15.5, 16.0)] == [0, 0, 0.5, 1, 1, 0.5, 0]


def test_ended_elements_are_forgotten_and_the_rest_is_shown():
    field = ElementField()
    field.add(Element(ATTRACTOR, 1.0, 2.0, 3.0, 0.0, 4.0))
    field.add(Element(SPREADER, start_beat=0.0, end_beat=100.0))
    field.refresh(2.0)
    assert field.count == 2
    assert field.strength[0] == pytest.approx(3.0)
    view = StageView.allocate(0, 22)
    field.show(view)
    assert view.element_count == 2
    assert view.element_position[0].tolist() == [1.0, 2.0]
    field.refresh(4.0)
    assert field.count == 1
    assert [element.kind for element in field.elements] == [SPREADER]


def test_clear_lets_everything_fade_out_from_the_level_it_has():
    field = ElementField()
    field.add(Element(ATTRACTOR, start_beat=0.0, end_beat=400.0))
    field.add(Element(ATTRACTOR, start_beat=9.75, end_beat=400.0))
    field.add(Element(ATTRACTOR, start_beat=30.0, end_beat=400.0))
    field.refresh(10.0)
    assert field.level[: field.count] == pytest.approx([1.0, 0.25])
    field.clear(10.0)
    field.refresh(10.0)
    assert field.level[: field.count] == pytest.approx([1.0, 0.25])
    field.refresh(10.125)
    assert field.level[: field.count] == pytest.approx([0.875, 0.125])
    field.refresh(11.0)
    assert field.count == 0
    assert field.elements == ()


def test_the_oldest_gives_way_when_the_field_is_full():
    field = ElementField(capacity=3)
    for x in range(5):
        field.add(Element(ATTRACTOR, x=float(x), end_beat=50.0))
    assert [element.x for element in field.elements] == [2.0, 3.0, 4.0]


def test_a_moved_element_does_not_fade_in_again_and_the_others_stay():
    field = ElementField()
    first = Element(ATTRACTOR, x=1.0, start_beat=0.0, end_beat=16.0)
    other = Element(SPREADER, start_beat=0.0, end_beat=16.0)
    field.add(first)
    field.add(other)
    moved = field.move(first, Element(ATTRACTOR, x=2.0, start_beat=3.0, end_beat=19.0))
    field.refresh(3.0)
    assert field.elements == (moved, other)
    assert np.isclose(field.level[0], 1.0)
    assert field.position[0, 0] == 2.0
    again = field.move(first, Element(ATTRACTOR, x=5.0, start_beat=3.0, end_beat=19.0))  # it is no longer there
    assert field.elements == (moved, other, again)
