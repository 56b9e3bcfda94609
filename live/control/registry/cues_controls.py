"""What a stage manager says: GO, stand-by, panic, hold; and undo."""

from typing import Final

from live.control.events import events
from live.control.registry.control import Argument, Control

_CUE: Final = Argument("name", "name", "the cue's name or number in the patch")

CUE_CONTROLS: Final = (
    Control(
        "/dance/go", events.Go, (),
        "Gives the cue that stands by, at the beat that it asks for; a second GO of one sender within 0.25 s is none.",
        "operator",
    ),
    Control("/dance/cue", events.GiveCue, (_CUE,), "Gives this cue; the one after it stands by.", "operator"),
    Control("/dance/standby", events.StandBy, (_CUE,), "This cue stands by for the next GO.", "operator"),
    Control(
        "/dance/back", events.StepBack, (),
        "Takes back a cue that is counting in; if none is, the cue before stands by.", "operator",
    ),
    Control(
        "/dance/panic", events.Panic, (),
        "All elements, evolutions, called steps, fades and waiting cues end, the patch's own light and steps come "
        "back, and the score is held until GO or /dance/hold 0; the beat goes on.", "operator",
    ),
    Control(
        "/dance/hold", events.HoldShow, (Argument("on", "bool", "1: all stands still, 0: all goes on"),),
        "Holds score, fades and cues; the dance goes on with what it has.", "operator", "continuous", 1, (False,),
    ),
    Control(
        "/dance/undo", events.Undo, (),
        "Takes back the last edit: parameters, scenes stored, formations, sequences, facings, ripples, set, stand-by; "
        "never what has been played.", "operator",
    ),
    Control("/dance/redo", events.Redo, (), "Makes the last edit again that was taken back.", "operator"),
)  # fmt: skip
"""Cues, panic, hold, undo."""
