"""The audience's phones: what the operator lets them do, and what they vote for."""

from typing import Final

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import Argument, Control

CARD: Final = "qr"
"""The card with the code that phones join by."""
NOTHING: Final = "-"
"""A choice that is none."""
_REGION: Final = Argument("name", "name", "a region of the patch's [audience]; * means all")
_ON: Final = Argument("on", "bool", "1: so it is, 0: not any more", default=True)


def _ban(*, time: float, source: str, number: float, on: bool) -> ControlEvent:
    return events.BanPhone(time=time, source=source, number=round(number), on=on)


def _vote(*, time: float, source: str, third: str, fourth: str, **others: str) -> ControlEvent:
    third, fourth = ("" if name.strip() == NOTHING else name for name in (third, fourth))
    return events.AskVote(time=time, source=source, third=third, fourth=fourth, **others)


def _close(*, time: float, source: str) -> ControlEvent:
    return events.OpenAudience(time=time, source=source, on=False)


def _code(*, time: float, source: str, on: bool) -> ControlEvent:
    return events.ShowCard(time=time, source=source, output="*", card=CARD if on else "off")


AUDIENCE_CONTROLS: Final = (
    Control(
        "/dance/audience/open", events.OpenAudience,
        (Argument("on", "bool", "1: phones may play, 0: nothing of them acts or is seen"),),
        "Lets phones play, or none, within one tick.", "operator", "continuous", 1, (True,),
    ),
    Control("/dance/audience/close", _close, (), "The same as /dance/audience/open 0, for a button.", "operator"),
    Control(
        "/dance/audience/gain", events.SetAudienceGain,
        (Argument("gain", "float", "how strongly the audience is heard", "", 0, 1),),
        "How strongly dancers hear the audience.", "operator", "continuous", 1, (1.0,),
    ),
    Control(
        "/dance/audience/mute", events.MuteAudience, (Argument("on", "bool", "1: dancers do not hear it, 0: they do"),),
        "Dancers do not hear the audience; phones play on, and their lights are seen.",
        "operator", "continuous", 1, (False,),
    ),
    Control(
        "/dance/audience/region", events.WeighRegion,
        (_REGION, Argument("weight", "float", "what each of its voices weighs; 0: it is not heard", "", 0, 4)),
        "Weighs the voices of a region of the audience.", "operator",
    ),
    Control(
        "/dance/audience/turn", events.GiveTurn,
        (_REGION, Argument("measures", "float", "for how long", "measures", 1, 1024, 4.0)),
        "From the next measure line on only this region plays; its phones count in. * ends it.", "operator",
    ),
    Control(
        "/dance/audience/ban", _ban,
        (Argument("number", "float", "its number, as the status tells; 0 with on = 0: lifts all", "", 0, 2e9),
         _ON),
        "A phone is not heard or seen any more, nor is who joins anew in its place; it is not told so.",
        "operator",
    ),
    Control(
        "/dance/audience/vote", _vote,
        (
            Argument("what", "name", "step, scene, look or cue"),
            Argument("first", "name", "a choice by its name in the patch"),
            Argument("second", "name", "another one"),
            Argument("third", "name", "another one; - is none", default=NOTHING),
            Argument("fourth", "name", "another one; - is none", default=NOTHING),
        ),
        "The audience votes until a measure line (the patch's vote_measures), where the winner is called.", "operator",
    ),
    Control("/dance/audience/vote/drop", events.DropVote, (), "Drops the vote: nothing is called.", "operator"),
    Control(
        "/dance/audience/shake", events.AllowShaking,
        (Argument("on", "bool", "1: dancers spread when many phones are shaken, 0: not"),),
        "Whether shaken phones count.", "operator", "continuous", 1, (True,),
    ),
    Control(
        "/dance/audience/qr", _code, (_ON,),
        "Every projector shows the code that phones join by, over the dimmed dance; 0: the picture again.", "operator",
    ),
)  # fmt: skip
"""The addresses under /dance/audience."""
