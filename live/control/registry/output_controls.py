"""The picture as a whole, and the projectors that it goes to."""

from typing import Final

from live.control.events import events
from live.control.registry.control import Argument, Control

OUTPUT_CONTROLS: Final = (
    Control(
        "/dance/output/fade", events.FadePicture,
        (
            Argument("level", "float", "share of the light that is left", "", 0, 1),
            Argument("beats", "float", "how long it takes; 0 is at once, but no flash", "beats", 0, 1024, 4.0),
        ),
        "Fades the whole picture out, in, or to any level; no scene, cue or panic changes it.",
        "operator", "continuous", 1, (1.0,),
    ),
    Control(
        "/dance/output/freeze", events.FreezePicture,
        (Argument("on", "bool", "1: the picture stands still, 0: it goes on", default=True),),
        "Freezes the picture; the dance goes on unseen, blackout and fade still work.",
        "operator", "continuous", 1, (False,),
    ),
    Control(
        "/dance/output/flashes", events.AllowFlashes,
        (Argument("on", "bool", "1: as many as the show makes, 0: at most three a second"),),
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
        (Argument("step", "float", "0: the best; -1: as the machine can afford", "", -1, 15, -1.0),),
        "Holds a step of the picture's quality; the status says which there are.", "operator",
    ),
)  # fmt: skip
"""The addresses under /dance/output, and what else concerns the picture as a whole."""
