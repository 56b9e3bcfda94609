"""Events: everything that may change a show, as frozen values stamped with time and source.

The journal of a show is its patch, its seed and these, each with the tick at which it was applied.
"""

import math
from dataclasses import asdict, dataclass, fields
from functools import cache
from typing import Any

from live.control.audio_events import ChooseAudio, MusicHeard, RestartAudio, SetClick, SetLatency
from live.control.clock_events import (
    ChooseSource,
    CountIn,
    HoldTempo,
    Nudge,
    One,
    ScaleTempo,
    SetMetre,
    SetTempo,
    ShiftBeats,
    Tap,
)
from live.control.cue_events import GiveCue, Go, HoldShow, Panic, Redo, StandBy, StepBack, Undo
from live.control.element_events import Attract, PlaceElement, Repel, Spread, Voice
from live.control.event import ControlEvent
from live.control.group_events import (
    DefineFormation,
    Enter,
    Evolve,
    Leave,
    Pause,
    Performer,
    PlaceObstacle,
    PlaceWall,
    Regroup,
    Release,
    RemoveObstacle,
    SetRipple,
    SetStage,
    Travel,
)
from live.control.machine_events import TakeOver
from live.control.patch_events import PatchChanged, StepsChanged
from live.control.scene_events import RecallLook, RecallScene, RecallView, SetPicture, StoreScene
from live.control.score_events import Advance, HoldScore, Improvise, JumpTo, Practice, Signal

__all__ = [
    "EVENT_TYPES",
    "Advance",
    "AskWhy",
    "Attract",
    "BeatHeard",
    "Blackout",
    "CallStep",
    "ChooseAudio",
    "ChooseSource",
    "Clear",
    "ControlEvent",
    "CountIn",
    "DefineFormation",
    "Enter",
    "Evolve",
    "GiveCue",
    "Go",
    "HoldScore",
    "HoldShow",
    "HoldTempo",
    "Improvise",
    "JumpTo",
    "Leave",
    "MusicHeard",
    "Nudge",
    "One",
    "Panic",
    "PatchChanged",
    "Pause",
    "Performer",
    "PlaceElement",
    "PlaceObstacle",
    "PlaceWall",
    "Practice",
    "RecallLook",
    "RecallScene",
    "RecallView",
    "Redo",
    "Regroup",
    "Release",
    "RemoveObstacle",
    "Repel",
    "RestartAudio",
    "ScaleTempo",
    "SetClick",
    "SetFacing",
    "SetLatency",
    "SetMetre",
    "SetMotion",
    "SetPicture",
    "SetRipple",
    "SetSequence",
    "SetStage",
    "SetTempo",
    "ShiftBeats",
    "Signal",
    "SourceChanged",
    "Spread",
    "StandBy",
    "StepBack",
    "StepNow",
    "StepsAdded",
    "StepsChanged",
    "StoreScene",
    "TakeOver",
    "Tap",
    "TicksSkipped",
    "Travel",
    "Undo",
    "Voice",
    "columns_of",
    "event_from_json",
    "event_to_json",
    "event_to_row",
    "is_finite",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Clear(ControlEvent):
    """All attractors, repulsors and spreaders end, and the patch chooses the steps again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CallStep(ControlEvent):
    """Dancers dance this step from the next free measure on, for a number of measures."""

    name: str
    measures: float = 4.0
    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class StepNow(ControlEvent):
    """Dancers leave what they dance for this step at the next half beat, within the measure."""

    name: str
    group: str = "*"
    measures: float = 1.0
    """How many whole measures they stay in it after the one that runs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetSequence(ControlEvent):
    """Dancers dance these steps in order, again and again, instead of the patch's."""

    steps: str
    """Names with commas between them, as in `live dance --sequence`."""
    group: str = ""
    """One group, or "" for all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepsAdded(ControlEvent):
    """New takes were found in the folder of steps: they join the dance at the next measure line."""

    clips: str
    """Which, a line each."""
    library: str
    """Hash of the library with them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetMotion(ControlEvent):
    """How dancers vary and how motion is mended: one parameter, for one group or (group "") for all."""

    parameter: str
    """A field of `live.show.variety.Variety`."""
    value: float
    group: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetFacing(ControlEvent):
    """Where dancers look from their next decided measure on, for one group or (group "*") for all."""

    facing: str
    """Words as in the patch: public, path, centre, attractor, degrees, `dancer 3`, a group."""
    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class AskWhy(ControlEvent):
    """Somebody wants to see why a dancer dances what she dances; nothing in the show changes."""

    dancer: int
    """Her number from 1; 0: nobody any more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Blackout(ControlEvent):
    """The light goes out or comes back."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class BeatHeard(ControlEvent):
    """What a source says: a beat at `beat_time` [s of the show], `period` [s] to the next, confidence 0 to 1.

    The source is the event's `source`: "audio", "midi", "link", "mtc" …
    """

    beat_time: float
    """It may lie ahead: a prediction."""
    period: float
    confidence: float
    beat: int = -1
    """Which beat of its measure it is, from 0; -1 where the source cannot tell."""
    beats_per_measure: int = 0
    """0 where the source cannot tell."""
    measure: int = -1
    """The source's own number of the measure, from 0 (song position, Link); -1 where it counts none."""
    jump: bool = False
    """Whether the source says that it has jumped (start, song position): its grid is to be taken at once."""
    anchored: bool = True
    """False where the source only counts evenly and cannot tell when a beat is: MIDI clock that was never started."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceChanged(ControlEvent):
    """A clock source came ("found"), rests longer than usual ("paused"), fell silent ("silent"), went away ("lost").

    MIDI and Link also say "started" and "stopped".
    """

    state: str
    detail: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class TicksSkipped(ControlEvent):
    """The machine stalled: so many ticks were left out."""

    count: int


EVENT_TYPES: dict[str, type[ControlEvent]] = {
    cls.__name__: cls
    for cls in (
        Attract, Repel, Spread, Voice, PlaceElement, Evolve, DefineFormation, Travel, Pause, Release, Regroup,
        SetRipple, SetStage, Enter, Leave, PlaceObstacle, PlaceWall, RemoveObstacle, Performer, Clear, CallStep,
        StepNow, SetSequence, SetMotion, SetFacing, AskWhy,
        Tap, One,
        SetTempo, Nudge, ShiftBeats, ScaleTempo, HoldTempo, SetMetre, CountIn, ChooseSource, Blackout, BeatHeard,
        SourceChanged, StepsAdded, TicksSkipped, MusicHeard, RestartAudio, ChooseAudio, SetLatency,
        SetClick, JumpTo, Advance, HoldScore, Practice, Improvise, Signal, PatchChanged, StepsChanged,
        SetPicture, RecallView, RecallLook, RecallScene, StoreScene,
        Go, GiveCue, StandBy, StepBack, Panic, HoldShow, Undo, Redo,
        TakeOver,
    )
}  # fmt: skip
"""Every kind of event by its name in the journal."""


def event_to_json(event: ControlEvent) -> dict[str, Any]:
    """The event as a JSON object; floats keep every bit (Python writes the shortest form that reads back equal)."""
    return {"type": type(event).__name__, **asdict(event)}


IN_ROWS: tuple[type[ControlEvent], ...] = (BeatHeard, MusicHeard, Performer, PlaceObstacle)
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
            (kind is float and isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value))
            or (kind is bool and isinstance(value, bool))
            or (kind is int and isinstance(value, int) and not isinstance(value, bool))
            or (kind is str and isinstance(value, str))
        )
        if not good:
            raise ValueError(f"event {name}: field {key!r} cannot be {value!r}")
    try:
        return cls(**values)
    except TypeError as error:
        raise ValueError(f"event {name}: {error}") from None


def _values_of(row: list[Any], columns: dict[str, list[str]]) -> dict[str, Any]:
    name = row[0] if row else None
    cls = EVENT_TYPES.get(name) if isinstance(name, str) else None
    names = [] if cls is None else columns.get(cls.__name__) or list(_kinds(cls.__name__))
    if len(row) - 1 > len(names) and cls is not None:
        raise ValueError(f"event {name}: {len(row) - 1} values, {len(names)} expected")
    return {"type": name, **dict(zip(names, row[1:], strict=False))}


@cache
def _kinds(name: str) -> dict[str, Any]:
    """The fields of an event's type, in their order, and what they hold."""
    return {field.name: field.type for field in fields(EVENT_TYPES[name])}
