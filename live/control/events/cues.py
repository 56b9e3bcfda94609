"""Commands of the stage manager: GO, standby, panic, hold, undo."""

from typing import Annotated

from live.control.events.event import ControlEvent
from live.control.registry.command import command
from live.control.registry.control import Argument

Cue = Annotated[str, Argument.label("the cue's name or number in the patch", "cue")]


@command("/dance/go", "operator")
class Go(ControlEvent):
    """Starts the cue on standby, at its own beat; a second GO from the same sender within 0.25 s is ignored."""


@command("/dance/cue", "operator")
class GiveCue(ControlEvent):
    """Starts this cue; the next one is on standby."""

    name: Cue


@command("/dance/standby", "operator", edits="standby")
class StandBy(ControlEvent):
    """Puts this cue on standby for the next GO."""

    name: Cue


@command("/dance/back", "operator", edits="standby")
class StepBack(ControlEvent):
    """Cancels a cue that is counting in; if there is none, puts the previous cue on standby."""


@command("/dance/panic", "operator")
class Panic(ControlEvent):
    """Ends all elements, evolutions, called steps, fades and waiting cues, restores the patch's light and steps, and
    holds the score until GO or /dance/hold 0; the beat continues."""


@command("/dance/hold", "operator", value=1, start=(False,))
class HoldShow(ControlEvent):
    """Holds score, fades and cues; the dance continues with its current steps."""

    on: Annotated[bool, Argument.switch("1: hold, 0: continue")]


@command("/dance/undo", "operator")
class Undo(ControlEvent):
    """Undoes the last edit: parameters, stored scenes, formations, sequences, facings, ripples, set, standby; never
    anything already played."""


@command("/dance/redo", "operator")
class Redo(ControlEvent):
    """Redoes the last undone edit."""
