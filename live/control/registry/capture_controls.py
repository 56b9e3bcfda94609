"""Controls of captured performers: their dancer, their place, and their effect on other dancers."""

from typing import Final

from live.control.events import capture as events
from live.control.registry.control import Argument, Control, X, Z

_WHO: Final = Argument(
    "performer", "name", "the name in the patch; `live` if it has none. Also in the address: /dance/mocap/NAME/..."
)

MOCAP_CONTROLS: Final = (
    Control(
        "/dance/mocap/dancer", events.CastMocap,
        (
            _WHO,
            Argument("dancer", "text", "the dancer, or the first of `ember & 1` or a group; none: no dancer"),
        ),
        "A captured performer drives this dancer; the former one dances by themselves again.", "operator",
        "continuous", 1, named=True,
    ),
    Control(
        "/dance/mocap/shown", events.ShowMocap,
        (_WHO, Argument("shown", "bool", "1: the dancer moves as the performer does, 0: by themselves", default=True)),
        "Whether a captured performer is shown; the dancer changes over within a measure.", "musician",
        "continuous", 1, named=True,
    ),
    Control(
        "/dance/mocap/mirrored", events.MirrorMocap,
        (_WHO, Argument("mirrored", "bool", "1: left and right exchanged, 0: as captured", default=True)),
        "Mirrors a captured performer.", "musician", "continuous", 1, named=True,
    ),
    Control(
        "/dance/mocap/place", events.PlaceMocap,
        (
            _WHO, X, Z,
            Argument("turn", "float", "rotation of the floor on the stage, towards +x", "degrees", -360, 360, 0.0),
            Argument("scale", "float", "scale of the paths; feet slide unless it is 1", "", 0, 10, 1.0),
        ),
        "Place of the capture floor's centre on the stage.", "operator", "continuous", 4, named=True,
    ),
    Control(
        "/dance/mocap/canon", events.CanonMocap,
        (
            _WHO,
            Argument("group", "text", "dancers that repeat: `ember` or `mist & 1-4`; none: nobody", default="none"),
            Argument("beats", "float", "delay from one dancer to the next", "beats", 0, 16, 2.0),
        ),
        "Other dancers repeat a captured performer in canon: the first by that delay, the second by twice as much.",
        "musician", "continuous", 2, named=True,
    ),
    Control(
        "/dance/mocap/obstacle", events.BlockMocap,
        (_WHO, Argument("obstacle", "bool", "1: dancers avoid the performer as a real person, 0: not", default=True)),
        "Whether a captured performer is an obstacle for other dancers.", "operator", "continuous", 1, named=True,
    ),
    Control(
        "/dance/mocap/attract", events.DrawMocap,
        (
            _WHO,
            Argument("strength", "float", "how strongly; below 0: repels, 0: no effect", "", -10, 10, 1.0),
            Argument("group", "name", "a group's name; * is all; left out: unchanged", default=""),
        ),
        "A captured performer attracts dancers.", "musician", "continuous", 2, named=True,
    ),
)  # fmt: skip
