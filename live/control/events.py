"""Events: everything that may change a show, as frozen values stamped with time and source.

The journal of a show is its patch, its seed and these, each with the tick at which it was applied.
"""

from dataclasses import dataclass

from live.control.audience_events import (
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
from live.control.machine_events import BreakerTripped, ResetBreaker, TakeOver
from live.control.midi_events import ForgetMidi, LearnMidi, NotesHeard
from live.control.mocap_events import (
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
from live.control.output_events import AllowFlashes, FadePicture, FreezePicture, HoldQuality, ShowCard
from live.control.partner_events import PairPartner, SetPartner, WalkOn
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
        SetPartner, PairPartner, WalkOn,
        MocapFrame, TrackerMoved, CastMocap, ShowMocap, MirrorMocap, PlaceMocap, CanonMocap, BlockMocap, DrawMocap,
        AudienceHeard, OpenAudience, SetAudienceGain, MuteAudience, WeighRegion, GiveTurn, BanPhone, AskVote, DropVote,
        AllowShaking,
        TakeOver, LearnMidi, ForgetMidi, NotesHeard, FadePicture, FreezePicture, AllowFlashes, ShowCard, HoldQuality,
        BreakerTripped, ResetBreaker,
    )
}  # fmt: skip
"""Every kind of event by its name in the journal."""
