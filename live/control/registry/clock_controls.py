"""Controls of the clock, blackout, and ping."""

from typing import Final

from live.clock.follower.clock_source import PRIORITY
from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM
from live.control.events import events
from live.control.registry.control import Argument, Control, Reply

METRE_MIN: Final = 2
METRE_MAX: Final = 12
"""Range of beats per measure that can be set live."""


def _pong(time: float, source: str) -> Reply:
    return Reply("/dance/pong")


def _half(*, time: float, source: str) -> events.ScaleTempo:
    return events.ScaleTempo(time=time, source=source, factor=0.5)


def _double(*, time: float, source: str) -> events.ScaleTempo:
    return events.ScaleTempo(time=time, source=source, factor=2.0)


def _metre(*, time: float, source: str, beats: float) -> events.SetMetre:
    return events.SetMetre(time=time, source=source, beats=float(round(beats)))


CLOCK_CONTROLS: Final = (
    Control("/dance/clock/tap", events.Tap, (), "Taps a beat; several taps give the tempo.", "musician"),
    Control("/dance/clock/one", events.One, (), '"This is the one": a measure starts now.', "musician"),
    Control(
        "/dance/clock/tempo", events.SetTempo,
        (Argument("tempo", "float", "the new tempo", "bpm", TEMPO_MIN_BPM, TEMPO_MAX_BPM),),
        "Sets the tempo; the beat continues without a jump. Tracked music takes over again after 8 s.",
        "musician", "continuous", 1,
    ),
    Control("/dance/clock/half", _half, (), "Half as many beats, from the next strong beat on.", "musician"),
    Control("/dance/clock/double", _double, (), "Twice as many beats, from the next beat on.", "musician"),
    Control(
        "/dance/clock/nudge", events.Nudge,
        (Argument("seconds", "float", "later, or earlier if negative", "s", -0.25, 0.25, default=0.01),),
        "Moves the beats a little relative to the active source; nudges add up.", "musician",
    ),
    Control(
        "/dance/clock/shift", events.ShiftBeats,
        (Argument("beats", "float", "later, or earlier if negative", "beats", -8, 8, default=1.0),),
        "Moves the measure line by beats; half a beat moves the beats to the off-beat.", "musician",
    ),
    Control(
        "/dance/clock/hold", events.HoldTempo,
        (Argument("on", "bool", "1: the tempo is frozen, 0: it follows the source again", default=True),),
        "Freezes the tempo: no source corrects tempo or beat.", "musician", "continuous", 1, (False,),
    ),
    Control(
        "/dance/clock/metre", _metre,
        (Argument("beats", "float", "beats of a measure, rounded", "beats", METRE_MIN, METRE_MAX),),
        "Sets the beats per measure from the next measure line on; a step fills the measure.",
        "musician", "continuous", 1,
    ),
    Control(
        "/dance/clock/count_in", events.CountIn,
        (Argument("measures", "float", "measures counted before the one, rounded", "measures", 0, 8, default=1.0),),
        "Counts in to the one, from the next beat if there is one, else after a measure of taps.", "musician",
    ),
    Control(
        "/dance/clock/source", events.ChooseSource,
        (Argument("name", "name", f'"auto", or one of {", ".join(PRIORITY)}', default="auto"),),
        "Selects the clock source; it takes over at a measure line, once it is available.",
        "operator", "continuous", 1, ("auto",),
    ),
    Control(
        "/dance/blackout", events.Blackout,
        (Argument("on", "bool", "1: light off, 0: light on"),),
        "Switches the light of the show off or on.", "operator", "continuous", 1, (False,),
    ),
    Control("/dance/ping", _pong, (), "Answers /dance/pong, to the sender only; changes nothing.", "audience"),
)  # fmt: skip
