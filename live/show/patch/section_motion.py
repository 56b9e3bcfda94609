"""How steps are joined and varied: `[locomotion]` and `[motion]`.

A partner on the stage: `[[partner]]`.

Facing: where the dancers of a group look, in a few words, in the patch and live.

Groups of dancers: `[[group]]`.
"""

import math
import re
from dataclasses import dataclass
from typing import Annotated, Final, Literal, Self

from pydantic import Field, field_validator, model_validator

from live.base.body_catalogue import BODIES
from live.base.errors import PersonError
from live.show.patch.section_base import Amiss, Colour, Name, Place, Section, Share, Size
from live.show.patch.section_picture import Draw, check_drawn


class LocomotionSection(Section):
    """`[locomotion]`: how steps are joined and how dancers are kept where the group wants them."""

    transition_beats: Annotated[float, Field(gt=0.05, le=1)] = 0.75
    """Length of the blend into the next step, before the measure line (T036)."""
    threshold_m: Annotated[float, Field(gt=0.01, le=2)] = 0.16
    """How far apart two poses may be (root of the mean squared distance) to be joined."""
    correction_m: Annotated[float, Field(ge=0, le=2)] = 0.35
    """How far a dancer may be carried beyond the step's own way within one measure."""
    turn_deg: Annotated[float, Field(ge=0, le=180)] = 50.0
    """How far she may be turned beyond it within one measure."""
    obedience: Share = 0.5
    """0: steps are danced faithfully and dancers are carried beyond them little; 1: they are carried to where the group
    wants them as far as legs reach, within the measure, too."""
    weights: dict[str, Annotated[float, Field(ge=0, le=100)]] = Field(default={})
    """How much joints count when poses are compared, by name; most count 1, hips and feet 2, hands 0.4 (T032)."""
    emphasis: Annotated[float, Field(ge=0, le=1)] = 0.5
    """How much more the pose at the measure line counts than those before it."""


class MotionSection(Section):
    """`[motion]`, or `motion` of a group for that group alone: how much dancers differ, and how motion is mended."""

    warp_beats: Annotated[float, Field(ge=0, le=1)] = 0.1
    """Dancers are ahead of the beat or behind it by this many beats at most, each in her own way (T055)."""
    warp_over: Literal["measure", "sequence"] = "measure"
    """Back on the beat at every measure line, or drifting slowly over several measures (T056)."""
    larger: Annotated[float, Field(ge=-0.7, le=0.5)] = 0.0
    """The upper body moves more than recorded by this share (below 0: less), everybody's alike."""
    amplitude: Annotated[float, Field(ge=0, le=0.5)] = 0.15
    """The upper body moves more or less than recorded by this share (T058)."""
    amplitude_over: Literal["measure", "sequence"] = "measure"
    """Drawn anew for every measure (T060), or changing slowly over several (T059)."""
    mix: Share = 0.0
    """How far another take of the same step is mixed into the whole body at most, drawn for every measure (T045)."""
    arms: Share = 0.0
    """Share of the dancers whose upper body dances another take of the same step (T044)."""
    texture: Share = 0.0
    """How far upper bodies are those of the recordings in `[texture]`, chosen beat by beat by what legs do; 0: as the
    steps have it."""
    head: Share = 0.0
    """How far heads turn to the public, as far as necks allow (T123-T125)."""
    foot_lock: bool = True
    """Feet that carry stay where they are, and no sole goes below the floor."""
    turn_on: Literal["support", "measure"] = "support"
    """Dancers turn on the foot that carries (T048-T050), or evenly over the measure."""
    face: Literal["end", "average"] = "end"
    """What is brought to the wanted heading: the end of each measure, or its average (T122)."""
    mirror: Literal["both", "never", "only"] = "both"
    """Steps and their mirror images, only as they were made, or only mirrored where there are mirror images (T042)."""


LONG: Final = 0.4
"""For how long [s] hands are near that count as held, where the patch does not say."""
Who = Annotated[str, Field(min_length=1, max_length=400)]


class PartnerSection(Section):
    """`[[partner]]`: dancers who answer a leader, live, as the followers of examples have answered theirs."""

    name: Name
    """What the two are called by `/dance/partner/...`, and by signals `unit:...`."""
    leader: Who
    """Who leads: a group, or groups, attributes and numbers as in `ember & 1`; any dancer, one of live motion, too.
    `path`: nobody; each follower walks along the way of her own agent, by examples of walks."""
    follower: Who
    """Who answers, likewise: as many as lead, in their order, or all of them one leader."""
    examples: Annotated[str, Field(min_length=1, max_length=1000)] | None = None
    """A TOML file of pairs (docs/partner.md), looked up in the patch's folder, then in the project's patches; left out:
    the steps of the show, each followed by the one that goes along with it best."""
    steps: Annotated[tuple[Annotated[str, Field(min_length=1, max_length=100)], ...], Field(max_length=100)] = ()
    """Which of the show's steps, where there are no `examples`; left out: all, and `walk` along a way."""
    on: bool = True
    """Whether they begin at once."""
    amount: Share = 1.0
    """How far the answer is in: 0 her own steps, 1 all answer."""
    stretch: Annotated[float, Field(ge=0, le=0.4)] = 0.15
    """How much earlier or later than the beat a unit may begin or end at most [s]."""
    window: Annotated[float, Field(ge=0, le=0.4)] = 0.04
    """How much earlier or later it may do so at first [s]; `/dance/partner/stretch` changes it."""
    place: Literal["with", "own"] | None = None
    """Where the answer is danced: `with` the leader, as in the examples, or each follower at her `own` place, from
    where she goes as the answer goes; left out: with the leader by who has one of her own."""
    unit_beats: Annotated[int, Field(ge=1, le=16)] = 2
    """Beats of a unit of the show's steps; a file of pairs says its own."""
    hands: Share = 1.0
    """How far hands are held where those of the examples are: 0 as they are danced, 1 held, as far as arms reach."""
    hold_distance: Annotated[float, Field(ge=0.02, le=1)] | None = None
    """Where a pair says no `holds`: hands count as held whose palms are within this of each other in the examples [m];
    left out: only what is written down is held."""
    hold_time: Annotated[float, Field(ge=0.05, le=60)] | None = None
    """For how long they must be so near [s], 0.4 if left out; a hold lasts until they are half as far again apart."""

    @model_validator(mode="after")
    def _somebody_to_hold(self) -> Self:
        if self.hold_distance is None and self.hold_time is not None:
            raise Amiss("hold_time without hold_distance: no holds are looked for; say how near hands are", "hold_time")
        if self.hold_distance is not None and (self.by_path or self.place == "own"):
            why = "who is led by her own way" if self.by_path else 'who dances at her own place (place = "own")'
            raise Amiss(f"{why} holds nobody's hands; leave hold_distance out", "hold_distance")
        return self

    @property
    def near(self) -> tuple[float, float] | None:
        """How near [m] for how long [s] hands are that count as held, None where nothing is looked for."""
        return None if self.hold_distance is None else (self.hold_distance, self.hold_time or LONG)

    @property
    def by_path(self) -> bool:
        """Whether nobody leads but each follower's own way."""
        return self.leader.strip().casefold() == "path"


PUBLIC: Final = "public"
PATH: Final = "path"
CENTRE: Final = "centre"
ATTRACTOR: Final = "attractor"
DEGREES: Final = "degrees"
DANCER: Final = "dancer"
GROUP: Final = "group"
_WAYS: Final = "public, path, centre, attractor, a number of degrees, `dancer 3`, `group tide`"


@dataclass(frozen=True, slots=True)
class Facing:
    """Where to look."""

    kind: str = PUBLIC
    degrees: float = 0.0
    """The heading, for DEGREES: 0 is the public, towards +90 the right as the audience sees it."""
    dancer: int = 0
    """Whom to look at, for DANCER, from 0."""
    name: str = ""
    """The group, for GROUP."""

    @property
    def heading(self) -> float:
        """The heading [rad], for DEGREES."""
        return math.radians(self.degrees)


def parse_facing(words: str, *, dancers: int, groups: tuple[str, ...]) -> Facing:
    """What the words mean where there are so many dancers, and groups of these names (casefolded); else PersonError."""
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
    raise PersonError(f"facing {words[:60]!r} means nothing", f"possible are {_WAYS}")


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
