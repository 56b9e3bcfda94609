"""All event types: every input that can change a show, as a frozen value with time and source.

The journal of a show is its patch, its seed and its events, each with the tick at which it was applied.
"""

from dataclasses import dataclass

from live.control.events.audience import (
    AllowShaking,
    AskVote,
    AudienceHeard,
    BanPhone,
    DropVote,
    GiveTurn,
    MuteAudience,
    OpenAudience,
    SetAudienceGain,
    WeighRegion,
)
from live.control.events.audio import ChooseAudio, MusicHeard, RestartAudio, SetClick, SetLatency
from live.control.events.capture import (
    BlockMocap,
    CanonMocap,
    CastMocap,
    DrawMocap,
    MirrorMocap,
    MocapFrame,
    PlaceMocap,
    ShowMocap,
    TrackerMoved,
)
from live.control.events.clock import (
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
from live.control.events.cues import GiveCue, Go, HoldShow, Panic, Redo, StandBy, StepBack, Undo
from live.control.events.elements import Attract, PlaceElement, Repel, Spread, Voice
from live.control.events.event import ControlEvent
from live.control.events.groups import (
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
from live.control.events.midi import ForgetMidi, LearnMidi, NotesHeard
from live.control.events.motion import AskWhy, CallStep, Clear, SetFacing, SetMotion, SetSequence, StepNow, StepsAdded
from live.control.events.output import AllowFlashes, FadePicture, FreezePicture, HoldQuality, ShowCard
from live.control.events.partners import PairPartner, SetPartner, WalkOn
from live.control.events.scenes import (
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
from live.control.events.score import Advance, HoldScore, Improvise, JumpTo, Practice, Signal
from live.control.events.system import BreakerTripped, PatchChanged, ResetBreaker, StepsChanged, TakeOver

__all__ = [
    "EVENT_TYPES",
    "Accompany",
    "Advance",
    "AllowFlashes",
    "AllowShaking",
    "AskVote",
    "AskWhy",
    "Attract",
    "AudienceHeard",
    "BanPhone",
    "BeatHeard",
    "Blackout",
    "BlockMocap",
    "BreakerTripped",
    "CallStep",
    "CanonMocap",
    "CastMocap",
    "ChooseAudio",
    "ChooseSource",
    "Clear",
    "ControlEvent",
    "CountIn",
    "DefineFormation",
    "DrawMocap",
    "DropVote",
    "Enter",
    "Evolve",
    "FadePicture",
    "FollowSpot",
    "ForgetMidi",
    "FreezePicture",
    "GiveCue",
    "GiveTurn",
    "Go",
    "HoldQuality",
    "HoldScore",
    "HoldShow",
    "HoldTempo",
    "Improvise",
    "JumpTo",
    "LearnMidi",
    "Leave",
    "MirrorMocap",
    "MocapFrame",
    "MusicHeard",
    "MuteAudience",
    "NotesHeard",
    "Nudge",
    "One",
    "OpenAudience",
    "PairPartner",
    "Panic",
    "PatchChanged",
    "Pause",
    "Performer",
    "PlaceElement",
    "PlaceMocap",
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
    "ResetBreaker",
    "RestartAudio",
    "ScaleTempo",
    "SetAudienceGain",
    "SetClick",
    "SetFacing",
    "SetLatency",
    "SetMetre",
    "SetMotion",
    "SetPartner",
    "SetPass",
    "SetPicture",
    "SetRipple",
    "SetSequence",
    "SetStage",
    "SetTempo",
    "ShiftBeats",
    "ShowBackground",
    "ShowCard",
    "ShowMocap",
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
    "TrackerMoved",
    "Travel",
    "Undo",
    "Voice",
    "WalkOn",
    "WeighRegion",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Blackout(ControlEvent):
    """Switches the light of the show off or on."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class TicksSkipped(ControlEvent):
    """Number of ticks left out because the machine stalled."""

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
        SetPartner, PairPartner, WalkOn,
        MocapFrame, TrackerMoved, CastMocap, ShowMocap, MirrorMocap, PlaceMocap, CanonMocap, BlockMocap, DrawMocap,
        AudienceHeard, OpenAudience, SetAudienceGain, MuteAudience, WeighRegion, GiveTurn, BanPhone, AskVote, DropVote,
        AllowShaking,
        TakeOver, LearnMidi, ForgetMidi, NotesHeard, FadePicture, FreezePicture, AllowFlashes, ShowCard, HoldQuality,
        BreakerTripped, ResetBreaker,
    )
}  # fmt: skip
"""All event types by their names in the journal."""
