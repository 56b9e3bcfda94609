"""Events about the picture as a whole, on its way to the projectors: fade, freeze, flashes, test cards."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class FadePicture(ControlEvent):
    """The whole picture goes to so much of its light, 0 to 1, within so many beats."""

    level: float
    beats: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FreezePicture(ControlEvent):
    """The picture stands still, or goes on with where the dance is by then."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class AllowFlashes(ControlEvent):
    """The limit on flashes is lifted, or holds again."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ShowCard(ControlEvent):
    """An output shows a test card, or the picture again (`off`)."""

    output: str
    """Its name; `*`: all."""
    card: str


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldQuality(ControlEvent):
    """The picture is drawn in this step of quality from now on, or (below 0) in the one that the machine can afford."""

    step: float
    """0 is the best; beyond the last one: the last one."""
