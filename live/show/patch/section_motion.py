"""Patch sections for groups and their motion: `[locomotion]`, `[motion]`, `[[partner]]`, `[[group]]`, and facings."""

import math
import re
from dataclasses import dataclass
from typing import Annotated, Final, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from live.base.body.catalogue import BODIES
from live.base.errors import PersonError
from live.show.patch.section_base import (
    Colour,
    Draw,
    InvalidEntry,
    Name,
    Place,
    Section,
    Share,
    Size,
    parameter_section,
    run_check,
)


class LocomotionSection(parameter_section("locomotion")):  # type: ignore[misc]
    """`[locomotion]`: transitions between steps, and corrections that keep dancers at their target positions."""

    transition_beats: Annotated[float, Field(gt=0.05, le=1)] = 0.75
    """Length of the blend into the next step, before the measure line (T036)."""
    threshold_m: Annotated[float, Field(gt=0.01, le=2)] = 0.16
    """Largest distance of two poses (root mean square) for a transition."""
    correction_m: Annotated[float, Field(ge=0, le=2)] = 0.8
    """Largest correction of a dancer's position per measure, beyond the step's own travel."""
    turn_deg: Annotated[float, Field(ge=0, le=180)] = 50.0
    """Largest correction of a dancer's heading per measure."""
    weights: dict[str, Annotated[float, Field(ge=0, le=100)]] = Field(default={})
    """Weights of joints when poses are compared, by name; most have 1, hips and feet 2, hands 0.4 (T032)."""
    emphasis: Annotated[float, Field(ge=0, le=1)] = 0.5
    """How much more the pose at the measure line counts than those before it."""


class MotionSection(parameter_section("motion")):  # type: ignore[misc]
    """`[motion]`, or `motion` of a group for that group alone: variation between dancers, and motion clean-up."""


class MoodSection(parameter_section("mood")):  # type: ignore[misc]
    """`[mood]`, or `mood` of a group for that group alone: how steps are danced, along Laban's efforts (T143)."""


DEFAULT_HOLD_TIME: Final = 0.4
"""Default time [s] for which hands must be near to count as held."""
Selection = Annotated[str, Field(min_length=1, max_length=400)]


class PartnerSection(Section):
    """`[[partner]]`: dancers who respond live to a leader, as the followers in the examples do."""

    name: Name
    """Name for `/dance/partner/...` and for signals `unit:...`."""
    leader: Selection
    """The leader: a group, or groups, attributes and numbers as in `ember & 1`; also a dancer driven by live motion.
    `path`: no leader; each follower walks along the path of their own agent, by examples of walks."""
    follower: Selection
    """The followers, likewise: as many as leaders, in their order, or any number for one leader."""
    examples: Annotated[str, Field(min_length=1, max_length=1000)] | None = None
    """A TOML file of pairs (`live docs partners`), looked up in the patch's folder, then in the project's patches; left
    out: the steps of the show, each paired with the step that fits it best."""
    style: Annotated[str, Field(min_length=1, max_length=64)] | None = None
    """Of `examples`, only pairs of this style and those without one are danced; left out: all.
    `/dance/partner/style` changes it."""
    steps: Annotated[tuple[Annotated[str, Field(min_length=1, max_length=100)], ...], Field(max_length=100)] = ()
    """Which of the show's steps to use without `examples`; left out: all, or `walk` along a path."""
    on: bool = True
    """Whether it is active from the beginning."""
    amount: Share = 1.0
    """Blend of the response: 0 is the follower's own steps, 1 the full response."""
    stretch: Annotated[float, Field(ge=0, le=0.4)] = 0.15
    """Largest time by which a unit may begin or end before or after the beat [s]."""
    window: Annotated[float, Field(ge=0, le=0.4)] = 0.04
    """Initial value of that time [s]; `/dance/partner/stretch` changes it."""
    place: Literal["with", "own"] | None = None
    """Where the response is danced: `with` the leader, as in the examples, or at each follower's `own` place, from
    which the response travels; left out: `with` for a follower who has a leader of their own."""
    unit_beats: Annotated[int, Field(ge=1, le=16)] = 2
    """Beats of a unit of the show's steps; a file of pairs gives its own."""
    hands: Share = 1.0
    """Strength of hand holds where the examples have them: 0 none, 1 full, as far as arms reach."""
    hold_distance: Annotated[float, Field(ge=0.02, le=1)] | None = None
    """For pairs without `holds`: hands count as held while their palms are within this distance in the examples [m];
    left out: only the written holds."""
    hold_time: Annotated[float, Field(ge=0.05, le=60)] | None = None
    """For how long they must be so near [s]; left out: 0.4. A hold ends at 1.5 times the distance."""

    @model_validator(mode="after")
    def _style_fits(self) -> Self:
        if self.style is not None and self.examples is None:
            raise InvalidEntry("style without examples: the show's steps have none; name a file of pairs", "style")
        return self

    @model_validator(mode="after")
    def _hold_keys_fit(self) -> Self:
        if self.hold_distance is None and self.hold_time is not None:
            raise InvalidEntry(
                "hold_time without hold_distance: no holds are looked for; give hold_distance", "hold_time"
            )
        if self.hold_distance is not None and (self.led_by_path or self.place == "own"):
            why = 'a follower with leader = "path"' if self.led_by_path else 'a follower with place = "own"'
            raise InvalidEntry(f"{why} holds no hands; leave hold_distance out", "hold_distance")
        return self

    @property
    def hold_limits(self) -> tuple[float, float] | None:
        """Distance [m] and time [s] for which near hands count as held; None if no holds are looked for."""
        return None if self.hold_distance is None else (self.hold_distance, self.hold_time or DEFAULT_HOLD_TIME)

    @property
    def led_by_path(self) -> bool:
        """Whether each follower is led by their own path instead of a leader."""
        return self.leader.strip().casefold() == "path"


PUBLIC: Final = "public"
PATH: Final = "path"
CENTRE: Final = "centre"
ATTRACTOR: Final = "attractor"
DEGREES: Final = "degrees"
DANCER: Final = "dancer"
GROUP: Final = "group"
_FACING_HELP: Final = "public, path, centre, attractor, a number of degrees, `dancer 3`, `group tide`"


@dataclass(frozen=True, slots=True)
class Facing:
    """Where a dancer faces at the end of a measure."""

    kind: str = PUBLIC
    degrees: float = 0.0
    """The heading, for DEGREES: 0 faces the audience, +90 to the right as the audience sees it."""
    dancer: int = 0
    """The dancer to face, for DANCER, from 0."""
    name: str = ""
    """The group, for GROUP."""

    @property
    def heading(self) -> float:
        """The heading [rad], for DEGREES."""
        return math.radians(self.degrees)


def parse_facing(words: str, *, dancers: int, groups: tuple[str, ...]) -> Facing:
    """Parse a facing, for the given number of dancers and group names (casefolded); PersonError if it is invalid."""
    said = " ".join(words.casefold().split())
    if said in (PUBLIC, PATH, CENTRE, ATTRACTOR):
        return Facing(said)
    if re.fullmatch(r"[+-]?[0-9]{1,4}(\.[0-9]{1,6})?", said) and abs(float(said)) <= 360.0:
        return Facing(DEGREES, degrees=float(said))
    if match := re.fullmatch(r"dancer ([0-9]{1,5})", said):
        number = int(match[1])
        if not 1 <= number <= dancers:
            raise PersonError(f"facing {words[:60]!r}: there are dancers 1 to {dancers}")
        return Facing(DANCER, dancer=number - 1)
    name = said.removeprefix("group ").strip()
    if name in groups:
        return Facing(GROUP, name=name)
    raise PersonError(f"facing {words[:60]!r} means nothing", f"possible are {_FACING_HELP}")


_REPEAT_PATTERN = re.compile(r"^(?P<step>.*?)(?:\s+x\s*(?P<times>[0-9]{1,3}))?$")


def parse_entry(entry: str) -> tuple[str, int]:
    """Return step name and number of repeats of an entry like "groove x4"; the default is 1 repeat."""
    match = _REPEAT_PATTERN.match(entry.strip())
    if match is None:
        return entry.strip(), 1
    return match["step"].strip(), int(match["times"] or 1)


class GroupSection(Section):
    """`[[group]]`: dancers with common steps, look and formation."""

    name: Name
    """Its name, unique among groups."""
    dancers: Annotated[int, Field(ge=1, le=10_000)]
    """How many dancers it has."""
    colour: Colour | None = None
    """Colour of their clothes."""
    bodies: Annotated[tuple[Literal[BODIES], ...], Field(min_length=1, max_length=16)] | None = None  # type: ignore[valid-type]
    """Bodies that its dancers get at random: `dancer` (a trained woman), `woman`, `man`, `slim`, `strong`, `round`,
    `child`, `older woman`, `older man`; all have the same joints.
    A name given twice is drawn twice as often. Left out: all have the default body."""
    draw: Draw = Field(default={})
    """Initial drawing style and clothes, as in `{ costume = "dress", ink = 1, ink_width = 3 }`: each key is a control
    at `/dance/draw/` (see `live docs osc`). For some of its dancers a selection stands behind the key:
    `"costume soloist"`."""
    attributes: Annotated[tuple[Name, ...], Field(max_length=64)] = ()
    """Attributes of its dancers ("tall", "red"), by which they can be selected later."""
    soloists: Annotated[int, Field(ge=0, le=10_000)] = 0
    """Number of its first dancers who are soloists: the others give way to them."""
    radius: Annotated[float, Field(ge=0.1, le=1)] = 0.25
    """Radius of its dancers' bodies, for collisions [m]."""
    steps: Annotated[tuple[str, ...], Field(max_length=10000)] = ()
    """Steps in order, repeated from the start after the last; "groove x4" repeats one. With `choose = "random"` the
    set from which steps are drawn. Required, unless the group has `like`."""
    like: Name | None = None
    """It dances the steps of this other group ..."""
    beats_later: Annotated[int, Field(ge=0, le=256)] = 0
    """... so many beats later (a canon) ..."""
    mirrored: bool = False
    """... or as their mirror image, left for right."""
    choose: Literal["sequence", "random"] = "sequence"
    """Steps in their order, or drawn at random (seeded), never the same twice in a row."""
    travel_step: str | None = None
    """The step danced instead when the target is farther away than the next step can travel."""
    facing: Annotated[str, Field(min_length=1, max_length=64)] = "public"
    """Where dancers face when a measure ends: `public`, `path` (along their way), `centre` (of the group), `attractor`
    (the newest for them), degrees (`"30"`: towards +x), `dancer 3`, or a group by name. Turns take three measures.
    Whoever could not get where they should turns otherwise."""
    obedience: Share | None = None
    """Strength of position corrections for its dancers, 0 to 1; left out: as in `[locomotion]`."""
    ripple_beats: Annotated[float, Field(ge=0, le=16)] = 0.0
    """Beats from the first of its dancers to begin a step to the last; 0: all together."""
    ripple: Annotated[str, Field(min_length=1, max_length=60)] = "left"
    """Where the ripple begins: `left`, `right`, `front` or `back` of the stage as the audience sees it, the group's
    `centre`, or a point as in `"0 -2"`."""
    partners: Literal["facing", "beside", "shadow"] | None = None
    """Its members 1 and 2, 3 and 4 ... dance as pairs, who face each other, stand side by side, or one behind the
    other's shoulder; the first of a pair leads. Left out: each dances alone."""
    arm_length: Annotated[float, Field(ge=0.7, le=0.95)] = 0.8
    """Distance between the hips of partners [m]."""
    hands: Literal["both", "one", "none"] = "both"
    """The hands that partners hold when they face each other; side by side they hold at most one."""
    formation: Annotated[str, Field(min_length=1, max_length=250)] = "grid"
    """Initial formation: a `[[formation]]`, or words for one: grid, line, circle, `star:6`, `circle poisson`."""
    centre: Place = (0.0, 0.0)
    """Its middle (x, z) [m]."""
    size: Size = (8.0, 5.0)
    """Width and depth of the formation [m]."""
    motion: MotionSection | None = None
    """Keys as in `[motion]`, for this group alone; keys left out have the values of `[motion]`."""
    mood: MoodSection | None = None
    """Keys as in `[mood]`, for this group alone; keys left out have the values of `[mood]`."""

    @field_validator("steps")
    @classmethod
    def _steps_are_valid(cls, steps: tuple[str, ...]) -> tuple[str, ...]:
        for entry in steps:
            name, times = parse_entry(entry)
            if not name or times < 1:
                raise ValueError(f"{entry!r} is no step: write a step's name, or 'groove x4' to repeat it")
        return steps

    @model_validator(mode="after")
    def _keys_fit(self, info: ValidationInfo) -> "GroupSection":
        if self.like is None and not self.steps:
            raise ValueError(f"group {self.name!r} has nothing to dance: give it steps, or say which group it is like")
        if self.like is not None and self.steps:
            raise ValueError(f"group {self.name!r} has steps and like = {self.like!r}: leave one out")
        if self.like is None and (self.beats_later or self.mirrored):
            raise ValueError(f"group {self.name!r}: beats_later and mirrored need like = another group's name")
        run_check(info, "group", self)
        if self.soloists > self.dancers:
            raise ValueError(f"group {self.name!r} has {self.soloists} soloists and only {self.dancers} dancers")
        return self
