"""Light, camera, looks and scenes: one control for every parameter of the picture, and what is recalled by name."""

from collections.abc import Callable
from typing import Final

from live.base.picture_parameters import OF_GROUPS, PARAMETERS, SPOTS, PictureParameter
from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import GROUP, Argument, Control

_MEASURES: Final = Argument("measures", "float", "how long it takes; 0 is at once", "measures", 0, 1024, 0.0)
_OWN: Final = Argument(
    "measures", "float", "how long it takes; 0 is at once, -1 as long as it says itself", "measures", -1, 1024, -1.0
)
_NAMES: Final = {
    "number": (("x", "how much"),),
    "colour": (("x", "red, linear"), ("y", "green, linear"), ("z", "blue, linear")),
    "place": (("x", "to the right as the audience sees it"), ("y", "up"), ("z", "towards the audience")),
}


def _set(address: str) -> Callable[..., ControlEvent]:
    def make(*, time: float, source: str, **others: float | str) -> ControlEvent:
        return events.SetPicture(time=time, source=source, parameter=address, **others)  # type: ignore[arg-type]

    return make


def _control(known: PictureParameter) -> Control:
    values = tuple(
        Argument(name, "float", words, known.unit, known.low, known.high) for name, words in _NAMES[known.kind]
    )
    group = (GROUP,) if known.address in OF_GROUPS else ()
    arguments = (*values, *group, _MEASURES)
    return Control(
        known.address, _set(known.address), arguments, known.words, "operator", "continuous", known.size, known.start
    )


SCENE_CONTROLS: Final = (
    *map(_control, (*PARAMETERS, *OF_GROUPS.values())),
    Control(
        "/dance/pass", events.SetPass,
        (
            Argument("name", "name", "a pass of the picture: shadow, mirror, trails, bloom, ink, grade, vignette"),
            Argument("amount", "float", "how much of it is seen; 0 is off", "", 0, 4),
            _MEASURES,
        ),
        "Switches a pass of the picture on or off, or fades it.", "operator",
    ),
    Control(
        "/dance/pass/set", events.SetPass,
        (
            Argument("name", "name", "a pass of the picture, as of the patch's own"),
            Argument("parameter", "name", "one of its parameters"),
            Argument("amount", "float", "the new value, within the parameter's own range", "", -1e6, 1e6),
            _MEASURES,
        ),
        "Sets a parameter of a pass; `/dance/pass/NAME/PARAMETER VALUE` does it, too.", "operator",
    ),
    Control(
        "/dance/camera", events.RecallView,
        (Argument("name", "name", "a [[view]], `start`, `front`, `side`, `top`, `around`, `projector`"), _MEASURES),
        "Cuts or moves to another camera.", "operator",
    ),
    Control(
        "/dance/camera/follow", events.Accompany,
        (
            Argument("whom", "text", "dancers as in `ember & left + 12`; `*` is all, `off` nobody"),
            Argument("along", "float", "how far the camera goes along: 0 only turns, -1 as before", "", -1, 1, -1.0),
            _MEASURES,
        ),
        "The camera follows somebody.", "operator",
    ),
    Control(
        "/dance/spot/follow", events.FollowSpot,
        (
            Argument("whom", "text", "dancers as in `ember & left + 12`; `*` is all"),
            Argument("spot", "float", "which of the follow spots", "", 1, SPOTS, 1.0),
            Argument("level", "float", "how bright it becomes", "", 0, 4, 1.0),
            _MEASURES,
        ),
        "A follow spot goes after somebody.", "operator",
    ),
    Control(
        "/dance/background", events.ShowBackground,
        (Argument("name", "name", "a [[background]] of the patch, or `none`"), _MEASURES),
        "Brings an image or a video behind the dancers; the others go.", "operator",
    ),
    Control(
        "/dance/look", events.RecallLook,
        (Argument("name", "name", "one of the patch's [[looks]]; `start` is its [look]"), _OWN),
        "Changes the light to a look.", "operator",
    ),
    Control(
        "/dance/scene", events.RecallScene,
        (Argument("name", "name", "a [[scene]] of the patch or one stored live; `start` is the patch itself"), _OWN),
        "Recalls a scene with a cross-fade.", "operator",
    ),
    Control(
        "/dance/scene/store", events.StoreScene,
        (Argument("name", "name", "what the scene shall be called; one of this name is replaced"),),
        "Keeps all parameters as they are now, as a scene of this show.", "operator",
    ),
)  # fmt: skip
"""The addresses under /dance/light and /dance/camera, the groups' colours and styles, looks and scenes."""
