"""The beat, the light, and whether anybody listens."""

from typing import Final

from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM
from live.control import events
from live.control.control import Argument, Control, Reply


def _pong(time: float, source: str) -> Reply:
    return Reply("/dance/pong")


CLOCK_CONTROLS: Final = (
    Control("/dance/clock/tap", events.Tap, (), "A beat is now; taps in a row give the tempo.", "musician"),
    Control("/dance/clock/one", events.One, (), '"This is the one": a measure begins now.', "musician"),
    Control(
        "/dance/clock/tempo", events.SetTempo,
        (Argument("tempo", "float", "the new tempo", "bpm", TEMPO_MIN_BPM, TEMPO_MAX_BPM),),
        "Sets the tempo; the beat goes on without a jump. Music that is heard takes over again after 8 s.",
        "musician",
    ),
    Control(
        "/dance/blackout", events.Blackout,
        (Argument("on", "bool", "1: the light goes out, 0: it comes back"),),
        "Turns the light of the show out or on.", "operator",
    ),
    Control("/dance/ping", _pong, (), "Answers /dance/pong, to the sender only; changes nothing.", "audience"),
)  # fmt: skip
