"""Cues: `[[cue]]`, what is to happen together when somebody says GO."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY
from live.show.patch.scene import Measures
from live.show.patch.section_base import Name, Section

Value = str | float | bool
Call = Annotated[tuple[Value, ...], Field(min_length=1, max_length=17)]


class CueSection(Section):
    """`[[cue]]`: a scene, a jump in the score and any calls, given together by GO (`/dance/go`, Enter)."""

    name: Name
    """Every cue needs its own."""
    number: Annotated[float, Field(ge=0, le=100000, allow_inf_nan=False)] | None = None
    """A number by which it can be called, too, as in 12.5."""
    text: Annotated[str, Field(max_length=200)] = ""
    """What the stage manager should know about it; shown while it stands by."""
    when: Literal["now", "beat", "measure", "section"] = "measure"
    """When it happens after GO: at once, at the next beat, measure line, or when a section of the score begins."""
    count_in: Annotated[float, Field(ge=0, le=64, allow_inf_nan=False)] = 0.0
    """So many beats pass after GO at least, and are counted."""
    scene: Name | None = None
    """The scene that is recalled ..."""
    measures: Measures | None = None
    """... with a cross-fade of so many measures; left out: as the scene says."""
    section: Name | None = None
    """The section of the score that begins, at the measure line at which the cue happens or the next one."""
    calls: Annotated[tuple[Call, ...], Field(max_length=64)] = ()
    """Controls that are called, in order, by address and values: `[["/dance/step", "jump"], ["/dance/spread", 2]]`."""
    then: Literal["go", "auto"] = "go"
    """The next cue waits for GO, or comes by itself ..."""
    after: Annotated[int, Field(ge=1, le=10000)] | None = None
    """... so many measures later; left out: one."""

    @model_validator(mode="after")
    def _calls_are_known(self) -> "CueSection":
        for call in self.calls:
            made = REGISTRY.call(str(call[0]), call[1:], 0.0, "cue")
            if not isinstance(made, ControlEvent):
                raise ValueError(f"cue {self.name!r}: {call[0]!r} with {list(call[1:])!r}: {made}; see docs/osc.md")
        if self.measures is not None and self.scene is None:
            raise ValueError(f"cue {self.name!r}: measures go with scene")
        if self.after is not None and self.then != "auto":
            raise ValueError(f'cue {self.name!r}: after goes with then = "auto"')
        return self

    def events(self, time: float, source: str) -> list[ControlEvent]:
        """What its scene and calls make, in order."""
        made: list[object] = []
        if self.scene is not None:
            fade = () if self.measures is None else (self.measures,)
            made.append(REGISTRY.call("/dance/scene", (self.scene, *fade), time, source))
        made += [REGISTRY.call(str(call[0]), call[1:], time, source) for call in self.calls]
        return [event for event in made if isinstance(event, ControlEvent)]
