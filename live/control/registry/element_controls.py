"""Controls of procedural elements, made from their rows (`live.base.element_kinds`)."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final, get_args

from live.base.element_kinds import ELEMENT_KINDS, ElementControl, ElementKind
from live.control.events.elements import PlaceElement, Points
from live.control.events.event import ControlEvent
from live.control.registry import command
from live.control.registry.control import Argument, ArgumentValue, Control

VOICE_MEASURES: Final = 2.0
"""Duration of an audience voice's element if it is not repeated [measures]."""


def _argument(annotation: Any, name: str, default: ArgumentValue | None = None) -> Argument:
    """Return the argument of a shared annotation, with its name."""
    found: Argument = get_args(annotation)[1]
    return replace(found, name=name, default=default)


_POINT: Final = (_argument(command.X, "x"), _argument(command.Z, "z"))
_PLACES: Final[dict[str, tuple[Argument, ...]]] = {
    "none": (),
    "point": _POINT,
    "line": (*_POINT, _argument(command.X2, "x2"), _argument(command.Z2, "z2")),
    "drawn": (_argument(command.Points, "points"),),
    "region": (*_POINT, Argument("radius", "float", "radius of the region", "m", 0.1, 50)),
    "target": (Argument("whom", "name", "a dancer's number from 1, or the name of a group", names="group"),),
}
"""Arguments by what an address is told about the place."""
_STRENGTH: Final = _argument(command.Strength, "strength", 1.0)
_REVERSIBLE: Final = replace(_STRENGTH, description="how strongly it acts; below 0: in reverse", minimum=-10)
_USUAL: Final = (
    _argument(command.Measures, "measures", 4.0), _argument(command.Dancers, "group", "*"),
    _argument(command.Next, "next", False),
)  # fmt: skip


def _maker(kind: str, flow: str = "") -> Callable[..., ControlEvent]:
    """Return the function that makes the event of an element from the arguments of its control."""

    def make(
        *, time: float, source: str, x: float | None = None, z: float = 0.0, x2: float | None = None, z2: float = 0.0,
        points: Points = ((0.0, 0.0),), **others: Any,
    ) -> ControlEvent:  # fmt: skip
        if x is not None:
            points = ((x, z),) if x2 is None else ((x, z), (x2, z2))
        return PlaceElement(time=time, source=source, kind=kind, flow=flow, points=points, **others)

    return make


def _voice(*, time: float, source: str, x: float, z: float) -> ControlEvent:
    return PlaceElement(
        time=time, source=source, kind="attract", points=((x, z),), measures=VOICE_MEASURES, fair=True, drag=True
    )


def _control(kind: ElementKind, form: ElementControl) -> Control:
    strength = (_REVERSIBLE if form.reversible else _STRENGTH,) if form.has_strength else ()
    return Control(
        "/".join(filter(None, ("/dance", kind.name, form.suffix))), _maker(kind.name, form.flow),
        (*_PLACES[form.place], *strength, *_USUAL), form.description, form.role,
    )  # fmt: skip


ELEMENT_CONTROLS: Final = (
    *(_control(kind, form) for kind in ELEMENT_KINDS for form in kind.controls),
    Control(
        "/dance/voice", _voice, _POINT,
        "One voice of an audience: dancers go to places with many voices, never to a single one. Each sender has one "
        "voice; it fades after two measures unless it is sent again.", "audience", "continuous",
    ),
)  # fmt: skip
"""The controls that place elements."""
