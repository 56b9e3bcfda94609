"""Commands of steps and facing, and additions to the step library."""

from dataclasses import dataclass
from typing import Annotated

from live.base.body.hand_shapes import SHAPE_NAMES
from live.control.events.event import ControlEvent
from live.control.registry.command import Dancers, Measures, StepName, command
from live.control.registry.control import Argument


@command("/dance/clear", "operator")
class Clear(ControlEvent):
    """Ends all elements and evolutions; the patch chooses the steps again."""


@command("/dance/step", "musician")
class CallStep(ControlEvent):
    """Dancers dance this step from the next free measure on."""

    name: StepName
    measures: Measures = 4.0
    group: Dancers = "*"


@command("/dance/now", "musician")
class StepNow(ControlEvent):
    """Dancers change to this step at the next half beat, without losing the beat."""

    name: StepName
    group: Dancers = "*"
    measures: Annotated[
        float, Argument.number("how long they keep dancing it after the current measure", 0, 1024, "measures")
    ] = 1.0


@command("/dance/sequence", "musician", edits="sequences")
class SetSequence(ControlEvent):
    """Dancers repeat these steps in order until /dance/clear; refused, with the dance unchanged, if no transitions
    connect them."""

    steps: Annotated[str, Argument.text('names separated by commas, as "couru, couru left, echappe x2, *"', "step")]
    group: Dancers = "*"


@command("/dance/facing", "musician", edits="facings")
class SetFacing(ControlEvent):
    """The direction that dancers face when their measures end; a turn takes three measures."""

    facing: Annotated[str, Argument.text("public, path, centre, attractor, degrees as `30`, `dancer 3`, or a group")]
    group: Dancers = "*"


@command("/dance/hands", "musician")
class SetHands(ControlEvent):
    """Dancers' hands take this shape for a while, whatever their steps say."""

    group: Dancers
    shape: Annotated[str, Argument.label(f"the shape: {', '.join(SHAPE_NAMES)}; auto: that of the step again")]
    measures: Measures = 4.0


@command("/dance/why", "operator")
class AskWhy(ControlEvent):
    """Shows in status and overlay the dancer's targets, the chosen step and the runners-up."""

    dancer: Annotated[int, Argument.number("the dancer's number from 1; 0: none", 0, 100000)] = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class StepsAdded(ControlEvent):
    """New takes were found in the step folder; they can be danced from the next measure line on."""

    clips: str
    """Their names, one per line."""
    library: str
    """Hash of the library with them."""
