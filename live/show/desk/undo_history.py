"""Undo history for edits made by hand. Motion already danced is never undone.

An edit is an event from outside that changes lasting state (`EDITED`): parameters, scenes, formations, sequences,
facings, ripples, the set, settings of captured performers, the standby cue. Each edit stores only the differing values
by key, so undo does not touch values that others changed since, except the same keys.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, Final, Protocol

import numpy as np
import numpy.typing as npt

from live.agents.crowd.obstacles import Surroundings
from live.base import picture_parameters
from live.base.errors import PersonError
from live.control.events import events
from live.control.events.event import ControlEvent
from live.control.events.events import SetPicture
from live.show.capture.capture_manager import Mocap
from live.show.capture.stage_presence import PERFORMER
from live.show.dancers.variation import Variation
from live.show.desk.cue_list import Cues
from live.show.desk.parameters import Parameters
from live.show.desk.scenes import Scenes
from live.show.group.group_motion import GroupMotion
from live.show.selection.scheduler import Scheduler
from live.show.selection.step_targets import Headings

MOST: Final = 200
"""Maximum number of edits kept; the oldest is dropped."""
TOGETHER: Final = 1.0
"""Events of one kind and source within this time [s] are one edit, such as a moving fader."""

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
"""Sources whose events are no edits: the music changes its values again by itself."""

_WHAT: Final = ("parameter", "name", "performer")
"""Event fields that identify the edited thing; the first present one counts."""
_SAID: Final = ("parameter", "name", "facing", "steps", "performer")
"""Event fields that describe an edit in words; the first non-empty one counts."""

Kept = dict[Any, Any]
Now = Kept | npt.NDArray[np.float64]
"""All values of a part by key; for an array, by place."""


class Part(Protocol):
    """An editable part of the show, as values by key."""

    def take(self) -> Now:
        """Return all present values; they are never modified afterwards."""
        ...

    def concerned(self, event: ControlEvent) -> Now:
        """Return the values that this event can change: by default all."""
        return self.take()

    def give(self, values: Mapping[Any, Any]) -> None:
        """Restore these values; None removes the key."""
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
    """Return which of these fields events of a kind have."""
    known = {field.name for field in fields(events.EVENT_TYPES[kind])}
    return tuple(name for name in wanted if name in known)


def _words(event: ControlEvent) -> str:
    """Return a short description of an edit, for the operator."""
    what = type(event).__name__
    for name in _has(what, _SAID):
        value = getattr(event, name)
        if value:
            return f"{what} {str(value)[:40]}"
    return what


def _differences(before: Now, after: Now) -> tuple[Kept, Kept]:
    """Return old and new values of the keys that differ."""
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
        """Record the state before an event from outside is applied."""
        edited = EDITED.get(type(event)) if event.source not in NEVER else None
        self._before = self._parts[edited].concerned(event) if edited else None

    def after(self, event: ControlEvent) -> None:
        """Record the edit after the event was applied."""
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
        """Revert the last edit; raises PersonError if there is none."""
        if not self._done:
            raise PersonError("nothing to take back")
        edit = self._done.pop()
        self._undone.append(edit)
        self._parts[edit.part].give(edit.before)

    def redo(self) -> None:
        """Repeat the last reverted edit; raises PersonError if there is none."""
        if not self._undone:
            raise PersonError("nothing was taken back")
        edit = self._undone.pop()
        self._done.append(edit)
        self._parts[edit.part].give(edit.after)

    def facts(self) -> dict[str, Any]:
        """Return descriptions of the next undo and redo, and the number of edits, for the status."""
        return {
            "undo": self._done[-1].words if self._done else None,
            "redo": self._undone[-1].words if self._undone else None,
            "edits": len(self._done),
        }


class EditedParameters(Part):
    """Value or fade target of each parameter, by place in the row."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters

    def take(self) -> Now:
        """See `Part`."""
        return self._parameters.goals()

    def concerned(self, event: ControlEvent) -> Now:
        """See `Part`. Picture events are frequent: only their own numbers are compared."""
        if type(event) is SetPicture:
            places = self._parameters.table.places(event.parameter, event.group)
            if places and max(places) < picture_parameters.SIZE:
                return self._parameters.goals_at(places)
        return self._parameters.goals()

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        self._parameters.fade(values, beats=0.0)


class EditedScenes(Part):
    """Scenes stored live, by name."""

    def __init__(self, scenes: Scenes) -> None:
        self._scenes = scenes

    def take(self) -> Kept:
        """See `Part`."""
        return dict(self._scenes.stored)

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for name, scene in values.items():
            if scene is None:
                self._scenes.stored.pop(name, None)
            else:
                self._scenes.stored[name] = scene


class EditedFormations(Part):
    """Formations by name."""

    def __init__(self, motion: GroupMotion) -> None:
        self._motion = motion

    def take(self) -> Kept:
        """See `Part`."""
        return self._motion.evolutions.formations

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        self._motion.evolutions.restore(values)


class EditedSequences(Part):
    """Sequences set live, by group."""

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler

    def take(self) -> Kept:
        """See `Part`."""
        return {index: programme.live or None for index, programme in enumerate(self._scheduler.programmes)}

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for index, wanted in values.items():
            if wanted is None:
                self._scheduler.programmes[index].release()
            else:
                self._scheduler.programmes[index].dance(list(wanted))


class EditedFacings(Part):
    """Facings of the groups."""

    def __init__(self, headings: Headings) -> None:
        self._headings = headings

    def take(self) -> Kept:
        """See `Part`."""
        return dict(enumerate(self._headings.facings))

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for group, facing in values.items():
            self._headings.set(group, facing)


class EditedRipples(Part):
    """Ripples of the groups."""

    def __init__(self, variation: Variation) -> None:
        self._variation = variation

    def take(self) -> Kept:
        """See `Part`."""
        return dict(enumerate(self._variation.ripples))

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for group, ripple in values.items():
            self._variation.ripples[group] = ripple


class EditedSet(Part):
    """Walls and obstacles by kind and name, without real dancers."""

    def __init__(self, surroundings: Surroundings) -> None:
        self._surroundings = surroundings

    def take(self) -> Kept:
        """See `Part`."""
        around = self._surroundings
        walls = {("wall", name): _row(around.walls[row]) for row, name in enumerate(around.wall_names)}
        obstacles = {("obstacle", name): _row(around.obstacles[row]) for row, name in enumerate(around.obstacle_names)}
        return {key: row for key, row in {**walls, **obstacles}.items() if not key[1].startswith(PERFORMER)}

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        now = {**self.take(), **values}
        for name in {name for _, name in values}:  # a wall and an obstacle may share a name, and `remove` removes both
            self._surroundings.remove(name)
            wall, obstacle = now.get(("wall", name)), now.get(("obstacle", name))
            if wall is not None:
                self._surroundings.put_wall(name, *wall)
            if obstacle is not None:
                self._surroundings.put_obstacle(name, *obstacle)


class EditedMocap(Part):
    """Settings of captured performers, by performer and control name."""

    def __init__(self, mocap: Mocap) -> None:
        self._mocap = mocap

    def take(self) -> Kept:
        """See `Part`."""
        performers = self._mocap.performers.items()
        return {(name, what): now for name, captured in performers for what, now in captured.said.items()}

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for (name, what), said in values.items():
            self._mocap.say(name, what, said)


class EditedStandBy(Part):
    """The standby cue."""

    def __init__(self, cues: Cues) -> None:
        self._cues = cues

    def take(self) -> Kept:
        """See `Part`."""
        return {"standby": self._cues.standby}

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        self._cues.standby = values["standby"]


def _row(row: np.ndarray[Any, Any]) -> tuple[float, ...]:
    return tuple(row.tolist())


def parts_of(
    parameters: Parameters, scenes: Scenes, cues: Cues, motion: GroupMotion, scheduler: Scheduler,
    variation: Variation, mocap: Mocap,
) -> dict[str, Part]:  # fmt: skip
    """Return all editable parts of a show, by the names in `EDITED`."""
    return {
        "parameters": EditedParameters(parameters),
        "scenes": EditedScenes(scenes),
        "formations": EditedFormations(motion),
        "sequences": EditedSequences(scheduler),
        "facings": EditedFacings(scheduler.aims.headings),
        "ripples": EditedRipples(variation),
        "set": EditedSet(motion.surroundings),
        "mocap": EditedMocap(mocap),
        "standby": EditedStandBy(cues),
    }
