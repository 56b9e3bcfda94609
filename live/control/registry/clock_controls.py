"""The beat, the light, and whether anybody listens."""

from typing import Final

from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM
from live.control.events import events
from live.control.registry.control import Argument, Control, Reply

METRE_MIN: Final = 2
METRE_MAX: Final = 12
"""Beats of a measure that may be asked for live."""


def _pong(time: float, source: str) -> Reply:
    return Reply("/dance/pong")


def _half(*, time: float, source: str) -> events.ScaleTempo:
    return events.ScaleTempo(time=time, source=source, factor=0.5)


def _double(*, time: float, source: str) -> events.ScaleTempo:
    return events.ScaleTempo(time=time, source=source, factor=2.0)


def _metre(*, time: float, source: str, beats: float) -> events.SetMetre:
    return events.SetMetre(time=time, source=source, beats=float(round(beats)))


CLOCK_CONTROLS: Final = (
    Control("/dance/clock/tap", events.Tap, (), "A beat is now; taps in a row give the tempo.", "musician"),
    Control("/dance/clock/one", events.One, (), '"This is the one": a measure begins now.', "musician"),
    Control(
        "/dance/clock/tempo", events.SetTempo,
        (Argument("tempo", "float", "the new tempo", "bpm", TEMPO_MIN_BPM, TEMPO_MAX_BPM),),
        "Sets the tempo; the beat goes on without a jump. Music that is heard takes over again after 8 s.",
        "musician", "continuous", 1,
    ),
    Control("/dance/clock/half", _half, (), "Half as many beats, from the next strong beat on.", "musician"),
    Control("/dance/clock/double", _double, (), "Twice as many beats, from the next beat on.", "musician"),
    Control(
        "/dance/clock/nudge", events.Nudge,
        (Argument("seconds", "float", "later, or earlier if negative", "s", -0.25, 0.25, default=0.01),),
        "Moves the beats a little against what the source in force says; nudges add up.", "musician",
    ),
    Control(
        "/dance/clock/shift", events.ShiftBeats,
        (Argument("beats", "float", "later, or earlier if negative", "beats", -8, 8, default=1.0),),
        "Moves the measure line by beats; half a beat moves the beats to the off-beat.", "musician",
    ),
    Control(
        "/dance/clock/hold", events.HoldTempo,
        (Argument("on", "bool", "1: the tempo is frozen, 0: it follows again", default=True),),
        "Freezes the tempo: nothing that is heard corrects tempo or beat.", "musician", "continuous", 1, (False,),
    ),
    Control(
        "/dance/clock/metre", _metre,
        (Argument("beats", "float", "beats of a measure, rounded", "beats", METRE_MIN, METRE_MAX),),
        "Measures have so many beats from the next measure line on; a step fills the measure.",
        "musician", "continuous", 1,
    ),
    Control(
        "/dance/clock/count_in", events.CountIn,
        (Argument("measures", "float", "measures counted before the one, rounded", "measures", 0, 8, default=1.0),),
        "Counts in, from the next beat if there is one, else after a measure of taps; then comes the one.", "musician",
    ),
    Control(
        "/dance/clock/source", events.ChooseSource,
        (Argument("name", "name", '"auto", or one of link, midi, mtc, audio, tap, internal', default="auto"),),
        "Which source is followed; it takes over at a measure line, once it is there.",
        "operator", "continuous", 1, ("auto",),
    ),
    Control(
        "/dance/blackout", events.Blackout,
        (Argument("on", "bool", "1: the light goes out, 0: it comes back"),),
        "Turns the light of the show out or on.", "operator", "continuous", 1, (False,),
    ),
    Control("/dance/ping", _pong, (), "Answers /dance/pong, to the sender only; changes nothing.", "audience"),
)  # fmt: skip
