"""Tests of elements from patch sections and control events."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base.element_kinds import EVERYBODY, FLOW_NAMES, KIND_NAMES, PARTICIPANT
from live.control.events import events
from live.control.registry.control import parse_points
from live.show.group.elements import element_of_section, make_element
from live.show.patch.section_elements import ElementSection

STAMP = {"time": 0.0, "source": "test"}


def element(event):
    return make_element(event, groups=EVERYBODY, target_group=-1, start=8.0, beats_per_measure=4)


def test_points_are_parsed_and_invalid_text_is_refused():
    assert parse_points("-3 0, 0 -2.5; 3 0") == ((-3.0, 0.0), (0.0, -2.5), (3.0, 0.0))
    for text in ("", "1", "1 2 3", "1 2,", "a b", "nan 0", "1e999 0"):
        with pytest.raises(ValueError, match=r"points|float"):
            parse_points(text)


@pytest.mark.long
@given(st.text(max_size=40))
def test_arbitrary_text_is_parsed_or_refused(text):
    with contextlib.suppress(ValueError):
        assert len(parse_points(text)) >= 1


def test_measures_are_converted_to_beats():
    made = element(events.PlaceElement(kind="attract", points=((1.0, 2.0),), strength=3.0, measures=2.5, **STAMP))
    assert (made.kind, made.points, made.strength) == (KIND_NAMES["attract"], ((1.0, 2.0),), 3.0)
    assert (made.start_beat, made.end_beat) == (8.0, 18.0)


def test_voice_creates_participant_element():
    assert (
        element(
            events.PlaceElement(kind="attract", points=((1.0, 2.0),), measures=2.0, fair=True, drag=True, **STAMP)
        ).table_kind
        == PARTICIPANT
    )


@pytest.mark.parametrize("kind", KIND_NAMES)
def test_each_element_kind_works_in_patch_and_event(kind):
    whom = "3" if kind in ("follow", "pursue", "evade") else ""
    section = ElementSection(kind=kind, measure=1, at=(0.0, -1.0), to=(0.0, 1.0), points=((0, 0), (1, 1)), whom=whom)
    sent = events.PlaceElement(kind=kind, points=((0.0, 0.0), (1.0, 1.0)), whom=whom, **STAMP)
    for placing in (element_of_section(section), sent):
        made = element(placing)
        assert made.kind == KIND_NAMES[kind]
        assert made.target == (2 if whom else -1)


@pytest.mark.parametrize("flow", ["uniform", "radial", "vortex", "drawn"])
def test_flow_event_sets_flow_kind(flow):
    sent = events.PlaceElement(kind="flow", flow=flow, points=((0.0, 0.0), (1.0, 1.0)), **STAMP)
    assert element(sent).flow_kind == FLOW_NAMES[flow]


@pytest.mark.parametrize(
    "values",
    [
        {"kind": "cross"},
        {"kind": "flow"},
        {"kind": "flow", "flow": "drawn", "to": (1, 1)},
        {"kind": "path", "to": (1, 1)},
        {"kind": "follow"},
        {"kind": "attract", "strength": -1},
        {"kind": "storm"},
    ],
)
def test_incomplete_or_invalid_sections_are_refused(values):
    with pytest.raises(ValueError, match=r"needs|below 0|Input"):
        ElementSection(measure=1, **values)
