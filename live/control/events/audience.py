"""Commands for the audience's phones, and the phones' combined input."""

from dataclasses import dataclass
from typing import Annotated, Final

from live.control.events.event import ControlEvent
from live.control.registry.command import command
from live.control.registry.control import Argument

NO_CHOICE: Final = "-"
"""Placeholder for an unused choice."""
VoicePlace = tuple[int, int, int, int]
"""A gathering place: x, z [cm], weight in thousandths of the heaviest place, mode 1 attract or 2 repel."""
VoiceLight = tuple[int, int, int, int, int]
"""A voice that is shown: number of the phone, x, z [cm], hue in thousandths, mode."""
Region = Annotated[str, Argument.label("a region of the patch's [audience]; * means all", "region")]


@dataclass(frozen=True, slots=True, kw_only=True)
class AudienceHeard(ControlEvent):
    """The combined input of all phones, aggregated by the gateway, at most once per tick.

    Whole numbers keep the journal small. None: unchanged.
    """

    phones: int
    """Number of phones."""
    order: int
    """Number of operator commands applied by the gateway, see `Audience.order`; older input is ignored."""
    share: int = 0
    """Influence in thousandths; it reaches 1000 when there are enough phones."""
    places: tuple[VoicePlace, ...] | None = None
    """Gathering places."""
    lights: tuple[VoiceLight, ...] | None = None
    """Voices shown."""
    votes: tuple[int, ...] | None = None
    """Number of the vote, then the votes for each choice in hundredths."""
    shaken: int = 0
    """Share of active phones that are shaken, in thousandths."""


@command("/dance/audience/open", "operator", value=1, start=(True,))
@command("/dance/audience/close", "operator", "The same as /dance/audience/open 0, for a button.", fixed={"on": False})
class OpenAudience(ControlEvent):
    """Opens the show to phones, or closes it within one tick."""

    on: Annotated[bool, Argument.switch("1: phones may take part, 0: they have no effect and are not shown")]


@command("/dance/audience/gain", "operator", value=1, start=(1.0,))
class SetAudienceGain(ControlEvent):
    """Sets how strongly the audience influences dancers."""

    gain: Annotated[float, Argument.number("influence of the audience", 0, 1)]


@command("/dance/audience/mute", "operator", value=1, start=(False,))
class MuteAudience(ControlEvent):
    """Mutes the audience's influence on dancers; phones stay in, and their lights are shown."""

    on: Annotated[bool, Argument.switch("1: no influence, 0: influence")]


@command("/dance/audience/region", "operator")
class WeighRegion(ControlEvent):
    """Sets the weight of a region of the audience."""

    name: Region
    weight: Annotated[float, Argument.number("weight of each of its voices; 0: none", 0, 4)]


@command("/dance/audience/turn", "operator")
class GiveTurn(ControlEvent):
    """From the next measure line on only this region takes part; its phones count in. * ends it."""

    name: Region
    measures: Annotated[float, Argument.number("duration", 1, 1024, "measures")] = 4.0


@command("/dance/audience/ban", "operator")
class BanPhone(ControlEvent):
    """Excludes a phone from effect and display, also after it joins again; the phone is not informed."""

    number: Annotated[int, Argument.number("its number in the status; 0 with on = 0: lifts all bans", 0, 2e9)]
    on: Annotated[bool, Argument.switch("1: on, 0: off")] = True


@command("/dance/audience/vote", "operator")
class AskVote(ControlEvent):
    """Starts a vote until a measure line (the patch's vote_measures), where the winner is called."""

    what: Annotated[str, Argument.label("step, scene, look, cue or word")]
    first: Annotated[str, Argument.label("a choice, by its name in the patch")]
    second: Annotated[str, Argument.label("another one")]
    third: Annotated[str, Argument.label("another one; - is none")] = NO_CHOICE
    fourth: Annotated[str, Argument.label("another one; - is none")] = NO_CHOICE

    @property
    def choices(self) -> list[str]:
        """The choices that are used."""
        said = (self.first, self.second, self.third, self.fourth)
        return [choice for choice in said if choice.strip() not in ("", NO_CHOICE)]


@command("/dance/audience/vote/drop", "operator")
class DropVote(ControlEvent):
    """Cancels the vote; nothing is called."""


@command("/dance/audience/tally", "operator", value=1, start=(True,))
class ShowTally(ControlEvent):
    """Whether projectors show how a vote stands, and its winner for some measures; phones always do."""

    on: Annotated[bool, Argument.switch("1: projectors show the tally and the winner, 0: phones alone do")]


Word = Annotated[str, Argument.label("a word of at most 24 letters")]
WaitingWord = Annotated[str, Argument.label("a word that waits; *: all that wait")]


@command("/dance/word", "operator")
class AddWord(ControlEvent):
    """Shows a word among those of the audience."""

    word: Word


@command("/dance/word/offer", "audience")
class OfferWord(ControlEvent):
    """Offers a word to the operator; it is shown once it is approved."""

    word: Word


@command("/dance/word/approve", "operator")
class ApproveWord(ControlEvent):
    """Shows words that wait."""

    word: WaitingWord


@command("/dance/word/reject", "operator")
class RejectWord(ControlEvent):
    """Forgets words that wait."""

    word: WaitingWord


@command("/dance/word/clear", "operator")
class ClearWords(ControlEvent):
    """Lets all words fade, and forgets those that wait."""


@command("/dance/audience/invite", "operator")
class RenewInvitation(ControlEvent):
    """Makes a new invitation for you and your team; with the one before nobody comes in any more."""


@command("/dance/audience/shake", "operator", value=1, start=(True,))
class AllowShaking(ControlEvent):
    """Whether shaken phones count."""

    on: Annotated[bool, Argument.switch("1: dancers spread when many phones are shaken, 0: not")]
