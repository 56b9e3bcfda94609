"""Captured performers: which dancer each of them is, where, how, and what she does to the others."""

from typing import Final

from live.control.events import capture as events
from live.control.registry.control import Argument, Control, X, Z

_WHO: Final = Argument(
    "performer", "name", "her name in the patch; `live` where it names none. Also in the address: /dance/mocap/NAME/..."
)

MOCAP_CONTROLS: Final = (
    Control(
        "/dance/mocap/dancer", events.CastMocap,
        (
            _WHO,
            Argument("dancer", "text", "who is her: the first of `3`, `ember & 1`, a group; none for nobody"),
        ),
        "A captured performer becomes this dancer; whom she was dances on by herself.", "operator",
        "continuous", 1, named=True,
    ),
    Control(
        "/dance/mocap/shown", events.ShowMocap,
        (_WHO, Argument("shown", "bool", "1: the dancer moves as she does, 0: by herself", default=True)),
        "Whether a captured performer is seen; both ways her dancer changes over within a measure.", "musician",
        "continuous", 1, named=True,
    ),
    Control(
        "/dance/mocap/mirrored", events.MirrorMocap,
        (_WHO, Argument("mirrored", "bool", "1: left for right, 0: as she is", default=True)),
        "A captured performer is seen as in a mirror.", "musician", "continuous", 1, named=True,
    ),
    Control(
        "/dance/mocap/place", events.PlaceMocap,
        (
            _WHO, X, Z,
            Argument("turn", "float", "how her floor is turned on the stage, towards +x", "degrees", -360, 360, 0.0),
            Argument("scale", "float", "how long her ways become; feet slide where it is not 1", "", 0, 10, 1.0),
        ),
        "Where the middle of her floor lies on the stage.", "operator", "continuous", 4, named=True,
    ),
    Control(
        "/dance/mocap/canon", events.CanonMocap,
        (
            _WHO,
            Argument("group", "text", "who repeats her: `ember` or `mist & 1-4`; none for nobody", default="none"),
            Argument("beats", "float", "from one who repeats her to the next", "beats", 0, 16, 2.0),
        ),
        "Other dancers repeat a captured performer, the first so many beats later, the second twice as many.",
        "musician", "continuous", 2, named=True,
    ),
    Control(
        "/dance/mocap/obstacle", events.BlockMocap,
        (_WHO, Argument("obstacle", "bool", "1: dancers go out of her way as of somebody real", default=True)),
        "A captured performer is in the others' way.", "operator", "continuous", 1, named=True,
    ),
    Control(
        "/dance/mocap/attract", events.DrawMocap,
        (
            _WHO,
            Argument("strength", "float", "how strongly; below 0 she drives them away, 0: neither", "", -10, 10, 1.0),
            Argument("group", "name", "whom: a group's name; a * is everybody; left out: whom she did", default=""),
        ),
        "A captured performer draws dancers to her.", "musician", "continuous", 2, named=True,
    ),
)  # fmt: skip
