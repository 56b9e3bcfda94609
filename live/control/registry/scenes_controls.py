"""Controls of light, camera, looks and scenes: one for each picture parameter, and recall by name."""

from collections.abc import Callable
from typing import Final

from live.base.picture_parameters import GROUP_PARAMETERS, PARAMETERS, SPOT_COUNT, PictureParameter
from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import GROUP, Argument, Control

_MEASURES: Final = Argument("measures", "float", "how long it takes; 0 is at once", "measures", 0, 1024, 0.0)
_OWN_DURATION: Final = Argument(
    "measures", "float", "how long it takes; 0 is at once, -1: its own duration", "measures", -1, 1024, -1.0
)
_COMPONENTS: Final = {
    "number": (("x", "how much"),),
    "colour": (("x", "red, linear"), ("y", "green, linear"), ("z", "blue, linear")),
    "place": (("x", "to the right as seen by the audience"), ("y", "up"), ("z", "towards the audience")),
}


def _set(address: str) -> Callable[..., ControlEvent]:
    def make(*, time: float, source: str, **others: float | str) -> ControlEvent:
        return events.SetPicture(time=time, source=source, parameter=address, **others)  # type: ignore[arg-type]

    return make


def _control(known: PictureParameter) -> Control:
    values = tuple(
        Argument(name, "float", words, known.unit, known.low, known.high) for name, words in _COMPONENTS[known.kind]
    )
    group = (GROUP,) if known.address in GROUP_PARAMETERS else ()
    arguments = (*values, *group, _MEASURES)
    return Control(
        known.address,
        _set(known.address),
        arguments,
        known.description,
        "operator",
        "continuous",
        known.size,
        known.start,
    )


SCENE_CONTROLS: Final = (
    *map(_control, (*PARAMETERS, *GROUP_PARAMETERS.values())),
    Control(
        "/dance/pass", events.SetPass,
        (
            Argument("name", "name", "a pass of the picture: shadow, mirror, trails, bloom, ink, grade, vignette"),
            Argument("amount", "float", "its strength; 0 is off", "", 0, 4),
            _MEASURES,
        ),
        "Switches a pass of the picture on or off, or fades it.", "operator",
    ),
    Control(
        "/dance/pass/set", events.SetPass,
        (
            Argument("name", "name", "a pass of the picture, also one of the patch"),
            Argument("parameter", "name", "one of its parameters"),
            Argument("amount", "float", "the new value, within the parameter's own range", "", -1e6, 1e6),
            _MEASURES,
        ),
        "Sets a parameter of a pass; `/dance/pass/NAME/PARAMETER VALUE` does the same.", "operator",
    ),
    Control(
        "/dance/camera", events.RecallView,
        (Argument("name", "name", "a [[view]], `start`, `front`, `side`, `top`, `around`, `projector`"), _MEASURES),
        "Cuts or moves to another camera.", "operator",
    ),
    Control(
        "/dance/camera/follow", events.Accompany,
        (
            Argument("whom", "text", "dancers as in `ember & left + 12`; `*` is all, `off` is none"),
            Argument("along", "float", "how far the camera moves along: 0 only turns, -1 as before", "", -1, 1, -1.0),
            _MEASURES,
        ),
        "The camera follows dancers.", "operator",
    ),
    Control(
        "/dance/spot/follow", events.FollowSpot,
        (
            Argument("whom", "text", "dancers as in `ember & left + 12`; `*` is all"),
            Argument("spot", "float", "which of the follow spots", "", 1, SPOT_COUNT, 1.0),
            Argument("level", "float", "its brightness", "", 0, 4, 1.0),
            _MEASURES,
        ),
        "A follow spot follows dancers.", "operator",
    ),
    Control(
        "/dance/background", events.ShowBackground,
        (Argument("name", "name", "a [[background]] of the patch, or `none`"), _MEASURES),
        "Shows an image or a video behind the dancers instead of the others.", "operator",
    ),
    Control(
        "/dance/look", events.RecallLook,
        (Argument("name", "name", "one of the patch's [[looks]]; `start` is its [look]"), _OWN_DURATION),
        "Changes the light to a look.", "operator",
    ),
    Control(
        "/dance/scene", events.RecallScene,
        (
            Argument("name", "name", "a [[scene]] of the patch or one stored live; `start` is the patch itself"),
            _OWN_DURATION,
        ),
        "Recalls a scene with a cross-fade.", "operator",
    ),
    Control(
        "/dance/scene/store", events.StoreScene,
        (Argument("name", "name", "the scene's name; an existing scene of this name is replaced"),),
        "Stores the current values of all parameters as a scene of this show.", "operator",
    ),
)  # fmt: skip
"""The controls under /dance/light and /dance/camera, the groups' colours and styles, looks and scenes."""
