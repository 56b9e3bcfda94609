"""Events of steps, motion variation and facing."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class CallStep(ControlEvent):
    """Dancers dance this step from the next free measure on, for a number of measures."""

    name: str
    measures: float = 4.0
    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class StepNow(ControlEvent):
    """Dancers change to this step at the next half beat, within the measure."""

    name: str
    group: str = "*"
    measures: float = 1.0
    """Number of whole measures of it after the current one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetSequence(ControlEvent):
    """Dancers repeat these steps in order, instead of the patch's."""

    steps: str
    """Names separated by commas, as in `live dance --sequence`."""
    group: str = ""
    """One group, or "" for all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepsAdded(ControlEvent):
    """New takes were found in the step folder; they can be danced from the next measure line on."""

    clips: str
    """Their names, one per line."""
    library: str
    """Hash of the library with them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetMotion(ControlEvent):
    """Sets one parameter of motion variation and correction, for one group or (group "") for all."""

    parameter: str
    """A field of `live.show.dancers.variation.VariationSettings`."""
    value: float
    group: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetFacing(ControlEvent):
    """Sets the facing from the next decided measure on, for one group or (group "*") for all."""

    facing: str
    """As in the patch: public, path, centre, attractor, degrees, `dancer 3`, a group."""
    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class Clear(ControlEvent):
    """Ends all attractors, repulsors and spreaders; the patch chooses the steps again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AskWhy(ControlEvent):
    """Selects the dancer whose choice of steps is explained; nothing in the show changes."""

    dancer: int
    """The dancer's number from 1; 0: none."""
