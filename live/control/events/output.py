"""Commands of the whole picture and the projectors: fade, test cards, quality."""

from typing import Annotated, Final

from live.control.events.event import ControlEvent
from live.control.registry.command import command
from live.control.registry.control import Argument

JOIN_CARD: Final = "qr"
"""The test card with the QR code for joining."""


@command("/dance/output/fade", "operator", value=1, start=(1.0,))
class FadePicture(ControlEvent):
    """Fades the whole picture out, in, or to any level; scenes, cues and panic do not change it."""

    level: Annotated[float, Argument.number("remaining share of the light", 0, 1)]
    beats: Annotated[
        float, Argument.number("how long it takes; 0 is at once, without a flash", 0, 1024, "beats", default=4.0)
    ] = 0.0


@command("/dance/output/freeze", "operator", value=1, start=(False,))
class FreezePicture(ControlEvent):
    """Freezes the picture; the dance continues unseen, blackout and fade still work."""

    on: Annotated[bool, Argument.switch("1: frozen, 0: moving")] = True


@command("/dance/output/flashes", "operator", value=1, start=(False,))
class AllowFlashes(ControlEvent):
    """Lifts the limit on flashes, which may harm people with photosensitive epilepsy. Warn them first."""

    on: Annotated[bool, Argument.switch("1: no limit, 0: at most three per second")]


@command("/dance/output/card", "operator")
class ShowCard(ControlEvent):
    """Shows a test card on a projector."""

    output: Annotated[str, Argument.label("an [[output]] of the venue; * means all")]
    card: Annotated[str, Argument.label("grid, bars, name, safe, focus, qr, or off: the picture")] = "grid"


@command("/dance/audience/qr", "operator")
class ShowJoinCard(ControlEvent):
    """Every projector shows the QR code for joining over the dimmed dance; 0: the picture again."""

    on: Annotated[bool, Argument.switch("1: on, 0: off")] = True

    @property
    def output(self) -> str:
        """All outputs, as for `ShowCard`."""
        return "*"

    @property
    def card(self) -> str:
        """The card, as for `ShowCard`."""
        return JOIN_CARD if self.on else "off"


@command("/dance/picture/quality", "operator")
class HoldQuality(ControlEvent):
    """Holds a quality level of the picture; the status lists the levels."""

    step: Annotated[float, Argument.number("0: the best; -1: automatic", -1, 15)] = -1.0
