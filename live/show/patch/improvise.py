"""Improvisation in the score: `[[improvise]]`, its rules and what it may do to the group's motion."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY
from live.show.patch.score import Measure, Value
from live.show.patch.section_base import Name, Section, Share

Weight = Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)]
Heard = Literal[
    "energy", "loudness", "density", "brightness", "low", "build", "note_energy", "note_density", "chord", "pitch"
]


class ImproviseRule(Section):
    """`[[improvise.rule]]`: while the music is like that, steps count more, or not at all."""

    of: Heard
    """What is heard, 0 to 1 in the range heard so far; energy is the mean of loudness and density, of
    the music or of notes over MIDI; the last four are of such notes, as in `[[react]]`."""
    above: Share | None = None
    """The rule holds from there on ..."""
    below: Share | None = None
    """... or up to there."""
    favours: Annotated[dict[str, Weight], Field(min_length=1, max_length=1000)]
    """Steps by what their weights are multiplied with: 3 is three times as often, 0 never."""

    @model_validator(mode="after")
    def _says_when(self) -> "ImproviseRule":
        if self.above is None and self.below is None:
            raise ValueError("above or below expected: from where on, or up to where, the rule holds")
        return self


class ImproviseMotion(Section):
    """`[[improvise.motion]]`: something that may be called when a phrase begins, as a formation or an element."""

    weight: Weight = 1.0
    """How likely it is beside the others."""
    call: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    """The control that is called, by its address; left out: nothing is, the motion goes on as it is."""
    values: Annotated[tuple[Value, ...], Field(max_length=16)] = ()
    """Its values, as by OSC."""

    @model_validator(mode="after")
    def _can_be_called(self) -> "ImproviseMotion":
        if self.call is not None and not isinstance(self.event(0.0), ControlEvent):
            raise ValueError(f"call {self.call!r} with {list(self.values)!r}: {self.event(0.0)}; see docs/osc.md")
        return self

    def event(self, time: float) -> object:
        """What the call makes: a ControlEvent, for one that was checked."""
        return REGISTRY.call(self.call or "", self.values, time, "score")


class ImproviseSection(Section):
    """`[[improvise]]`: a group chooses its steps itself, by weights, rules and limits, over some measures."""

    group: Name = "*"
    """The group; * is all, each for itself."""
    section: Name | None = None
    """The section it belongs to; left out: measures of the whole score."""
    measure: Measure = 1
    """The measure with which it begins, from 1."""
    measures: Measure | None = None
    """How many measures it lasts; left out: to the end of its section."""
    steps: dict[str, Weight] = Field(default={})
    """Steps by how likely they are; left out: the group's own, all alike."""
    at_least: Annotated[int, Field(ge=1, le=64)] = 1
    """So many times in a row a step that was chosen is danced at least ..."""
    most: Annotated[int, Field(ge=1, le=1000)] = 2
    """... and never more often than so many times: 2 is never the same step three times."""
    phrase: Annotated[int, Field(ge=1, le=1000)] = 4
    """Measures of a phrase: with each one motion is drawn, and who calls and who answers change."""
    answers: Name | None = None
    """Call and response: in every second phrase this group answers what that other one has danced in the phrase before
    ..."""
    answer: Literal["same", "other"] = "same"
    """... with the same steps, or with those that the other one did not dance."""
    listening: str | None = None
    """The step danced while the other one calls; left out: it goes on improvising."""
    motion: Annotated[tuple[ImproviseMotion, ...], Field(max_length=1000)] = ()
    """What may be called when a phrase begins."""
    rule: Annotated[tuple[ImproviseRule, ...], Field(max_length=64)] = ()
    """What the music favours; where several hold, their factors are multiplied."""

    @model_validator(mode="after")
    def _makes_sense(self) -> "ImproviseSection":
        if self.at_least > self.most:
            raise ValueError(f"at_least {self.at_least} is more than most {self.most}")
        if self.steps and not any(self.steps.values()):
            raise ValueError("steps: all weights are 0, there is nothing to choose")
        if self.motion and not any(item.weight for item in self.motion):
            raise ValueError("motion: all weights are 0, there is nothing to choose")
        if self.answers is not None and self.answers.casefold() == self.group.casefold():
            raise ValueError(f"group {self.group!r} cannot answer itself")
        if self.listening is not None and self.answers is None:
            raise ValueError("listening needs answers: whom it listens to")
        return self
