"""Edits: what was changed by hand can be taken back and made again; what has been played never is.

An edit is an event from outside that changes what is kept (`EDITED`): parameters, scenes, formations, sequences,
facings, ripples, the set, what is said of captured performers, the cue that stands by. Kept is what differs, by its
key: taking an edit back touches nothing that anybody else has changed since, but for the same thing.
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
from live.control.events.events import ControlEvent

MOST: Final = 200
"""Edits that are kept; the oldest is forgotten."""
TOGETHER: Final = 1.0
"""Events of one kind and source within so many seconds are one edit: a fader that moves."""

EDITED: Final[dict[type[ControlEvent], str]] = {
    events.SetPass: "parameters",
    events.SetPicture: "parameters",
    events.SetMotion: "parameters",
    events.RecallView: "parameters",
    events.Accompany: "parameters",
    events.ShowBackground: "parameters",
    events.RecallLook: "parameters",
    events.RecallScene: "parameters",
    events.StoreScene: "scenes",
    events.DefineFormation: "formations",
    events.SetSequence: "sequences",
    events.SetFacing: "facings",
    events.SetRipple: "ripples",
    events.PlaceObstacle: "set",
    events.PlaceWall: "set",
    events.RemoveObstacle: "set",
    events.CastMocap: "mocap",
    events.ShowMocap: "mocap",
    events.MirrorMocap: "mocap",
    events.PlaceMocap: "mocap",
    events.CanonMocap: "mocap",
    events.BlockMocap: "mocap",
    events.DrawMocap: "mocap",
    events.StandBy: "standby",
    events.StepBack: "standby",
}
"""The part of the show that each kind of edit changes."""
NEVER: Final = ("music",)
"""Sources whose events are no edits: what the music changes it changes again."""

_WHAT: Final = ("parameter", "name", "performer")
"""What of an event says what it changes, whichever it has."""
_SAID: Final = ("parameter", "name", "facing", "steps", "performer")
"""What of an event says in words what it changes, whichever it has and is not empty."""

Kept = dict[Any, Any]
Now = Kept | npt.NDArray[np.float64]
"""All values of a part by key; those of an array by their places."""


class Part(Protocol):
    """A part of the show that can be edited, as values by key."""

    def take(self) -> Now:
        """All its values now; they are never changed afterwards."""
        ...

    def concerned(self, event: ControlEvent) -> Now:
        """Those of them that this event can change: all, unless a part knows better."""
        return self.take()

    def give(self, values: Mapping[Any, Any]) -> None:
        """Bring these back; None: there shall be nothing of this key."""
        ...


@dataclass(frozen=True, slots=True)
class _Edit:
    words: str
    part: str
    before: Kept
    after: Kept
    key: tuple[str, ...]
    time: float


@cache
def _has(kind: str, wanted: tuple[str, ...]) -> tuple[str, ...]:
    """Which of these fields events of a kind have."""
    known = {field.name for field in fields(events.EVENT_TYPES[kind])}
    return tuple(name for name in wanted if name in known)


def _words(event: ControlEvent) -> str:
    """An edit in a few words, for the operator."""
    what = type(event).__name__
    for name in _has(what, _SAID):
        value = getattr(event, name)
        if value:
            return f"{what} {str(value)[:40]}"
    return what


def _differences(before: Now, after: Now) -> tuple[Kept, Kept]:
    """What was and what is, of the keys whose values differ."""
    if isinstance(before, dict) and isinstance(after, dict):
        if before == after:
            return {}, {}
        keys: Any = [key for key in before.keys() | after.keys() if before.get(key) != after.get(key)]
        return {key: before.get(key) for key in keys}, {key: after.get(key) for key in keys}
    was, now = np.asarray(before), np.asarray(after)
    keys = (was != now).nonzero()[0].tolist()
    return dict(zip(keys, was[keys].tolist(), strict=True)), dict(zip(keys, now[keys].tolist(), strict=True))


class Edits:
    """The edits of one show. Thread: the show's."""

    def __init__(self, parts: Mapping[str, Part]) -> None:
        self._parts = dict(parts)
        self._done: deque[_Edit] = deque(maxlen=MOST)
        self._undone: list[_Edit] = []
        self._before: Now | None = None

    def before(self, event: ControlEvent) -> None:
        """An event from outside is about to act."""
        edited = EDITED.get(type(event)) if event.source not in NEVER else None
        self._before = self._parts[edited].concerned(event) if edited else None

    def after(self, event: ControlEvent) -> None:
        """It has acted."""
        before, self._before = self._before, None
        if before is None:
            return
        part = EDITED[type(event)]
        after = self._parts[part].concerned(event)
        old, new = _differences(before, after)
        if not old:
            return
        named = _has(type(event).__name__, _WHAT)
        name = str(getattr(event, named[0])) if named else ""
        key = (type(event).__name__, event.source, name, str(getattr(event, "group", "")))
        last = self._done[-1] if self._done else None
        if last is not None and last.key == key and not self._undone and 0.0 <= event.time - last.time < TOGETHER:
            self._done.pop()
            old, new = {**old, **last.before}, {**last.after, **new}
        self._done.append(_Edit(_words(event), part, old, new, key, event.time))
        self._undone.clear()

    def undo(self) -> None:
        """Take the last edit back; PersonError if there is none."""
        if not self._done:
            raise PersonError("nothing to take back")
        edit = self._done.pop()
        self._undone.append(edit)
        self._parts[edit.part].give(edit.before)

    def redo(self) -> None:
        """Make the last edit again that was taken back; PersonError if there is none."""
        if not self._undone:
            raise PersonError("nothing was taken back")
        edit = self._undone.pop()
        self._done.append(edit)
        self._parts[edit.part].give(edit.after)

    def facts(self) -> dict[str, Any]:
        """For the status: what undo and redo would do, in words, and how many edits are kept."""
        return {
            "undo": self._done[-1].words if self._done else None,
            "redo": self._undone[-1].words if self._undone else None,
            "edits": len(self._done),
        }
