"""Events: everything that may change a show, as frozen values stamped with time and source.

The journal of a show is its patch, its seed and these, each with the tick at which it was applied.
"""

from dataclasses import dataclass

from live.control.audio_events import ChooseAudio, MusicHeard, RestartAudio, SetClick, SetLatency
from live.control.clock_events import (
    BeatHeard,
    ChooseSource,
    CountIn,
    HoldTempo,
    Nudge,
    One,
    ScaleTempo,
    SetMetre,
    SetTempo,
    ShiftBeats,
    SourceChanged,
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
from live.control.output_events import AllowFlashes, FadePicture, FreezePicture, ShowCard
from live.control.patch_events import PatchChanged, StepsChanged
from live.control.scene_events import (
    Accompany,
    FollowSpot,
    RecallLook,
    RecallScene,
    RecallView,
    SetPass,
    SetPicture,
    ShowBackground,
    StoreScene,
)
from live.control.score_events import Advance, HoldScore, Improvise, JumpTo, Practice, Signal
from live.control.step_events import AskWhy, CallStep, Clear, SetFacing, SetMotion, SetSequence, StepNow, StepsAdded

__all__ = [
    "EVENT_TYPES",
    "Accompany",
    "Advance",
    "AllowFlashes",
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
    "FadePicture",
    "FollowSpot",
    "FreezePicture",
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
    "SetPass",
    "SetPicture",
    "SetRipple",
    "SetSequence",
    "SetStage",
    "SetTempo",
    "ShiftBeats",
    "ShowBackground",
    "ShowCard",
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
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Blackout(ControlEvent):
    """The light goes out or comes back."""

    on: bool


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
        SetPicture, SetPass, RecallView, RecallLook, RecallScene, StoreScene, Accompany, FollowSpot, ShowBackground,
        Go, GiveCue, StandBy, StepBack, Panic, HoldShow, Undo, Redo,
        TakeOver, FadePicture, FreezePicture, AllowFlashes, ShowCard,
    )
}  # fmt: skip
"""Every kind of event by its name in the journal."""
