"""`[[react]]`: what the music that is heard changes in the dance, beat by beat or when something happens in it."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from live.control.events import ControlEvent
from live.control.registry import REGISTRY
from live.show.sections.section import Section

Value = Annotated[float, Field(ge=-10, le=10, allow_inf_nan=False)]


class ReactSection(Section):
    """`[[react]]`: either `to` what is heard something is `sets`, or `on` an event something is `call`ed."""

    to: Literal["loudness", "density", "brightness", "low", "build"] | None = None
    """What is followed, 0 to 1 in the range heard so far: loudness, onsets, brightness, bass, how far it builds up."""
    sets: Literal["larger", "amplitude", "mix", "arms", "head", "warp_beats", "strength"] | None = None
    """What follows it: a parameter of `[motion]`, or the strength of elements that begin from then on."""
    low: Value = 0.0
    """Its value when that is 0."""
    high: Value = 1.0
    """Its value when that is 1; it may be the smaller one."""
    beats: Annotated[float, Field(ge=0, le=64)] = 4.0
    """Beats over which it is smoothed."""
    group: Annotated[str, Field(min_length=1, max_length=64)] = "*"
    """The group whose motion it is; * is all."""
    on: Annotated[str, Field(min_length=1, max_length=64)] | None = None
    """What happens: `drop`, the bass comes back after a build-up or a break; `build`, a build-up begins; or a signal,
    as a `[[signal]]` names it."""
    when: Literal["measure", "beat", "now"] = "measure"
    """When it is called: at the next measure line, at the next beat, or at once."""
    call: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    """The control that is called, by its address, as in `/dance/step`."""
    values: Annotated[tuple[str | float | bool, ...], Field(max_length=16)] = ()
    """Its values, as by OSC."""

    @model_validator(mode="after")
    def _one_or_the_other(self) -> "ReactSection":
        if (self.to is None) != (self.sets is None) or (self.on is None) != (self.call is None):
            raise ValueError("`to` goes with `sets`, and `on` with `call`")
        if (self.to is None) == (self.on is None):
            raise ValueError("either `to` and `sets`, or `on` and `call` expected")
        if self.call is not None and not isinstance(self.event(0.0), ControlEvent):
            raise ValueError(f"call {self.call!r} with {list(self.values)!r}: {self.event(0.0)}; see docs/osc.md")
        return self

    def event(self, time: float) -> object:
        """What the call makes: a ControlEvent, for one that was checked."""
        return REGISTRY.call(self.call or "", self.values, time, "music")
