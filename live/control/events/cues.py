"""Events of the stage manager: GO, stand-by, panic, hold, undo."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class Go(ControlEvent):
    """The cue that stands by is given; the next one stands by."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GiveCue(ControlEvent):
    """This cue is given, whatever stands by; the one after it stands by."""

    name: str
    """Its name or number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StandBy(ControlEvent):
    """This cue stands by."""

    name: str
    """Its name or number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepBack(ControlEvent):
    """A cue that is counting in is taken back; if none is, the one before the one that stands by does so."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Panic(ControlEvent):
    """Everything that was added ends, the patch's light comes back, the score is held; the music's clock goes on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldShow(ControlEvent):
    """Score, fades and cues stand still, or go on; the dance goes on."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Undo(ControlEvent):
    """The last edit is taken back."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Redo(ControlEvent):
    """The last edit that was taken back is made again."""
