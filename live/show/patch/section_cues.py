"""Patch sections for cues and for what they recall: `[[cue]]`, `[[view]]`, `[[looks]]` and `[[scene]]`."""

import math
from typing import Annotated, Final, Literal

from pydantic import Field, model_validator

from live.base.errors import PersonError
from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY
from live.show.desk.parameter_table import check_setting
from live.show.patch.section_base import Name, Section
from live.show.patch.section_picture import Draw, Setting, check_draw, draw_settings
from live.show.patch.section_stage import CameraSection, LookSection

Measures = Annotated[float, Field(ge=0, le=1024, allow_inf_nan=False)]

LOOK_ADDRESSES: Final = {
    "background": "/dance/light/background",
    "floor": "/dance/light/floor",
    "key_light": "/dance/light/key/colour",
    "key": "/dance/light/key",
    "key_direction": "/dance/light/key/direction",
    "rim_light": "/dance/light/rim/colour",
    "rim": "/dance/light/rim",
    "ambient": "/dance/light/ambient",
    "ambient_colour": "/dance/light/ambient/colour",
    "haze": "/dance/light/haze",
    "level": "/dance/light/level",
    "saturation": "/dance/light/saturation",
    "side": "/dance/light/side",
    "side_left": "/dance/light/side/left",
    "side_right": "/dance/light/side/right",
    "back": "/dance/light/back",
    "back_light": "/dance/light/back/colour",
    "beams": "/dance/light/beams",
    "beams_colour": "/dance/light/beams/colour",
    "beams_width": "/dance/light/beams/width",
    "beams_fan": "/dance/light/beams/fan",
    "beams_sway": "/dance/light/beams/sway",
    "pulse": "/dance/light/pulse",
    "energy": "/dance/light/energy",
    "stage": "/dance/light/stage",
    "gradient": "/dance/background/gradient",
    "gradient_top": "/dance/background/top",
    "gradient_bottom": "/dance/background/bottom",
}
"""The parameter behind each key of a look."""


class ViewSection(CameraSection):
    """`[[view]]`: a further camera, for `/dance/camera` and scenes."""

    name: Name
    """Its name."""


class NamedLookSection(LookSection):
    """`[[looks]]`: a further light setting, for `/dance/look` and scenes; keys left out keep their values."""

    name: Name
    """Its name."""
    measures: Measures = 1.0
    """Length of the cross-fade in measures, unless the call gives one."""
    draw: Draw = Field(default={})
    """How dancers are drawn, as in `[group.draw]`, for all groups or with a group's name behind the key:
    `{ ink = 1, "solid ember" = 0 }`."""

    def settings(self) -> dict[str, Setting]:
        """Return the parameters that it sets, by address."""
        said = {address: getattr(self, key) for key, address in LOOK_ADDRESSES.items()}
        return {address: value for address, value in said.items() if value is not None} | draw_settings(self.draw)

    @model_validator(mode="after")
    def _draw_is_valid(self) -> "NamedLookSection":
        check_draw(self.draw, f"look {self.name!r}")
        return self


class SceneSection(Section):
    """`[[scene]]`: values of any parameters, recalled together with a cross-fade by `/dance/scene` or a cue."""

    name: Name
    """Its name."""
    measures: Measures = 2.0
    """Length of the cross-fade in measures, unless the call gives one; 0: at once."""
    set: Annotated[dict[str, Setting], Field(max_length=400)] = Field(default={})
    """Values by the control's address, as in `"/dance/light/level" = 0.2`; for one group with its name after the
    address, as in `"/dance/motion/larger ember" = 0.3`; `"/dance/camera" = "a view"` and `"/dance/look" = "a look"`."""

    @model_validator(mode="after")
    def _settings_are_valid(self) -> "SceneSection":
        for key, value in self.set.items():
            try:
                check_setting(key, value)
            except PersonError as error:
                raise ValueError(f"scene {self.name!r}: {error}") from None
        eye, target = (self.set.get(f"/dance/camera/{what}") for what in ("eye", "target"))
        if isinstance(eye, tuple) and isinstance(target, tuple) and math.dist(eye, target) < 1e-3:
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
        """Return the events of its scene and calls, in order."""
        made: list[object] = []
        if self.scene is not None:
            fade = () if self.measures is None else (self.measures,)
            made.append(REGISTRY.call("/dance/scene", (self.scene, *fade), time, source))
        made += [REGISTRY.call(str(call[0]), call[1:], time, source) for call in self.calls]
        return [event for event in made if isinstance(event, ControlEvent)]
