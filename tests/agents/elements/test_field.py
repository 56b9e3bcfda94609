"""The element field: addressed groups, strengths, blending over a plan, bounds and determinism."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.agent_command import ABSENT
from live.agents.elements.element import Element
from live.agents.elements.element_field import ElementField
from live.base.element_kinds import (
    ATTRACTOR,
    CROSSING,
    DRAWN,
    EVADE,
    FLOCK,
    FLOW,
    FOLLOW,
    GRID,
    PARTICIPANT,
    PATH,
    PURSUE,
    RADIAL,
    REPULSOR,
    SPREADER,
    VORTEX,
    WANDER,
)
from live.base.errors import PersonError
from live.base.stage_snapshot import StageView
from tests.agents.elements.made_stage import SPEED, StageHarness

PLACE = st.tuples(st.floats(-7.0, 7.0, width=32), st.floats(-5.0, 5.0, width=32))
ONE_OF_EACH = (
    Element(ATTRACTOR, ((1.0, 1.0),)),
    Element(REPULSOR, ((0.0, 0.0), (1.0, 1.0))),
    Element(SPREADER),
    Element(CROSSING, ((0.0, 0.0), (1.0, 1.0))),
    Element(FLOW, ((0.0, 0.0), (1.0, 1.0), (2.0, 0.0)), flow_kind=DRAWN),
    Element(FLOW, flow_kind=VORTEX),
    Element(FLOW, flow_kind=RADIAL, radius=2.0),
    Element(WANDER),
    Element(FLOCK),
    Element(FOLLOW, target=0),
    Element(PURSUE, target=1),
    Element(EVADE, target_group=3),
    Element(PATH, ((0.0, 0.0), (1.0, 1.0), (2.0, 0.0)), closed=True),
    Element(ATTRACTOR, ((3.0, 3.0),), fair=True),
)


def test_plan_without_elements_is_unchanged():
    stage = StageHarness([[0, 0], [1, 1]])
    stage.wish(planned=(0.5, 0.25))
    assert (stage.wants.velocity == (0.5, 0.25)).all()
    assert (stage.wants.firmness == 1.0).all()
    assert (stage.field.influence == 0.0).all()


def test_element_replaces_plan_as_it_fades_in():
    stage = StageHarness([[0, 0]], Element(ATTRACTOR, ((4.0, 0.0),), start_beat=8.0))
    full = 1.0 - np.exp(-4.0 / 1.2)
    for beat, level in ((8.0, 0.0), (8.25, 1.0 - 0.75**4), (8.75, 1.0 - 0.25**4), (9.0, 1.0)):
        wish = stage.wish(beat, planned=(0.0, 1.0))
        assert wish[0] == pytest.approx([level * full, (1.0 - level) / SPEED], abs=1e-5)
        assert stage.wants.firmness[0] == pytest.approx(1.0 - level)
        assert stage.field.influence[0] == pytest.approx(level)
        assert stage.wants.separation[0] == pytest.approx(level)


def test_element_affects_only_addressed_groups():
    for element in ONE_OF_EACH:
        asked = Element(**{**{f: getattr(element, f) for f in element.__slots__}, "groups": 0b0110})
        stage = StageHarness([[0, 2], [2, 1], [-3, 0], [1, -2]], asked, groups=[0b1001, 0b0100, 0, 0b1110])
        stage.wish(planned=(0.1, 0.1))
        assert stage.wants.velocity[[0, 2]] == pytest.approx(np.full((2, 2), 0.1))
        assert (stage.field.influence[[0, 2]] == 0.0).all()
        assert (stage.wants.separation[[0, 2]] == 0.0).all()
        assert (stage.field.influence[[1, 3]] > 0.0).any()


def test_absent_agent_is_unaffected_and_ignored_by_spreader():
    stage = StageHarness([[-1, 0], [1, 0], [3, 0]], Element(SPREADER), Element(FOLLOW, target=2))
    both = stage.wish()
    stage.wants.presence[2] = ABSENT
    alone = stage.wish()
    assert (alone[2] == 0.0).all()
    assert (alone[:2] != both[:2]).any()


@settings(max_examples=60, deadline=None)
@given(st.lists(PLACE, min_size=1, max_size=12), st.lists(st.sampled_from(ONE_OF_EACH), max_size=14), st.booleans())
def test_velocities_are_finite_and_within_top_speed(places, elements, switched):
    stage = StageHarness(places, *elements, combine="switched" if switched else "blended")
    wish = stage.wish()
    assert np.isfinite(stage.wants.rows).all()
    assert (np.hypot(*wish.T) <= 1.0 + 1e-5).all()
    assert ((stage.field.influence >= 0.0) & (stage.field.influence <= 1.0)).all()
    again = StageHarness(places, *elements, combine="switched" if switched else "blended")
    assert (again.wish() == wish).all()


def test_coincident_agents_on_a_source_get_finite_velocities():
    stage = StageHarness(np.ones((5, 2)), *ONE_OF_EACH)
    assert np.isfinite(stage.wish()).all()
    empty = StageHarness(np.zeros((0, 2)), *ONE_OF_EACH)
    assert empty.wish().shape == (0, 2)


def test_switched_combination_serves_urgent_elements_first():
    elements = Element(REPULSOR, ((-0.1, 0.0),)), Element(ATTRACTOR, ((0.0, 9.0),))
    blended = StageHarness([[0, 0]], *elements).wish()[0]
    switched = StageHarness([[0, 0]], *elements, combine="switched").wish()[0]
    away = np.exp(-0.1 / 1.6)
    assert switched == pytest.approx([away, 1.0 - away], abs=1e-4)  # the attractor gets what is left
    assert blended[1] > 0.6


def test_prediction_on_copies_leaves_field_unchanged():
    stage = StageHarness([[0, 0], [2, 1]], *ONE_OF_EACH)
    wish, influence = stage.wish(), stage.field.influence.copy()
    other = StageHarness([[3, 3], [-2, 1]])
    own = np.zeros(2, np.float32)
    stage.field.apply(other.wants, other.state, other.groups, time=9.0, influence=own)
    assert (stage.field.influence == influence).all()
    assert (stage.wish() == wish).all()
    assert own.any()


def test_full_field_evicts_oldest_but_phones_never_evict_show():
    field = ElementField(1, half_width=6.0, half_depth=4.0, capacity=3)
    for x in range(4):
        field.add(Element(ATTRACTOR, ((float(x), 0.0),)))
    assert [e.x for e in field.elements] == [1.0, 2.0, 3.0]
    assert not field.add(Element(ATTRACTOR, fair=True))
    field.end(0.0, kind=ATTRACTOR)
    field.refresh(50.0, *_idle_inputs())
    for x in range(4):
        field.add(Element(ATTRACTOR, ((float(x), 0.0),), fair=True))
    assert [e.x for e in field.elements] == [1.0, 2.0, 3.0]
    field.add(Element(REPULSOR, ((9.0, 0.0),)))
    assert [e.x for e in field.elements] == [2.0, 3.0, 9.0]


def _idle_inputs():
    stage = StageHarness([[0, 0]])
    return stage.wants, stage.state, stage.groups


def test_elements_end_by_source_and_kind_and_group():
    field = ElementField(1, half_width=6.0, half_depth=4.0)
    field.add(Element(ATTRACTOR, source="phone 1", groups=0b01))
    field.add(Element(REPULSOR, source="phone 1", groups=0b10))
    field.add(Element(ATTRACTOR, source="phone 2", groups=0b11))
    field.add(Element(ATTRACTOR, source="later", start_beat=90.0))
    assert field.end(10.0, source="phone 1", kind=REPULSOR) == 1
    assert field.end(10.0, groups=0b10) == 3
    assert [e.source for e in field.elements] == [
        "phone 1",
        "phone 1",
        "phone 2",
    ]  # elements not yet started are removed at once
    field.refresh(10.5, *_idle_inputs())
    assert sorted(e.level(10.5) for e in field.elements) == [0.5, 0.5, 1.0]
    field.refresh(11.5, *_idle_inputs())
    assert [(e.source, e.kind) for e in field.elements] == [("phone 1", ATTRACTOR)]
    field.clear(11.5)
    field.refresh(12.5, *_idle_inputs())
    assert field.elements == ()


def test_moved_element_keeps_its_fade_level():
    stage = StageHarness([[0, 0]], Element(ATTRACTOR, ((4.0, 0.0),), start_beat=0.0, end_beat=16.0))
    old = stage.field.elements[0]
    stage.wish(8.0)
    moved = stage.field.move(old, Element(ATTRACTOR, ((0.0, 4.0),), start_beat=8.0, end_beat=24.0))
    wish = stage.wish(8.0)[0]
    assert wish == pytest.approx([0.0, 1.0 - np.exp(-4.0 / 1.2)], abs=1e-5)
    assert stage.field.elements == (moved,)
    assert moved.end_beat == 24.0
    stage.field.move(old, Element(ATTRACTOR, start_beat=8.0))  # no longer in the field: a new element
    assert len(stage.field.elements) == 2


def test_snapshot_contains_element_kind_position_and_level():
    stage = StageHarness([[0, 0]], Element(SPREADER), Element(ATTRACTOR, ((1.0, 2.0),), start_beat=7.5))
    stage.wish(8.0)
    view = StageView.allocate(0, 22)
    stage.field.write_view(view)
    assert view.element_count == 2
    assert view.element_kind[:2].tolist() == [ATTRACTOR, SPREADER]
    assert view.element_position[0].tolist() == [1.0, 2.0]
    assert view.element_level[:2].tolist() == [0.9375, 1.0]  # after half of the fade


def test_full_snapshot_omits_whole_lines():
    field = ElementField(1, half_width=6.0, half_depth=4.0)
    for number in range(40):
        angle = np.linspace(0.0, 6.0, 30) + number
        field.add(Element(ATTRACTOR, tuple(zip(3 * np.cos(angle), 3 * np.sin(angle), strict=True)), closed=True))
    field.add(Element(ATTRACTOR, ((1.0, 1.0),), fair=True))
    field.refresh(8.0, *_idle_inputs())
    view = StageView.allocate(0, 22)
    field.write_view(view)
    corners, first = view.element_corners[:41], view.element_first[:41]
    assert view.element_count == 41
    assert view.element_kind[:41].tolist() == [ATTRACTOR] * 40 + [PARTICIPANT]
    assert corners.tolist() == [31] * 33 + [0] * 8  # 33 * 31 = 1023
    for number in range(33):
        line = view.element_corner[first[number] : first[number] + 31]
        assert line[:30].tolist() == [list(point) for point in np.float32(field.elements[number].points)]
        assert line[30].tolist() == line[0].tolist()


def test_flow_grid_of_wrong_shape_is_refused():
    field = ElementField(1, half_width=6.0, half_depth=4.0)
    flow = Element(FLOW, ((0.0, 0.0),), flow_kind=GRID)
    for grid in (None, np.zeros((2, 2, 2), np.float32), np.full((24, 32, 2), np.nan, np.float32)):
        with pytest.raises(PersonError):
            field.add(flow, grid)
    assert field.add(flow, np.zeros((24, 32, 2), np.float32))


def test_ten_drawn_flows_share_eight_grids_by_eviction():
    stage = StageHarness([[0, 0]])
    for k in range(10):
        stage.field.add(Element(FLOW, ((0.0, 0.0), (1.0 + k, 1.0)), flow_kind=DRAWN, groups=1 << k))
    stage.groups[0] = 1
    assert (stage.wish() == 0.0).all()  # the oldest was evicted
    stage.groups[0] = 1 << 9
    assert stage.wish()[0] == pytest.approx(np.array([10.0, 1.0]) / np.hypot(10, 1), abs=0.02)
