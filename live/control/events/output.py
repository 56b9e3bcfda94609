"""Events of the whole picture and the projectors: fade, freeze, flashes, test cards, quality."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class FadePicture(ControlEvent):
    """Fades the whole picture to `level`, 0 to 1, within `beats`."""

    level: float
    beats: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FreezePicture(ControlEvent):
    """Freezes the picture, or continues at the dance's current state."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class AllowFlashes(ControlEvent):
    """Lifts the limit on flashes, or restores it."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ShowCard(ControlEvent):
    """Shows a test card on an output, or the picture again (`off`)."""

    output: str
    """Name of the output; `*`: all."""
    card: str


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldQuality(ControlEvent):
    """Fixes the quality level of the picture, or (below 0) makes it adaptive."""

    step: float
    """0 is the best; clamped to the last level."""
