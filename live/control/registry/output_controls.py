"""Controls of the whole picture and of the projectors."""

from typing import Final

from live.control.events import events
from live.control.registry.control import Argument, Control

OUTPUT_CONTROLS: Final = (
    Control(
        "/dance/output/fade", events.FadePicture,
        (
            Argument("level", "float", "remaining share of the light", "", 0, 1),
            Argument("beats", "float", "how long it takes; 0 is at once, without a flash", "beats", 0, 1024, 4.0),
        ),
        "Fades the whole picture out, in, or to any level; scenes, cues and panic do not change it.",
        "operator", "continuous", 1, (1.0,),
    ),
    Control(
        "/dance/output/freeze", events.FreezePicture,
        (Argument("on", "bool", "1: frozen, 0: moving", default=True),),
        "Freezes the picture; the dance continues unseen, blackout and fade still work.",
        "operator", "continuous", 1, (False,),
    ),
    Control(
        "/dance/output/flashes", events.AllowFlashes,
        (Argument("on", "bool", "1: no limit, 0: at most three per second"),),
        "Lifts the limit on flashes, which may harm people with photosensitive epilepsy. Warn them first.",
        "operator", "continuous", 1, (False,),
    ),
    Control(
        "/dance/output/card", events.ShowCard,
        (
            Argument("output", "name", "an [[output]] of the venue; * means all"),
            Argument("card", "name", "grid, bars, name, safe, focus, qr, or off: the picture", default="grid"),
        ),
        "Shows a test card on a projector.", "operator",
    ),
    Control(
        "/dance/picture/quality", events.HoldQuality,
        (Argument("step", "float", "0: the best; -1: automatic", "", -1, 15, -1.0),),
        "Holds a quality level of the picture; the status lists the levels.", "operator",
    ),
)  # fmt: skip
"""The controls under /dance/output, and others of the whole picture."""
