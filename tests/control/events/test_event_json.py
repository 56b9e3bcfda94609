"""Tests of events as JSON: all fields of each kind are written and read back unchanged."""

from dataclasses import asdict, fields

import pytest

from live.control.events.event_json import event_from_json, event_to_json
from live.control.events.events import EVENT_TYPES

VALUES = {"float": 0.1, "int": 3, "bool": True, "str": "ä word"}


@pytest.mark.parametrize("name", sorted(EVENT_TYPES))
def test_every_event_kind_round_trips_in_field_order(name):
    cls = EVENT_TYPES[name]
    kinds = {field.name: getattr(field.type, "__name__", field.type) for field in fields(cls)}
    assert set(kinds.values()) <= set(VALUES)  # plain values alone: `asdict` would copy them one by one
    event = cls(**{field: VALUES[kind] for field, kind in kinds.items()})
    written = event_to_json(event)
    assert list(written.items()) == [("type", name), *asdict(event).items()]
    assert event_from_json(written) == event
