"""Undo history for edits made by hand. Motion already danced is never undone.

An edit is an event from outside that changes lasting state (`ControlEvent.edits`): parameters, scenes, formations,
sequences, facings, ripples, the set, settings of captured performers, the standby cue, launches. Each edit stores only
the differing values by key, so undo does not touch values that others changed since, except the same keys.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, Final, Protocol

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.control.events import events
from live.control.events.event import ControlEvent

MAX_EDITS: Final = 200
"""Maximum number of edits kept; the oldest is dropped."""
MERGE_S: Final = 1.0
"""Events of one kind and source within this time [s] are one edit, such as a moving fader."""

IGNORED_SOURCES: Final = ("music",)
"""Sources whose events are no edits: the music changes its values again by itself."""

_KEY_FIELDS: Final = ("address", "parameter", "name", "performer", "pad")
"""Event fields that identify the edited thing; the first present one counts."""
_LABEL_FIELDS: Final = ("address", "parameter", "name", "facing", "steps", "performer", "pad")
"""Event fields that describe an edit in words; the first non-empty one counts."""

Values = dict[Any, Any]
PartValues = Values | npt.NDArray[np.float64]
"""All values of a part by key; for an array, by place."""


class EditablePart(Protocol):
    """A part of the show whose values, by key, can be edited. Each part offers them itself."""

    def edited_values(self, event: ControlEvent) -> PartValues:
        """Return at least the values that this event can change; they are never modified afterwards."""
        ...

    def restore_values(self, values: Mapping[Any, Any]) -> None:
        """Restore these values; None removes the key."""
        ...


@dataclass(frozen=True, slots=True)
class _Edit:
    label: str
    part: str
    before: Values
    after: Values
    key: tuple[str, ...]
    time: float


@cache
def _present_fields(kind: str, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return which of these fields events of a kind have."""
    known = {field.name for field in fields(events.EVENT_TYPES[kind])}
    return tuple(name for name in names if name in known)


def _edit_label(event: ControlEvent) -> str:
    """Return a short description of an edit, for the operator."""
    what = type(event).__name__
    for name in _present_fields(what, _LABEL_FIELDS):
        value = getattr(event, name)
        if value:
            return f"{what} {str(value)[:40]}"
    return what


def _differences(before: PartValues, after: PartValues) -> tuple[Values, Values]:
    """Return old and new values of the keys that differ."""
    if isinstance(before, dict) and isinstance(after, dict):
        if before == after:
            return {}, {}
        keys: Any = [key for key in before.keys() | after.keys() if before.get(key) != after.get(key)]
        return {key: before.get(key) for key in keys}, {key: after.get(key) for key in keys}
    if isinstance(before, dict) or isinstance(after, dict):  # places have become keys in between, or the other way
        return _differences(
            *(one if isinstance(one, dict) else dict(enumerate(one.tolist())) for one in (before, after))
        )
    was, now = np.asarray(before), np.asarray(after)
    keys = (was != now).nonzero()[0].tolist()
    return dict(zip(keys, was[keys].tolist(), strict=True)), dict(zip(keys, now[keys].tolist(), strict=True))


class UndoHistory:
    """The edits of one show. Thread: the show's."""

    def __init__(self, parts: Mapping[str, EditablePart]) -> None:
        self._parts = dict(parts)
        self._done: deque[_Edit] = deque(maxlen=MAX_EDITS)
        self._undone: list[_Edit] = []
        self._values_before: PartValues | None = None

    def begin_edit(self, event: ControlEvent) -> None:
        """Record the state before an event from outside is applied."""
        edited = event.edits if event.source not in IGNORED_SOURCES else ""
        self._values_before = self._parts[edited].edited_values(event) if edited else None

    def end_edit(self, event: ControlEvent) -> None:
        """Record the edit after the event was applied."""
        before, self._values_before = self._values_before, None
        if before is None:
            return
        part = event.edits
        after = self._parts[part].edited_values(event)
        old, new = _differences(before, after)
        if not old:
            return
        named = _present_fields(type(event).__name__, _KEY_FIELDS)
        name = str(getattr(event, named[0])) if named else ""
        key = (type(event).__name__, event.source, name, str(getattr(event, "group", "")))
        last = self._done[-1] if self._done else None
        if last is not None and last.key == key and not self._undone and 0.0 <= event.time - last.time < MERGE_S:
            self._done.pop()
            old, new = {**old, **last.before}, {**last.after, **new}
        self._done.append(_Edit(_edit_label(event), part, old, new, key, event.time))
        self._undone.clear()

    def undo(self) -> None:
        """Revert the last edit; raises PersonError if there is none."""
        if not self._done:
            raise PersonError("nothing to take back")
        edit = self._done.pop()
        self._undone.append(edit)
        self._parts[edit.part].restore_values(edit.before)

    def redo(self) -> None:
        """Repeat the last reverted edit; raises PersonError if there is none."""
        if not self._undone:
            raise PersonError("nothing was taken back")
        edit = self._undone.pop()
        self._done.append(edit)
        self._parts[edit.part].restore_values(edit.after)

    def facts(self) -> dict[str, Any]:
        """Return descriptions of the next undo and redo, and the number of edits, for the status."""
        return {
            "undo": self._done[-1].label if self._done else None,
            "redo": self._undone[-1].label if self._undone else None,
            "edits": len(self._done),
        }
