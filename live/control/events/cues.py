"""Events of the stage manager: GO, standby, panic, hold, undo."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class Go(ControlEvent):
    """Starts the cue on standby; the next one is on standby."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GiveCue(ControlEvent):
    """Starts this cue regardless of the standby; the next one is on standby."""

    name: str
    """Its name or number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StandBy(ControlEvent):
    """Puts this cue on standby."""

    name: str
    """Its name or number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepBack(ControlEvent):
    """Cancels a cue that is counting in; if there is none, the cue before the standby is on standby."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Panic(ControlEvent):
    """Ends everything that was added, restores the patch's light and holds the score; the music's clock continues."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldShow(ControlEvent):
    """Holds or continues score, fades and cues; the dance continues."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Undo(ControlEvent):
    """Undoes the last edit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Redo(ControlEvent):
    """Redoes the last undone edit."""
