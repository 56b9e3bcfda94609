"""Events of the audience: the phones' combined input, and the operator's settings for them."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class AudienceHeard(ControlEvent):
    """The combined input of all phones, aggregated by the gateway, at most once per tick.

    Numbers are separated by spaces, entries by commas; whole numbers keep the journal small. Empty: unchanged; `-`:
    none.
    """

    phones: int
    """Number of phones."""
    order: int
    """Number of operator commands applied by the gateway, see `Audience.order`; older input is ignored."""
    share: int = 0
    """Influence in thousandths; it reaches 1000 when there are enough phones."""
    places: str = ""
    """Gathering places: x z [cm], weight in thousandths of the heaviest place, mode 1 attract or 2 repel."""
    lights: str = ""
    """Voices shown: number of the phone, x z [cm], hue in thousandths, mode."""
    votes: str = ""
    """Number of the vote, then the votes for each choice in hundredths."""
    shaken: int = 0
    """Share of active phones that are shaken, in thousandths."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenAudience(ControlEvent):
    """Opens the show to phones, or closes it: from the same tick on they have no effect and are not shown."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SetAudienceGain(ControlEvent):
    """Sets the influence of the audience, 0 to 1."""

    gain: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MuteAudience(ControlEvent):
    """Mutes or restores the phones' influence on dancers; phones stay in."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class WeighRegion(ControlEvent):
    """Sets the weight of each voice of a region of the audience; 0: none."""

    name: str
    weight: float


@dataclass(frozen=True, slots=True, kw_only=True)
class GiveTurn(ControlEvent):
    """From the next measure line on only this region takes part, for `measures`; `*`: all regions."""

    name: str
    measures: float = 4.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BanPhone(ControlEvent):
    """Bans a phone by its number, or lifts the ban; 0 with `on` false lifts all bans."""

    number: int
    on: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class AskVote(ControlEvent):
    """The audience votes for the next step, scene, look or cue until a measure line, where the winner is called."""

    what: str
    first: str
    second: str
    third: str = ""
    fourth: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class DropVote(ControlEvent):
    """Cancels the current vote; nothing is called."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AllowShaking(ControlEvent):
    """Switches the effect of shaken phones on or off."""

    on: bool
