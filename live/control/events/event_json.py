"""JSON encoding of events for journals, as objects or compact rows, and for packets between processes."""

import math
from collections.abc import Callable
from dataclasses import fields
from functools import cache
from typing import Any, get_args, get_type_hints

from live.control.events.events import (
    EVENT_TYPES,
    AudienceHeard,
    BeatHeard,
    ControlEvent,
    MocapFrame,
    MusicHeard,
    NotesHeard,
    Performer,
    PlaceObstacle,
    TrackerMoved,
)
from live.control.message_codec import register_as


def event_to_json(event: ControlEvent) -> dict[str, Any]:
    """Return the event as a JSON object; floats keep every bit (Python writes the shortest exact form)."""
    name = type(event).__name__  # fields are values that nothing changes: no copy by `asdict` is needed
    return {"type": name, **{field: getattr(event, field) for field in field_types(name)}}


IN_ROWS: tuple[type[ControlEvent], ...] = (
    BeatHeard, MusicHeard, NotesHeard, MocapFrame, TrackerMoved, Performer, PlaceObstacle, AudienceHeard,
)  # fmt: skip
"""Frequent events, which the journal stores as rows: [type, value, ...] in the order of their fields."""


def is_finite(event: ControlEvent) -> bool:
    """Whether every float in the event is finite."""
    values = (getattr(event, field.name) for field in fields(event))
    return all(math.isfinite(value) for value in values if type(value) is float)


def event_to_row(event: ControlEvent) -> list[Any]:
    """Return the event as a row: its type and its values, without trailing defaults."""
    values = [getattr(event, field.name) for field in fields(event)]
    for field in reversed(fields(event)):
        if values[-1] != field.default:
            break
        values.pop()
    return [type(event).__name__, *values]


def columns_of(kind: type[ControlEvent]) -> list[str]:
    """Return the field names of a row's values, in order."""
    return list(field_types(kind.__name__))


def event_from_json(data: dict[str, Any] | list[Any], columns: dict[str, list[str]] | None = None) -> ControlEvent:
    """Decode the result of `event_to_json` or `event_to_row`; ValueError for an unknown type or field or a wrong value.

    `columns`: field names of rows by type; None: the fields in order.
    """
    values = dict(data) if not isinstance(data, list) else _values_of(data, columns or {})
    name = values.pop("type", None)
    cls = EVENT_TYPES.get(name) if isinstance(name, str) else None
    if cls is None:
        raise ValueError(f"unknown event type {name!r}; known are {', '.join(sorted(EVENT_TYPES))}")
    kinds = field_types(cls.__name__)
    for key, value in values.items():
        if not _fits(value, kinds.get(key)):
            raise ValueError(f"event {name}: field {key!r} cannot be {value!r:.80}")
        if isinstance(value, list):
            values[key] = _tuples(value)
    try:
        return cls(**values)
    except TypeError as error:
        raise ValueError(f"event {name}: {error}") from None


def _tuples(value: Any) -> Any:
    """Return a list as a tuple, with the lists in it."""
    return tuple([_tuples(each) for each in value]) if isinstance(value, list) else value


def _fits(value: Any, kind: Any) -> bool:
    """Whether a value is of a field's type; a number may be written as a whole number."""
    inside = get_args(kind)
    if type(None) in inside:
        return value is None or _fits(value, inside[0])
    if inside:
        one, more = inside[0], inside[1:]
        if not isinstance(value, list | tuple) or (more != (...,) and len(value) != len(inside)):
            return False
        return all(_fits(each, one) for each in value)
    if kind is float or kind is int:
        whole = isinstance(value, int) and not isinstance(value, bool)
        return (whole or (kind is float and isinstance(value, float))) and _is_small(value)
    return (kind is bool or kind is str) and isinstance(value, kind)


def _is_small(value: float) -> bool:
    """Whether a number is usable: a finite float or a 64-bit integer."""
    return math.isfinite(value) if isinstance(value, float) else -(1 << 63) <= value < 1 << 63


def _values_of(row: list[Any], columns: dict[str, list[str]]) -> dict[str, Any]:
    name = row[0] if row else None
    cls = EVENT_TYPES.get(name) if isinstance(name, str) else None
    names = [] if cls is None else columns.get(cls.__name__) or columns_of(cls)
    if len(row) - 1 > len(names) and cls is not None:
        raise ValueError(f"event {name}: {len(row) - 1} values, {len(names)} expected")
    return {"type": name, **dict(zip(names, row[1:], strict=False))}


def _made(name: str) -> Callable[[tuple[Any, ...]], ControlEvent]:
    return lambda values: event_from_json([name, *values])


def register_events() -> None:
    """Register all events for packets; they are checked like those of a journal."""
    for name, cls in EVENT_TYPES.items():
        register_as(name, cls, _made(name))


@cache
def field_types(name: str) -> dict[str, Any]:
    """Return the fields of an event type, by its name, with their types, in order."""
    hints = get_type_hints(EVENT_TYPES[name])
    return {field.name: hints[field.name] for field in fields(EVENT_TYPES[name])}
