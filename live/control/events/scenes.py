"""Commands of passes, camera, spots, backgrounds, looks and scenes."""

from typing import Annotated

from live.base.parameter import SPOT_COUNT, WORLD_NAMES
from live.control.events.event import ControlEvent
from live.control.registry.command import FadeMeasures, OwnFadeMeasures, command
from live.control.registry.control import Argument


@command("/dance/pass", "operator", "Switches a pass of the picture on or off, or fades it.", fixed={"parameter": ""},
         arguments={
             "name": Argument.label("a pass: shadow, mirror, focus, blur, trails, bloom, ink, grade, vignette"),
             "amount": Argument.number("its strength; 0 is off", 0, 4),
         })  # fmt: skip
@command("/dance/pass/set", "operator", required=("parameter",), edits="parameters")
class SetPass(ControlEvent):
    """Sets a parameter of a pass; `/dance/pass/NAME/PARAMETER VALUE` does the same."""

    name: Annotated[str, Argument.label("a pass of the picture, also one of the patch", "pass")]
    parameter: Annotated[str, Argument.label("one of its parameters")] = ""
    """Empty: the amount of the pass itself."""
    amount: Annotated[float, Argument.number("the new value, within the parameter's own range", -1e6, 1e6)]
    measures: FadeMeasures = 0.0


@command("/dance/camera", "operator", edits="parameters")
class RecallView(ControlEvent):
    """Cuts or moves to another camera."""

    name: Annotated[str, Argument.label("a [[view]], `start`, `front`, `side`, `top`, `around`, `projector`", "view")]
    measures: FadeMeasures = 0.0


@command("/dance/camera/follow", "operator", edits="parameters")
class Accompany(ControlEvent):
    """The camera follows dancers."""

    whom: Annotated[str, Argument.text("dancers as in `ember & left + 12`; `*` is all, `off` is none", "group")]
    along: Annotated[float, Argument.number("how far the camera moves along: 0 only turns, -1 as before", -1, 1)] = -1.0
    measures: FadeMeasures = 0.0


@command("/dance/spot/follow", "operator")
class FollowSpot(ControlEvent):
    """A follow spot follows dancers."""

    whom: Annotated[str, Argument.text("dancers as in `ember & left + 12`; `*` is all", "group")]
    spot: Annotated[float, Argument.number("which of the follow spots", 1, SPOT_COUNT)] = 1.0
    level: Annotated[float, Argument.number("its brightness", 0, 4)] = 1.0
    measures: FadeMeasures = 0.0


@command("/dance/background", "operator", edits="parameters")
class ShowBackground(ControlEvent):
    """Shows an image, a video or a live input instead of the others at its place: behind the dancers, on the floor, or
    in front of them."""

    name: Annotated[str, Argument.label("a [[background]] of the patch, or `none`", "background")]
    measures: FadeMeasures = 0.0


@command("/dance/title", "operator")
class ShowTitle(ControlEvent):
    """Shows a title from the next beat on, instead of the one before of the same style."""

    text: Annotated[str, Argument.text("a [[title]] of the patch, or any text; | begins a new line", "title")]
    style: Annotated[
        str, Argument.text("the [[title]] whose style it has; *: its own, else the first one", "title")
    ] = "*"


@command("/dance/title/hide", "operator")
class HideTitle(ControlEvent):
    """Lets a title fade out from the next beat on."""

    name: Annotated[str, Argument.text("a [[title]] of the patch, or the text; *: all titles", "title")] = "*"


@command("/dance/look", "operator", edits="parameters")
class RecallLook(ControlEvent):
    """Changes the light to a look."""

    name: Annotated[str, Argument.label("one of the patch's [[looks]]; `start` is its [look]", "look")]
    measures: OwnFadeMeasures = -1.0


@command("/dance/world", "operator", edits="parameters")
class RecallWorld(ControlEvent):
    """Changes to another world, with its light wherever the patch says nothing."""

    name: Annotated[str, Argument.label(f"one of {', '.join(WORLD_NAMES)}", "world")]
    measures: OwnFadeMeasures = -1.0


@command("/dance/scene", "operator", edits="parameters")
class RecallScene(ControlEvent):
    """Recalls a scene with a cross-fade."""

    name: Annotated[
        str, Argument.label("a [[scene]] of the patch or one stored live; `start` is the patch itself", "scene")
    ]
    measures: OwnFadeMeasures = -1.0


@command("/dance/scene/store", "operator", edits="scenes")
class StoreScene(ControlEvent):
    """Stores the current values of all parameters as a scene of this show."""

    name: Annotated[str, Argument.label("the scene's name; an existing scene of this name is replaced", "scene")]
