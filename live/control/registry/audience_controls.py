"""Controls of the audience's phones: permissions and votes."""

from typing import Final

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import Argument, Control

CARD: Final = "qr"
"""The test card with the QR code for joining."""
NO_CHOICE: Final = "-"
"""Placeholder for an unused choice."""
_REGION: Final = Argument("name", "name", "a region of the patch's [audience]; * means all")
_ON: Final = Argument("on", "bool", "1: on, 0: off", default=True)


def _ban(*, time: float, source: str, number: float, on: bool) -> ControlEvent:
    return events.BanPhone(time=time, source=source, number=round(number), on=on)


def _vote(*, time: float, source: str, third: str, fourth: str, **others: str) -> ControlEvent:
    third, fourth = ("" if name.strip() == NO_CHOICE else name for name in (third, fourth))
    return events.AskVote(time=time, source=source, third=third, fourth=fourth, **others)


def _close(*, time: float, source: str) -> ControlEvent:
    return events.OpenAudience(time=time, source=source, on=False)


def _code(*, time: float, source: str, on: bool) -> ControlEvent:
    return events.ShowCard(time=time, source=source, output="*", card=CARD if on else "off")


AUDIENCE_CONTROLS: Final = (
    Control(
        "/dance/audience/open", events.OpenAudience,
        (Argument("on", "bool", "1: phones may take part, 0: they have no effect and are not shown"),),
        "Opens the show to phones, or closes it within one tick.", "operator", "continuous", 1, (True,),
    ),
    Control("/dance/audience/close", _close, (), "The same as /dance/audience/open 0, for a button.", "operator"),
    Control(
        "/dance/audience/gain", events.SetAudienceGain,
        (Argument("gain", "float", "influence of the audience", "", 0, 1),),
        "Sets how strongly the audience influences dancers.", "operator", "continuous", 1, (1.0,),
    ),
    Control(
        "/dance/audience/mute", events.MuteAudience, (Argument("on", "bool", "1: no influence, 0: influence"),),
        "Mutes the audience's influence on dancers; phones stay in, and their lights are shown.",
        "operator", "continuous", 1, (False,),
    ),
    Control(
        "/dance/audience/region", events.WeighRegion,
        (_REGION, Argument("weight", "float", "weight of each of its voices; 0: none", "", 0, 4)),
        "Sets the weight of a region of the audience.", "operator",
    ),
    Control(
        "/dance/audience/turn", events.GiveTurn,
        (_REGION, Argument("measures", "float", "duration", "measures", 1, 1024, 4.0)),
        "From the next measure line on only this region takes part; its phones count in. * ends it.", "operator",
    ),
    Control(
        "/dance/audience/ban", _ban,
        (Argument("number", "float", "its number in the status; 0 with on = 0: lifts all bans", "", 0, 2e9),
         _ON),
        "Excludes a phone from effect and display, also after it joins again; the phone is not informed.",
        "operator",
    ),
    Control(
        "/dance/audience/vote", _vote,
        (
            Argument("what", "name", "step, scene, look or cue"),
            Argument("first", "name", "a choice, by its name in the patch"),
            Argument("second", "name", "another one"),
            Argument("third", "name", "another one; - is none", default=NO_CHOICE),
            Argument("fourth", "name", "another one; - is none", default=NO_CHOICE),
        ),
        "Starts a vote until a measure line (the patch's vote_measures), where the winner is called.", "operator",
    ),
    Control("/dance/audience/vote/drop", events.DropVote, (), "Cancels the vote; nothing is called.", "operator"),
    Control(
        "/dance/audience/shake", events.AllowShaking,
        (Argument("on", "bool", "1: dancers spread when many phones are shaken, 0: not"),),
        "Whether shaken phones count.", "operator", "continuous", 1, (True,),
    ),
    Control(
        "/dance/audience/qr", _code, (_ON,),
        "Every projector shows the QR code for joining over the dimmed dance; 0: the picture again.", "operator",
    ),
)  # fmt: skip
"""The controls under /dance/audience."""
