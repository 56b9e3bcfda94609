"""Controls of procedural elements: attractors, repulsors, spreaders, crossings, flows and so on (T105-T110, T132)."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final, get_args

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry import command
from live.control.registry.control import Argument, Control


def _argument(annotation: Any, name: str, default: float | str | bool | None = None) -> Argument:
    """Return the argument of a shared annotation, with its name."""
    found: Argument = get_args(annotation)[1]
    return replace(found, name=name, default=default)


X, Z, X2, Z2 = (
    _argument(each, name)
    for each, name in zip((command.X, command.Z, command.X2, command.Z2), ("x", "z", "x2", "z2"), strict=True)
)
STRENGTH, MEASURES = _argument(command.Strength, "strength", 1.0), _argument(command.Measures, "measures", 4.0)
DANCERS, NEXT, POINTS = (
    _argument(command.Dancers, "group", "*"),
    _argument(command.Next, "next", False),
    _argument(command.Points, "points"),
)
_USUAL: Final = (STRENGTH, MEASURES, DANCERS, NEXT)
_RADIUS: Final = Argument("radius", "float", "radius of the region", "m", 0.1, 50)
_TURN: Final = Argument("strength", "float", "how strongly it acts; below 0: in reverse", "", -10, 10, 1.0)
_WHOM: Final = Argument("whom", "name", "a dancer's number from 1, or the name of a group")


def _place(kind: str, *, flow: str = "", closed: bool = False) -> Callable[..., ControlEvent]:
    """Return the event constructor that places an element of a kind, for the arguments of its control."""

    def make(
        *,
        time: float,
        source: str,
        x: float | None = None,
        z: float = 0.0,
        x2: float | None = None,
        z2: float = 0.0,
        points: str = "",
        **others: float | bool | str,
    ) -> ControlEvent:
        if x is not None:
            points = f"{x!r} {z!r}" + ("" if x2 is None else f", {x2!r} {z2!r}")
        return events.PlaceElement(
            time=time,
            source=source,
            kind=kind,
            flow=flow,
            closed=closed,
            points=points,
            **others,  # type: ignore[arg-type]
        )

    return make  # fmt: skip


ELEMENT_CONTROLS: Final = (
    Control(
        "/dance/attract", events.Attract, (X, Z, *_USUAL), "Dancers gather around a point of the stage.", "audience",
    ),
    Control(
        "/dance/attract/line", _place("attract"), (X, Z, X2, Z2, *_USUAL), "Dancers gather along a line.", "musician",
    ),
    Control(
        "/dance/attract/drawn", _place("attract"), (POINTS, *_USUAL), "Dancers gather along a drawn line.", "musician",
    ),
    Control(
        "/dance/attract/region", _place("attract"), (X, Z, _RADIUS, *_USUAL),
        "Dancers come into a region; inside it they move freely.", "musician",
    ),
    Control(
        "/dance/voice", events.Voice, (X, Z),
        "One voice of an audience: dancers go to places with many voices, never to a single one. Each sender has one "
        "voice; it fades after two measures unless it is sent again.", "audience", "continuous",
    ),
    Control(
        "/dance/repel", events.Repel, (X, Z, *_USUAL), "Dancers move away from a point.", "musician",
    ),
    Control(
        "/dance/repel/line", _place("repel"), (X, Z, X2, Z2, *_USUAL),
        "Dancers move away from a line.", "musician",
    ),
    Control(
        "/dance/repel/region", _place("repel"), (X, Z, _RADIUS, *_USUAL), "Dancers leave a region.", "musician",
    ),
    Control("/dance/spread", events.Spread, (MEASURES, DANCERS, NEXT), "Dancers spread over the stage.", "musician"),
    Control(
        "/dance/cross", _place("cross"), (X, Z, X2, Z2, *_USUAL),
        "Dancers cross a line through two points: each side changes to the other.", "musician",
    ),
    Control(
        "/dance/flow", _place("flow", flow="uniform"), (X, Z, X2, Z2, *_USUAL),
        "Dancers go in the direction from the first point to the second, everywhere on the stage.", "musician",
    ),
    Control(
        "/dance/flow/radial", _place("flow", flow="radial"), (X, Z, _TURN, MEASURES, DANCERS, NEXT),
        "Dancers go away from a point; with a strength below 0 towards it.", "musician",
    ),
    Control(
        "/dance/flow/vortex", _place("flow", flow="vortex"), (X, Z, _TURN, MEASURES, DANCERS, NEXT),
        "Dancers go around a point.", "musician",
    ),
    Control(
        "/dance/flow/drawn", _place("flow", flow="drawn"), (POINTS, *_USUAL),
        "Dancers go in the direction of a drawn line.", "musician",
    ),
    Control(
        "/dance/path", _place("path"), (POINTS, *_USUAL), "Dancers follow a drawn path.", "musician",
    ),
    Control("/dance/wander", _place("wander"), _USUAL, "Dancers wander.", "musician"),
    Control("/dance/flock", _place("flock"), _USUAL, "Dancers move together, like birds in a flock.", "musician"),
    Control("/dance/follow", _place("follow"), (_WHOM, *_USUAL), "Dancers follow a leader.", "musician"),
    Control("/dance/pursue", _place("pursue"), (_WHOM, *_USUAL), "Dancers pursue a dancer or group.", "musician"),
    Control("/dance/evade", _place("evade"), (_WHOM, *_USUAL), "Dancers evade a dancer or group.", "musician"),
)  # fmt: skip
