"""Controls of the stage manager: GO, standby, panic, hold, undo."""

from typing import Final

from live.control.events import events
from live.control.registry.control import Argument, Control

_CUE: Final = Argument("name", "name", "the cue's name or number in the patch")

CUE_CONTROLS: Final = (
    Control(
        "/dance/go", events.Go, (),
        "Starts the cue on standby, at its own beat; a second GO from the same sender within 0.25 s is ignored.",
        "operator",
    ),
    Control("/dance/cue", events.GiveCue, (_CUE,), "Starts this cue; the next one is on standby.", "operator"),
    Control("/dance/standby", events.StandBy, (_CUE,), "Puts this cue on standby for the next GO.", "operator"),
    Control(
        "/dance/back", events.StepBack, (),
        "Cancels a cue that is counting in; if there is none, puts the previous cue on standby.", "operator",
    ),
    Control(
        "/dance/panic", events.Panic, (),
        "Ends all elements, evolutions, called steps, fades and waiting cues, restores the patch's light and steps, "
        "and holds the score until GO or /dance/hold 0; the beat continues.", "operator",
    ),
    Control(
        "/dance/hold", events.HoldShow, (Argument("on", "bool", "1: hold, 0: continue"),),
        "Holds score, fades and cues; the dance continues with its current steps.", "operator", "continuous", 1,
        (False,),
    ),
    Control(
        "/dance/undo", events.Undo, (),
        "Undoes the last edit: parameters, stored scenes, formations, sequences, facings, ripples, set, standby; "
        "never anything already played.", "operator",
    ),
    Control("/dance/redo", events.Redo, (), "Redoes the last undone edit.", "operator"),
)  # fmt: skip
"""The controls of cues, panic, hold and undo."""
