"""Events as JSON: what is written of each kind is all that it holds, and reads back as it was."""

from dataclasses import asdict, fields

import pytest

from live.control.events.event_json import event_from_json, event_to_json
from live.control.events.events import EVENT_TYPES

VALUES = {"float": 0.1, "int": 3, "bool": True, "str": "ä word"}


@pytest.mark.parametrize("name", sorted(EVENT_TYPES))
def test_every_kind_is_written_whole_and_in_the_order_of_its_fields(name):
    cls = EVENT_TYPES[name]
    kinds = {field.name: getattr(field.type, "__name__", field.type) for field in fields(cls)}
    assert set(kinds.values()) <= set(VALUES)  # plain values alone: `asdict` would copy them one by one
    event = cls(**{field: VALUES[kind] for field, kind in kinds.items()})
    written = event_to_json(event)
    assert list(written.items()) == [("type", name), *asdict(event).items()]
    assert event_from_json(written) == event
