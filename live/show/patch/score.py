"""The score: its sections `[[section]]`, calls at beats `[[at]]`, and signals `[[signal]]` (T015, T016)."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from live.control.events.events import ControlEvent, Signal
from live.control.registry.registry import REGISTRY
from live.show.patch.section_base import Name, Section

Measure = Annotated[int, Field(ge=1, le=100000)]
Beat = Annotated[float, Field(ge=1, lt=33, allow_inf_nan=False)]
Value = str | float | bool


class ScoreSection(Section):
    """`[[section]]`: a part of the score, as a verse or a solo; measures of what belongs to it count from its first."""

    name: Name
    """Every section needs its own."""
    measures: Measure
    """How many measures it has."""
    repeat: Annotated[int, Field(ge=0, le=10000)] = 1
    """How often it is danced before the score goes on; 0: until somebody says so (`/dance/advance`, a cue)."""
    wait: bool = False
    """It comes again until somebody says that the score goes on; as `repeat = 0`."""
    then: Name | None = None
    """The section that comes after it, or `end`; left out: the one below, and the first after the last."""

    @model_validator(mode="after")
    def _one_of_them(self) -> "ScoreSection":
        if self.wait and self.repeat > 1:
            raise ValueError(f"section {self.name!r}: wait and repeat = {self.repeat}: leave one out")
        if self.name.casefold().strip() == "end":
            raise ValueError("no section can be called 'end': that is what `then` says where a score is over")
        return self


class AtSection(Section):
    """`[[at]]`: at a beat of a measure a control is called, a scene recalled or a signal given."""

    measure: Measure
    """The measure, from 1; of its section, if it belongs to one."""
    beat: Beat = 1.0
    """The beat of the measure, from 1; 2.5 is half a beat after the second."""
    section: Name | None = None
    """The section it belongs to; left out: measures count from the beginning of the score."""
    call: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    """The control that is called, by its address, as in `/dance/step`."""
    values: Annotated[tuple[Value, ...], Field(max_length=16)] = ()
    """Its values, as by OSC."""
    scene: Name | None = None
    """Or a scene that is recalled."""
    signal: Name | None = None
    """Or a signal that is given."""

    @model_validator(mode="after")
    def _does_something(self) -> "AtSection":
        if (self.call is not None) + (self.scene is not None) + (self.signal is not None) != 1:
            raise ValueError("one of call, scene and signal expected: what happens")
        if self.values and self.call is None:
            raise ValueError("values go with call")
        made = self.event(0.0)
        if not isinstance(made, ControlEvent):
            raise ValueError(
                f"call {self.call or '/dance/scene'!r} with {list(self.values)!r}: {made}; see docs/osc.md"
            )
        return self

    def event(self, time: float) -> object:
        """What happens: a ControlEvent, for one that was checked."""
        if self.signal is not None:
            return Signal(time=time, source="score", name=self.signal)
        if self.scene is not None:
            return REGISTRY.call("/dance/scene", (self.scene,), time, "score")
        return REGISTRY.call(self.call or "", self.values, time, "score")


class SignalSection(Section):
    """`[[signal]]`: something that happens in the music, by name: in the score, heard, or given by hand."""

    name: Name
    """What `[[react]] on` calls it; several may have one name, and `/dance/signal` gives it too."""
    measure: Measure | None = None
    """A measure with which it comes, from 1; of its section, if it belongs to one."""
    beat: Beat = 1.0
    """The beat of that measure, from 1."""
    section: Name | None = None
    """The section that measure belongs to."""
    on: Literal["drop", "build", "loud", "quiet", "dense", "sparse", "bright", "dark"] | None = None
    """What is heard when it comes: the bass comes back, a build-up begins, or it becomes louder, softer, denser ..."""
    level: Annotated[float, Field(ge=0, le=1)] | None = None
    """From where on that counts, 0 to 1 in the range heard so far; left out: 0.75 of it, 0.25 for what is little."""

    @model_validator(mode="after")
    def _said_where(self) -> "SignalSection":
        if self.section is not None and self.measure is None:
            raise ValueError(f"signal {self.name!r}: section needs measure")
        if self.level is not None and self.on in (None, "drop"):
            raise ValueError(f"signal {self.name!r}: level goes with on = build, loud, quiet, dense, sparse ...")
        return self
