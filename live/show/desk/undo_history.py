"""Undo history for edits made by hand. Motion already danced is never undone.

An edit is an event from outside that changes lasting state (`EDITED_PARTS`): parameters, scenes, formations, sequences,
facings, ripples, the set, settings of captured performers, the standby cue. Each edit stores only the differing values
by key, so undo does not touch values that others changed since, except the same keys.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np
import numpy.typing as npt

from live.agents.crowd.obstacles import Surroundings
from live.base import picture_parameters
from live.base.errors import PersonError
from live.control.events import events
from live.control.events.event import ControlEvent
from live.control.events.events import SetPicture
from live.show.capture.stage_presence import OBSTACLE_PREFIX
from live.show.dancers.variation import Variation
from live.show.desk.cue_list import CueList
from live.show.desk.parameters import Parameters

if TYPE_CHECKING:
    from live.show.capture.capture_manager import CaptureManager
    from live.show.desk.scenes import Scenes
    from live.show.group.group_motion import GroupMotion
    from live.show.selection.scheduler import Scheduler
    from live.show.selection.step_targets import Headings


MAX_EDITS: Final = 200
"""Maximum number of edits kept; the oldest is dropped."""
MERGE_S: Final = 1.0
"""Events of one kind and source within this time [s] are one edit, such as a moving fader."""

EDITED_PARTS: Final[dict[type[ControlEvent], str]] = {
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
IGNORED_SOURCES: Final = ("music",)
"""Sources whose events are no edits: the music changes its values again by itself."""

_KEY_FIELDS: Final = ("parameter", "name", "performer")
"""Event fields that identify the edited thing; the first present one counts."""
_LABEL_FIELDS: Final = ("parameter", "name", "facing", "steps", "performer")
"""Event fields that describe an edit in words; the first non-empty one counts."""

Values = dict[Any, Any]
PartValues = Values | npt.NDArray[np.float64]
"""All values of a part by key; for an array, by place."""


class EditablePart(Protocol):
    """An editable part of the show, as values by key."""

    def snapshot(self) -> PartValues:
        """Return all present values; they are never modified afterwards."""
        ...

    def affected(self, event: ControlEvent) -> PartValues:
        """Return the values that this event can change: by default all."""
        return self.snapshot()

    def restore(self, values: Mapping[Any, Any]) -> None:
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
        edited = EDITED_PARTS.get(type(event)) if event.source not in IGNORED_SOURCES else None
        self._values_before = self._parts[edited].affected(event) if edited else None

    def end_edit(self, event: ControlEvent) -> None:
        """Record the edit after the event was applied."""
        before, self._values_before = self._values_before, None
        if before is None:
            return
        part = EDITED_PARTS[type(event)]
        after = self._parts[part].affected(event)
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
        self._parts[edit.part].restore(edit.before)

    def redo(self) -> None:
        """Repeat the last reverted edit; raises PersonError if there is none."""
        if not self._undone:
            raise PersonError("nothing was taken back")
        edit = self._undone.pop()
        self._done.append(edit)
        self._parts[edit.part].restore(edit.after)

    def facts(self) -> dict[str, Any]:
        """Return descriptions of the next undo and redo, and the number of edits, for the status."""
        return {
            "undo": self._done[-1].label if self._done else None,
            "redo": self._undone[-1].label if self._undone else None,
            "edits": len(self._done),
        }


class EditedParameters(EditablePart):
    """Value or fade target of each parameter, by place in the row."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters

    def snapshot(self) -> PartValues:
        """See `Part`."""
        return self._parameters.goals()

    def affected(self, event: ControlEvent) -> PartValues:
        """See `Part`. Picture events are frequent: only their own numbers are compared."""
        if type(event) is SetPicture:
            places = self._parameters.table.places(event.parameter, event.group)
            if places and max(places) < picture_parameters.ROW_SIZE:
                return self._parameters.goals_at(places)
        return self._parameters.goals()

    def restore(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        self._parameters.fade(values, beats=0.0)


class EditedScenes(EditablePart):
    """Scenes stored live, by name."""

    def __init__(self, scenes: "Scenes") -> None:
        self._scenes = scenes

    def snapshot(self) -> Values:
        """See `Part`."""
        return dict(self._scenes.stored)

    def restore(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for name, scene in values.items():
            if scene is None:
                self._scenes.stored.pop(name, None)
            else:
                self._scenes.stored[name] = scene


class EditedFormations(EditablePart):
    """Formations by name."""

    def __init__(self, motion: "GroupMotion") -> None:
        self._motion = motion

    def snapshot(self) -> Values:
        """See `Part`."""
        return self._motion.evolutions.formations

    def restore(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        self._motion.evolutions.restore(values)


class EditedSequences(EditablePart):
    """Sequences set live, by group."""

    def __init__(self, scheduler: "Scheduler") -> None:
        self._scheduler = scheduler

    def snapshot(self) -> Values:
        """See `Part`."""
        return {index: programme.live_sequence or None for index, programme in enumerate(self._scheduler.programmes)}

    def restore(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for index, wanted in values.items():
            if wanted is None:
                self._scheduler.programmes[index].release()
            else:
                self._scheduler.programmes[index].set_sequence(list(wanted))


class EditedFacings(EditablePart):
    """Facings of the groups."""

    def __init__(self, headings: "Headings") -> None:
        self._headings = headings

    def snapshot(self) -> Values:
        """See `Part`."""
        return dict(enumerate(self._headings.facings))

    def restore(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for group, facing in values.items():
            self._headings.set(group, facing)


class EditedRipples(EditablePart):
    """Ripples of the groups."""

    def __init__(self, variation: Variation) -> None:
        self._variation = variation

    def snapshot(self) -> Values:
        """See `Part`."""
        return dict(enumerate(self._variation.ripples))

    def restore(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for group, ripple in values.items():
            self._variation.ripples[group] = ripple


class EditedSet(EditablePart):
    """Walls and obstacles by kind and name, without real dancers."""

    def __init__(self, surroundings: Surroundings) -> None:
        self._surroundings = surroundings

    def snapshot(self) -> Values:
        """See `Part`."""
        around = self._surroundings
        walls = {("wall", name): _row(around.walls[row]) for row, name in enumerate(around.wall_names)}
        obstacles = {("obstacle", name): _row(around.obstacles[row]) for row, name in enumerate(around.obstacle_names)}
        return {key: row for key, row in {**walls, **obstacles}.items() if not key[1].startswith(OBSTACLE_PREFIX)}

    def restore(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        now = {**self.snapshot(), **values}
        for name in {name for _, name in values}:  # a wall and an obstacle may share a name, and `remove` removes both
            self._surroundings.remove(name)
            wall, obstacle = now.get(("wall", name)), now.get(("obstacle", name))
            if wall is not None:
                self._surroundings.set_wall(name, *wall)
            if obstacle is not None:
                self._surroundings.set_obstacle(name, *obstacle)


class CaptureEdits(EditablePart):
    """Settings of captured performers, by performer and control name."""

    def __init__(self, mocap: "CaptureManager") -> None:
        self._mocap = mocap

    def snapshot(self) -> Values:
        """See `Part`."""
        performers = self._mocap.performers.items()
        return {(name, what): now for name, captured in performers for what, now in captured.current_settings.items()}

    def restore(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for (name, what), said in values.items():
            self._mocap.restore_setting(name, what, said)


class EditedStandBy(EditablePart):
    """The standby cue."""

    def __init__(self, cues: CueList) -> None:
        self._cues = cues

    def snapshot(self) -> Values:
        """See `Part`."""
        return {"standby": self._cues.standby}

    def restore(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        self._cues.standby = values["standby"]


def _row(row: np.ndarray[Any, Any]) -> tuple[float, ...]:
    return tuple(row.tolist())


def editable_parts(
    parameters: Parameters, scenes: "Scenes", cues: CueList, motion: "GroupMotion", scheduler: "Scheduler",
    variation: Variation, mocap: "CaptureManager",
) -> dict[str, EditablePart]:  # fmt: skip
    """Return all editable parts of a show, by the names in `EDITED_PARTS`."""
    return {
        "parameters": EditedParameters(parameters),
        "scenes": EditedScenes(scenes),
        "formations": EditedFormations(motion),
        "sequences": EditedSequences(scheduler),
        "facings": EditedFacings(scheduler.targets.headings),
        "ripples": EditedRipples(variation),
        "set": EditedSet(motion.surroundings),
        "mocap": CaptureEdits(mocap),
        "standby": EditedStandBy(cues),
    }
