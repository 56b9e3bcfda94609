"""Events of the audience: what its phones want together, and what the operator lets them."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class AudienceHeard(ControlEvent):
    """What all phones want together at one moment: made of their voices by the gateway, once a tick at most.

    Numbers with spaces between them, entries with commas: whole numbers, so that the journal stays small. Empty: as it
    was said before; `-`: none any more.
    """

    phones: int
    """How many there are."""
    order: int
    """How many of the operator's words were heeded, see `Audience.order`: what was made before is not heard."""
    share: int = 0
    """How strongly they are heard, in thousandths: all of it once there are enough of them."""
    places: str = ""
    """Where they gather: x z [cm], weight in thousandths of the heaviest place, mode 1 attract or 2 repel."""
    lights: str = ""
    """Voices that are seen: number of the phone, x z [cm], hue in thousandths, mode."""
    votes: str = ""
    """Number of the vote, then the voices for each choice in hundredths."""
    shaken: int = 0
    """Share of those who play that shake their phones, in thousandths."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenAudience(ControlEvent):
    """Phones may play, or none may: closed, nothing of them acts or is seen from the same tick on."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SetAudienceGain(ControlEvent):
    """How strongly the audience is heard, 0 to 1."""

    gain: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MuteAudience(ControlEvent):
    """The phones play on, but dancers do not hear them, or do again."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class WeighRegion(ControlEvent):
    """How much each voice of a region of the audience weighs; 0: none of them is heard."""

    name: str
    weight: float


@dataclass(frozen=True, slots=True, kw_only=True)
class GiveTurn(ControlEvent):
    """From the next measure line on only this region plays, for so many measures; `*`: everybody plays again."""

    name: str
    measures: float = 4.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BanPhone(ControlEvent):
    """A phone, by its number, is not heard or seen any more, or is again; 0 with `on` false: nobody is banned."""

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
    """The vote that runs is dropped: nothing is called."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AllowShaking(ControlEvent):
    """Phones that are shaken count, or do not."""

    on: bool
