"""Events as JSON, as journals have them: objects, or rows where they come by the thousand; and in packets."""

import math
from collections.abc import Callable
from dataclasses import fields
from functools import cache
from typing import Any

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
    """The event as a JSON object; floats keep every bit (Python writes the shortest form that reads back equal)."""
    name = type(event).__name__  # all fields are numbers and words: nothing that `asdict` would have to copy
    return {"type": name, **{field: getattr(event, field) for field in _kinds(name)}}


IN_ROWS: tuple[type[ControlEvent], ...] = (
    BeatHeard, MusicHeard, NotesHeard, MocapFrame, TrackerMoved, Performer, PlaceObstacle, AudienceHeard,
)  # fmt: skip
"""Events that come by the thousand: the journal has them as rows, [type, value, ...] in the order of their fields."""


def is_finite(event: ControlEvent) -> bool:
    """Whether every number in the event is one."""
    values = (getattr(event, field.name) for field in fields(event))
    return all(math.isfinite(value) for value in values if type(value) is float)


def event_to_row(event: ControlEvent) -> list[Any]:
    """The event as a row: its type, and its values without the last ones that are as usual."""
    values = [getattr(event, field.name) for field in fields(event)]
    for field in reversed(fields(event)):
        if values[-1] != field.default:
            break
        values.pop()
    return [type(event).__name__, *values]


def columns_of(kind: type[ControlEvent]) -> list[str]:
    """What the values of a row are, in their order."""
    return [field.name for field in fields(kind)]


def event_from_json(data: dict[str, Any] | list[Any], columns: dict[str, list[str]] | None = None) -> ControlEvent:
    """The event that `event_to_json` or `event_to_row` wrote; ValueError for an unknown type, field or a wrong value.

    `columns`: what the values of rows are, by type; where left out, the fields in their order.
    """
    values = dict(data) if not isinstance(data, list) else _values_of(data, columns or {})
    name = values.pop("type", None)
    cls = EVENT_TYPES.get(name) if isinstance(name, str) else None
    if cls is None:
        raise ValueError(f"unknown event type {name!r}; known are {', '.join(sorted(EVENT_TYPES))}")
    kinds = _kinds(cls.__name__)
    for key, value in values.items():
        kind = kinds.get(key)
        good = (
            (kind is float and isinstance(value, int | float) and not isinstance(value, bool) and _is_small(value))
            or (kind is bool and isinstance(value, bool))
            or (kind is int and isinstance(value, int) and not isinstance(value, bool) and _is_small(value))
            or (kind is str and isinstance(value, str))
        )
        if not good:
            raise ValueError(f"event {name}: field {key!r} cannot be {value!r:.80}")
    try:
        return cls(**values)
    except TypeError as error:
        raise ValueError(f"event {name}: {error}") from None


def _is_small(value: float) -> bool:
    """Whether a number can be counted with: a float that is one, a whole number of 64 bits."""
    return math.isfinite(value) if isinstance(value, float) else -(1 << 63) <= value < 1 << 63


def _values_of(row: list[Any], columns: dict[str, list[str]]) -> dict[str, Any]:
    name = row[0] if row else None
    cls = EVENT_TYPES.get(name) if isinstance(name, str) else None
    names = [] if cls is None else columns.get(cls.__name__) or list(_kinds(cls.__name__))
    if len(row) - 1 > len(names) and cls is not None:
        raise ValueError(f"event {name}: {len(row) - 1} values, {len(names)} expected")
    return {"type": name, **dict(zip(names, row[1:], strict=False))}


def _made(name: str) -> Callable[[tuple[Any, ...]], ControlEvent]:
    return lambda values: event_from_json([name, *values])


def register_events() -> None:
    """Let events be in packets; they are checked as those of a journal."""
    for name, cls in EVENT_TYPES.items():
        register_as(name, cls, _made(name))


@cache
def _kinds(name: str) -> dict[str, Any]:
    """The fields of an event's type, in their order, and what they hold."""
    return {field.name: field.type for field in fields(EVENT_TYPES[name])}
