"""Groups of dancers: `[[group]]`."""

import re
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from live.base.bodies import BODIES
from live.show.patch.draw import Draw, check_drawn
from live.show.patch.motion import MotionSection
from live.show.patch.section_base import Colour, Name, Place, Section, Share, Size

_REPEATED = re.compile(r"^(?P<step>.*?)(?:\s+x\s*(?P<times>[0-9]{1,3}))?$")


def parse_entry(entry: str) -> tuple[str, int]:
    """Step name and number of repeats of an entry like "groove x4"; repeats are 1 if none are given."""
    match = _REPEATED.match(entry.strip())
    if match is None:
        return entry.strip(), 1
    return match["step"].strip(), int(match["times"] or 1)


class GroupSection(Section):
    """`[[group]]`: some dancers who dance alike."""

    name: Name
    """Every group needs its own."""
    dancers: Annotated[int, Field(ge=1, le=4000)]
    """How many dancers it has."""
    colour: Colour | None = None
    """Colour of their clothes."""
    bodies: Annotated[tuple[Literal[BODIES], ...], Field(min_length=1, max_length=16)] | None = None  # type: ignore[valid-type]
    """The bodies that its dancers have by chance: `dancer`, `slim`, `strong`, `round`, `child`; joints are the same in
    all. A name that stands twice is drawn twice as often. Left out: everybody has the usual one."""
    draw: Draw = Field(default={})
    """How it is drawn at first, as in `{ solid = 0, ink = 1, ink_width = 3 }`: each key is a control at `/dance/draw/`
    (see [osc.md](osc.md))."""
    attributes: Annotated[tuple[Name, ...], Field(max_length=64)] = ()
    """Words for its dancers ("tall", "red"), by which they can be chosen later."""
    soloists: Annotated[int, Field(ge=0, le=4000)] = 0
    """So many of its dancers, the first ones, are soloists: the others give way to them."""
    radius: Annotated[float, Field(ge=0.1, le=1)] = 0.25
    """How wide its dancers' bodies are around their middle [m]."""
    steps: Annotated[tuple[str, ...], Field(max_length=10000)] = ()
    """Steps in order, one after the other and again from the start; "groove x4" repeats one. With
    `choose = "random"` the set from which steps are drawn. Needed, unless the group dances like another."""
    like: Name | None = None
    """It dances the steps of this other group ..."""
    beats_later: Annotated[int, Field(ge=0, le=256)] = 0
    """... so many beats later (a canon) ..."""
    mirrored: bool = False
    """... or as their mirror image, left for right."""
    choose: Literal["sequence", "random"] = "sequence"
    """Steps in their order, or drawn by seeded chance, never the same twice in a row."""
    travel_step: str | None = None
    """The step danced instead when the way is farther than the step in turn can go."""
    facing: Annotated[str, Field(min_length=1, max_length=64)] = "public"
    """Where dancers face when a measure ends: `public`, `path` (along their way), `centre` (of the group), `attractor`
    (the newest for them), degrees (`"30"`: towards +x), `dancer 3`, or a group by name. Turns take three measures."""
    obedience: Share | None = None
    """How far its dancers are carried beyond their steps, 0 to 1; if left out as in `[locomotion]`."""
    ripple_beats: Annotated[float, Field(ge=0, le=16)] = 0.0
    """So many beats pass from the first of its dancers who begins a step to the last; 0: all together."""
    ripple: Annotated[str, Field(min_length=1, max_length=60)] = "left"
    """Where that begins: `left`, `right`, `front` or `back` of the stage as the audience sees it, the group's `centre`,
    or a point as in `"0 -2"`."""
    partners: Literal["facing", "beside", "shadow"] | None = None
    """Its members 1 and 2, 3 and 4 ... dance as pairs, who face each other, stand side by side, or one behind the
    other's shoulder; the first of a pair leads. Left out: everybody dances alone."""
    arm_length: Annotated[float, Field(ge=0.7, le=0.95)] = 0.8
    """How far apart the hips of partners are [m]."""
    hands: Literal["both", "one", "none"] = "both"
    """The hands that partners who face each other hold; side by side there is one to hold."""
    formation: Annotated[str, Field(min_length=1, max_length=250)] = "grid"
    """Where the group begins: a `[[formation]]`, or words for one: grid, line, circle, `star:6`, `circle poisson`."""
    centre: Place = (0.0, 0.0)
    """Its middle (x, z) [m]."""
    size: Size = (8.0, 5.0)
    """Width and depth of the formation [m]."""
    motion: MotionSection | None = None
    """Keys as in `[motion]`, for this group alone; what is left out is as there."""

    @field_validator("steps")
    @classmethod
    def _known_form(cls, steps: tuple[str, ...]) -> tuple[str, ...]:
        for entry in steps:
            name, times = parse_entry(entry)
            if not name or times < 1:
                raise ValueError(f"{entry!r} is no step: write a step's name, or 'groove x4' to repeat it")
        return steps

    @model_validator(mode="after")
    def _dances_something(self) -> "GroupSection":
        if self.like is None and not self.steps:
            raise ValueError(f"group {self.name!r} has nothing to dance: give it steps, or say which group it is like")
        if self.like is not None and self.steps:
            raise ValueError(f"group {self.name!r} has steps of its own and is like {self.like!r}: leave one out")
        if self.like is None and (self.beats_later or self.mirrored):
            raise ValueError(f"group {self.name!r}: beats_later and mirrored need like = another group's name")
        check_drawn(self.draw, f"group {self.name!r}")
        for key in self.draw:
            if " " in key.strip():
                raise ValueError(f"group {self.name!r}: draw {key!r}: no group's name belongs behind it here")
        if self.soloists > self.dancers:
            raise ValueError(f"group {self.name!r} has {self.soloists} soloists and only {self.dancers} dancers")
        return self
