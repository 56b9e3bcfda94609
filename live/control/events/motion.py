"""Events about what dancers dance, how they vary it, and where they look."""

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
    """Dancers leave what they dance for this step at the next half beat, within the measure."""

    name: str
    group: str = "*"
    measures: float = 1.0
    """How many whole measures they stay in it after the one that runs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetSequence(ControlEvent):
    """Dancers dance these steps in order, again and again, instead of the patch's."""

    steps: str
    """Names with commas between them, as in `live dance --sequence`."""
    group: str = ""
    """One group, or "" for all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepsAdded(ControlEvent):
    """New takes were found in the folder of steps: they join the dance at the next measure line."""

    clips: str
    """Which, a line each."""
    library: str
    """Hash of the library with them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetMotion(ControlEvent):
    """How dancers vary and how motion is mended: one parameter, for one group or (group "") for all."""

    parameter: str
    """A field of `live.show.dancers.variation.Variety`."""
    value: float
    group: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetFacing(ControlEvent):
    """Where dancers look from their next decided measure on, for one group or (group "*") for all."""

    facing: str
    """Words as in the patch: public, path, centre, attractor, degrees, `dancer 3`, a group."""
    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class Clear(ControlEvent):
    """All attractors, repulsors and spreaders end, and the patch chooses the steps again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AskWhy(ControlEvent):
    """Somebody wants to see why a dancer dances what she dances; nothing in the show changes."""

    dancer: int
    """Her number from 1; 0: nobody any more."""
