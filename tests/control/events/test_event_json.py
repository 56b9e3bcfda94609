"""Tests of events as JSON: all fields of each kind are written and read back unchanged."""

import json
from dataclasses import asdict, fields
from typing import get_type_hints

import pytest

from live.control.events.audience import VoiceLight, VoicePlace
from live.control.events.event_json import event_from_json, event_to_json
from live.control.events.events import EVENT_TYPES

VALUES = {float: 0.1, int: 3, bool: True, str: "ä word", tuple[float, ...]: (0.5, -1.0)}
VALUES |= {
    tuple[tuple[float, float], ...]: ((0.5, -1.0), (2.0, 0.25)),
    tuple[VoicePlace, ...] | None: ((1, -2, 3, 1),),
    tuple[VoiceLight, ...] | None: (),
    tuple[int, ...] | None: None,
}


@pytest.mark.parametrize("name", sorted(EVENT_TYPES))
def test_every_event_kind_round_trips_in_field_order(name):
    cls = EVENT_TYPES[name]
    kinds = get_type_hints(cls)
    event = cls(**{field.name: VALUES[kinds[field.name]] for field in fields(cls)})
    written = event_to_json(event)
    assert list(written.items()) == [("type", name), *asdict(event).items()]
    assert event_from_json(json.loads(json.dumps(written))) == event
