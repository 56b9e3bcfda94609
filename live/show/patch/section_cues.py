"""Patch sections for what is given by hand: `[[cue]]`, what cues recall, `[[scene]]`, and `[[pad]]`."""

import math
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, model_validator

from live.show.patch.section_base import Measures, Name, Section, Setting, run_check


class SceneSection(Section):
    """`[[scene]]`: values of any parameters, recalled together with a cross-fade by `/dance/scene` or a cue."""

    name: Name
    """Its name."""
    measures: Measures = 2.0
    """Length of the cross-fade in measures, unless the call gives one; 0: at once."""
    set: Annotated[dict[str, Setting], Field(max_length=400)] = Field(default={})
    """Values by the control's address, as in `"/dance/light/level" = 0.2`; for some dancers with their selection after
    the address, as in `"/dance/motion/larger ember & left" = 0.3`; `"/dance/camera" = "a view"` and
    `"/dance/look" = "a look"`."""

    @model_validator(mode="after")
    def _settings_are_valid(self, info: ValidationInfo) -> "SceneSection":
        run_check(info, "scene", self)
        eye, target = (self.set.get(f"/dance/camera/{what}") for what in ("eye", "target"))
        if (
            isinstance(eye, tuple)
            and isinstance(target, tuple)
            and math.dist(map(float, eye), map(float, target)) < 1e-3
        ):
            raise ValueError(
                f"scene {self.name!r}: /dance/camera/eye and /dance/camera/target are the same point: "
                "the camera looks nowhere"
            )
        return self


Value = str | float | bool
Call = Annotated[tuple[Value, ...], Field(min_length=1, max_length=17)]


class CueSection(Section):
    """`[[cue]]`: a scene, a jump in the score and any calls, triggered together by GO (`/dance/go`, Enter)."""

    name: Name
    """Its name, unique among cues."""
    number: Annotated[float, Field(ge=0, le=100000, allow_inf_nan=False)] | None = None
    """A number by which it can be called, too, such as 12.5."""
    text: Annotated[str, Field(max_length=200)] = ""
    """Note for the stage manager, shown while the cue stands by."""
    when: Literal["now", "beat", "measure", "section"] = "measure"
    """When it happens after GO: at once, at the next beat, measure line, or when a section of the score begins."""
    count_in: Annotated[float, Field(ge=0, le=64, allow_inf_nan=False)] = 0.0
    """At least so many beats pass after GO, with a displayed count."""
    scene: Name | None = None
    """The scene that is recalled ..."""
    measures: Measures | None = None
    """... with a cross-fade of so many measures; left out: as the scene says."""
    section: Name | None = None
    """The section of the score to jump to, at the measure line at which the cue happens or the next one."""
    calls: Annotated[tuple[Call, ...], Field(max_length=64)] = ()
    """Controls that are called, in order, by address and values: `[["/dance/step", "jump"], ["/dance/spread", 2]]`."""
    then: Literal["go", "auto"] = "go"
    """The next cue waits for GO, or follows automatically ..."""
    after: Annotated[int, Field(ge=1, le=10000)] | None = None
    """... so many measures later; left out: one."""

    @model_validator(mode="after")
    def _keys_fit(self, info: ValidationInfo) -> "CueSection":
        run_check(info, "cue", self)
        if self.measures is not None and self.scene is None:
            raise ValueError(f"cue {self.name!r}: measures go with scene")
        if self.after is not None and self.then != "auto":
            raise ValueError(f'cue {self.name!r}: after goes with then = "auto"')
        return self


class PadSection(Section):
    """`[[pad]]`: a pad for improvising with settings of its own, launched by `/dance/launch "own NAME"`, in the studio,
    or on a grid controller."""

    name: Name
    """Its name, unique among pads."""
    does: Annotated[str, Field(min_length=1, max_length=250)]
    """What it launches, by kind and name: `step couru`, `phrase opening`, `formation circle`, `element spread`,
    `scene dusk`, `cue 3`."""
    measures: Annotated[int, Field(ge=1, le=1024)] = 4
    """How many measures it lasts."""
    follow: Literal["stop", "again", "next", "first", "other"] = "stop"
    """What follows it: the score again, itself, the next or the first `[[pad]]`, or another one drawn at random
    (seeded)."""
