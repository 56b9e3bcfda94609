"""Patch sections for the score.

`[[section]]`, `[[at]]` and `[[signal]]` (T015, T016), `[[sequence]]` (T009), `[[improvise]]`, `[[regroup]]` (T104),
`[[segment]]`, `[[formation]]` and `[[evolution]]` (T085-T087, T095-T103, T145, T146).
"""

import itertools
import math
from bisect import bisect_right
from typing import Annotated, Any, Final, Literal

from pydantic import AfterValidator, Field, ValidationInfo, model_validator

from live.show.patch.section_base import InvalidEntry, Name, Place, Section, Share, run_check
from live.show.patch.section_elements import Polyline, Selection
from live.show.patch.section_music import Feature

Measure = Annotated[int, Field(ge=1, le=100000)]
Beat = Annotated[float, Field(ge=1, lt=33, allow_inf_nan=False)]
Value = str | float | bool


class ScoreSection(Section):
    """`[[section]]`: a part of the score, such as a verse or a solo; measures of its entries count from its first."""

    name: Name
    """Its name, unique among sections."""
    measures: Measure
    """Number of measures."""
    repeat: Annotated[int, Field(ge=0, le=10000)] = 1
    """How often it is danced before the score continues; 0: until `/dance/advance` or a cue."""
    wait: bool = False
    """It repeats until `/dance/advance` or a cue; the same as `repeat = 0`."""
    then: Name | None = None
    """The next section, or `end`; left out: the one below, and the first after the last."""

    @model_validator(mode="after")
    def _one_of_them(self) -> "ScoreSection":
        if self.wait and self.repeat > 1:
            raise ValueError(f"section {self.name!r}: wait and repeat = {self.repeat}: leave one out")
        if self.name.casefold().strip() == "end":
            raise ValueError("no section can be called 'end': in `then` this word ends the score")
        return self


class AtSection(Section):
    """`[[at]]`: calls a control, recalls a scene or gives a signal at a beat of a measure."""

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
    """Or the scene that is recalled."""
    signal: Name | None = None
    """Or the signal that is given."""

    @model_validator(mode="after")
    def _does_something(self, info: ValidationInfo) -> "AtSection":
        if (self.call is not None) + (self.scene is not None) + (self.signal is not None) != 1:
            raise ValueError("one of call, scene and signal expected: what happens")
        if self.values and self.call is None:
            raise ValueError("values go with call")
        run_check(info, "at", self)
        return self

    @property
    def called(self) -> tuple[str, tuple[Value, ...]]:
        """Address and values of the control that it calls, also for a scene; an empty address if it gives a signal."""
        return (self.call or "", self.values) if self.scene is None else ("/dance/scene", (self.scene,))


CurvePoint = tuple[Annotated[float, Field(ge=0, le=100000, allow_inf_nan=False)], Share]


class CurveSection(Section):
    """`[[curve]]`: a value that runs along the music: drawn, or taken from sound by `live music curves` (T016)."""

    name: Name
    """Its name, for `[[react]] to = "curve:NAME"` and `[[signal]] curve`; several may share it, one after another."""
    measure: Measure = 1
    """The measure with which it begins, from 1; of its section, if it belongs to one."""
    section: Name | None = None
    """The section it belongs to; left out: measures of the whole score."""
    points: Annotated[tuple[CurvePoint, ...], Field(min_length=2, max_length=20000)]
    """Its points: measures after its beginning, and the value there, 0 to 1; in between it runs straight."""

    @model_validator(mode="after")
    def _points_go_forward(self) -> "CurveSection":
        for index, (before, point) in enumerate(itertools.pairwise(self.points), start=1):
            if point[0] < before[0]:
                words = f"{point[0]:g} after {before[0]:g}: the points of a curve go forward"
                raise InvalidEntry(words, "points", index)
        return self

    def value_at(self, measures: float) -> float | None:
        """Return the value so many measures after its beginning; None before its first and after its last point."""
        times = [point[0] for point in self.points]
        if not times[0] <= measures <= times[-1]:
            return None
        index = min(max(bisect_right(times, measures) - 1, 0), len(times) - 2)
        (begin, low), (end, high) = self.points[index : index + 2]
        return high if end <= begin else low + (high - low) * (measures - begin) / (end - begin)


class SignalSection(Section):
    """`[[signal]]`: a named event in the music, written in the score, detected by ear, or given by hand."""

    name: Name
    """Its name in `[[react]] on`; several may share a name, and `/dance/signal` gives it too."""
    measure: Measure | None = None
    """A measure in which it occurs, from 1; of its section, if it belongs to one."""
    beat: Beat = 1.0
    """The beat of that measure, from 1."""
    section: Name | None = None
    """The section that measure belongs to."""
    on: Literal["drop", "build", "loud", "quiet", "dense", "sparse", "bright", "dark"] | None = None
    """What triggers it in the music: the bass returns, a build-up begins, or it becomes louder, softer, denser ..."""
    curve: Name | None = None
    """Or the `[[curve]]` that triggers it when it rises to `level`."""
    level: Annotated[float, Field(ge=0, le=1)] | None = None
    """Threshold, 0 to 1 in the range heard so far, or of the curve; left out: 0.75, and 0.25 for `quiet`, `sparse` and
    `dark`."""

    @model_validator(mode="after")
    def _keys_fit(self) -> "SignalSection":
        if self.section is not None and self.measure is None:
            raise ValueError(f"signal {self.name!r}: section needs measure")
        if self.curve is not None and self.on is not None:
            raise ValueError(f"signal {self.name!r}: on and curve: leave one out")
        if self.level is not None and self.on in (None, "drop") and self.curve is None:
            raise ValueError(f"signal {self.name!r}: level goes with on = build, loud, quiet, dense, sparse ...")
        return self


Step = Annotated[str, Field(min_length=1, max_length=100)]


class SequenceSection(Section):
    """`[[sequence]]`: steps that dancers dance over some measures of the score, before their group's steps resume."""

    group: Selection = "*"
    """The dancers: a group, or groups, attributes, numbers and places as in `ember & left + 12-14`; places count when
    it begins. What a part of a group is given counts before what the group is given."""
    measure: Measure = 1
    """The measure with which it begins, from 1; of its section, if it belongs to one."""
    section: Name | None = None
    """The section it belongs to, whose first measure is its measure 1; left out: measures of the whole score."""
    measures: Measure | None = None
    """For how many measures it is repeated; left out: danced once. Its steps must end exactly then."""
    steps: Annotated[tuple[Step, ...], Field(min_length=1, max_length=10000)]
    """Steps in order, as by `/dance/sequence`: "groove x4", "walk left", "*" for anything; with `choose = "random"` the
    set from which they are drawn."""
    name: Name | None = None
    """Its name as a pad: `/dance/launch "phrase NAME"`; left out: its number, from 1."""
    choose: Literal["sequence", "random"] = "sequence"
    """In their order, or drawn at random (seeded), never one three times in a row; drawn again in each repeat."""


Weight = Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)]


class ImproviseRule(Section):
    """`[[improvise.rule]]`: changes the weights of steps while a feature of the music is within a range."""

    of: Literal["energy", Feature]
    """The feature, 0 to 1 in the range heard so far; energy is the mean of loudness and density, of the music or of
    MIDI notes; the last four are of MIDI notes, as in `[[react]]`."""
    above: Share | None = None
    """The rule holds from this value on ..."""
    below: Share | None = None
    """... or up to this value."""
    favours: Annotated[dict[str, Weight], Field(min_length=1, max_length=1000)]
    """Factors for the weights of steps: 3 is three times as often, 0 never."""

    @model_validator(mode="after")
    def _has_range(self) -> "ImproviseRule":
        if self.above is None and self.below is None:
            raise ValueError("above or below expected: from where on, or up to where, the rule holds")
        return self


class ImproviseMotion(Section):
    """`[[improvise.motion]]`: a call that may be drawn when a phrase begins, such as a formation or an element."""

    weight: Weight = 1.0
    """Its probability relative to the others."""
    call: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    """The control that is called, by its address; left out: no call, the motion continues."""
    values: Annotated[tuple[Value, ...], Field(max_length=16)] = ()
    """Its values, as by OSC."""

    @model_validator(mode="after")
    def _call_is_valid(self, info: ValidationInfo) -> "ImproviseMotion":
        run_check(info, "improvise.motion", self)
        return self


class ImproviseSection(Section):
    """`[[improvise]]`: dancers choose their steps themselves, by weights, rules and limits, over some measures."""

    group: Selection = "*"
    """The dancers, as in `[[sequence]]`; * is all groups, each separately."""
    section: Name | None = None
    """The section it belongs to; left out: measures of the whole score."""
    measure: Measure = 1
    """The measure with which it begins, from 1."""
    measures: Measure | None = None
    """How many measures it lasts; left out: to the end of its section."""
    steps: dict[str, Weight] = Field(default={})
    """Weights of steps; left out: the group's own steps with equal weights."""
    at_least: Annotated[int, Field(ge=1, le=64)] = 1
    """Least number of times in a row that a chosen step is danced ..."""
    most: Annotated[int, Field(ge=1, le=1000)] = 2
    """... and the largest number of times."""
    phrase: Annotated[int, Field(ge=1, le=1000)] = 4
    """Measures of a phrase: at each phrase motion is drawn, and the roles of call and response change."""
    answers: Name | None = None
    """Call and response: in every second phrase this group answers what the other group danced in the phrase before
    ..."""
    answer: Literal["same", "other"] = "same"
    """... with the same steps, or with those that the other group did not dance."""
    listening: str | None = None
    """The step danced while the other group calls; left out: it keeps improvising."""
    motion: Annotated[tuple[ImproviseMotion, ...], Field(max_length=1000)] = ()
    """Calls that may be drawn when a phrase begins."""
    rule: Annotated[tuple[ImproviseRule, ...], Field(max_length=64)] = ()
    """Rules that follow the music; if several hold, their factors are multiplied."""

    @model_validator(mode="after")
    def _keys_fit(self) -> "ImproviseSection":
        if self.at_least > self.most:
            raise ValueError(f"at_least {self.at_least} is more than most {self.most}")
        if self.steps and not any(self.steps.values()):
            raise ValueError("steps: all weights are 0, there is nothing to choose")
        if self.motion and not any(item.weight for item in self.motion):
            raise ValueError("motion: all weights are 0, there is nothing to choose")
        if self.answers is not None and self.answers.casefold() == self.group.casefold():
            raise ValueError(f"group {self.group!r} cannot answer itself")
        if self.listening is not None and self.answers is None:
            raise ValueError("listening needs answers: the group that it listens to")
        return self


def _check_formation(table: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
    run_check(info, "formation", table)
    return table


FormationTable = Annotated[dict[str, Any], AfterValidator(_check_formation)]
"""`[[formation]]`: the keys of `live docs formations`."""


def formation_names(tables: tuple[dict[str, Any], ...]) -> list[str]:
    """Return the names of the formations of a patch, in their order."""
    return [str(table["name"]) for table in tables]


WayPoints = Annotated[tuple[Place, ...], Field(min_length=1, max_length=400)]
TRANSFORM_KEYS: Final = (
    "scale", "size", "proportions", "bend_deg", "rotation_deg", "centre", "mirror", "along", "into", "neighbours",
)  # fmt: skip
"""Keys of `[[formation]]` that transform another one, which `[[evolution]]` has, too."""


class EvolutionSection(Section):
    """`[[evolution]]`: a group's motion as material: a way for each dancer, drawn, recorded, or like another's."""

    name: Name
    """Its name, for `[[segment]] evolution` and for others that are like it."""
    ways: Annotated[tuple[WayPoints, ...], Field(max_length=400)] = ()
    """A way for each dancer: points (x, z) [m] that she passes at even times, as a curve; one point is a place."""
    like: Name | None = None
    """Instead of ways: another evolution, whose ways are transformed with neighbours kept, by the keys below, in the
    order and the meaning that they have in a `[[formation]]` that is like another one."""
    scale: float | Place | None = None
    """How many times as large; two numbers: in width and in depth."""
    size: Place | None = None
    """Or the width and depth [m] that the whole motion gets."""
    proportions: Literal["keep", "stretch"] | None = None
    """Of `size`, `along` and `into`: whether proportions are kept, or the size, line or region is filled."""
    bend_deg: float | None = None
    """Angle of the arc to which its width is bent; positive: both sides come to the public."""
    rotation_deg: float | None = None
    """Rotation about its middle; positive turns the front towards +x."""
    centre: Place | None = None
    """How far it is moved (x, z) [m]."""
    mirror: Literal["left-right", "front-back"] | float | tuple[Place, Place] | None = None
    """Line about which it is mirrored: from back to front, from side to side, in a direction [degrees], or through two
    points."""
    along: str | Polyline | None = None
    """Line on which its width is laid: points (x, z) [m], or the name of a formation with a line."""
    into: str | tuple[Place, ...] | tuple[tuple[Place, ...], ...] | None = None
    """Region into which it is squeezed: points of a closed line, or several, or the name of a formation."""
    neighbours: Literal["keep", "any"] | None = None
    """Whether neighbours stay neighbours, also where it is stretched."""

    @model_validator(mode="after")
    def _ways_or_like(self, info: ValidationInfo) -> "EvolutionSection":
        if bool(self.ways) == (self.like is not None):
            raise ValueError(f"evolution {self.name!r}: either ways, or like, expected")
        given = next((key for key in TRANSFORM_KEYS if getattr(self, key) is not None), None)
        if given is not None and self.like is None:
            raise ValueError(f"evolution {self.name!r}: {given} transforms another evolution: like expected")
        run_check(info, "evolution", self)
        return self

    @property
    def transform_table(self) -> dict[str, Any]:
        """Its keys that transform, as keys of a formation."""
        return {key: value for key in TRANSFORM_KEYS if (value := getattr(self, key)) is not None}


class RegroupSection(Section):
    """`[[regroup]]`: at a measure line dancers change to another group's steps and colour (T104)."""

    measure: Annotated[int, Field(ge=1, le=100000)]
    """The first measure in which they dance with the other group, from 1."""
    section: Name | None = None
    """The section it belongs to, whose first measure is its measure 1; left out: measures of the whole score."""
    dancers: Selection
    """The dancers: groups, attributes, numbers and places as in `ember & left + 12-14`; places count at that time."""
    group: Name
    """The group whose steps they dance from then on."""


class SegmentSection(Section):
    """`[[segment]]`: how a group moves over some measures: into a formation, along a line, as an evolution, or not at
    all."""

    measure: Annotated[int, Field(ge=1, le=100000)]
    """The measure at whose line it begins, from 1."""
    section: Name | None = None
    """The section it belongs to, whose first measure is its measure 1; left out: measures of the whole score."""
    measures: Annotated[int, Field(ge=1, le=10000)] = 4
    """Measures until all have arrived, exactly on a measure line."""
    group: Selection = "*"
    """The dancers: a group, or groups, attributes, numbers and places as in `ember & left + 12-14`; places count when
    it begins."""
    formation: Annotated[str, Field(min_length=1, max_length=250)] | None = None
    """Their target: a `[[formation]]`, or words for one (`star:6`, `text:LIVE`, `circle poisson`)."""
    hold: bool = False
    """They hold the formation all the time; dancers not yet in place go there within the first measure."""
    path: Polyline | None = None
    """Instead of a formation: a drawn line (x, z) [m] along which they travel in their present formation."""
    single_file: bool = False
    """They travel one behind another, on the line itself."""
    evolution: Name | None = None
    """Instead of both: an `[[evolution]]`, whose ways they take within its measures: half as many are twice as fast."""
    backwards: bool = False
    """They take the ways of the evolution from their ends to their starts."""
    match: Literal["squared", "shortest", "equal", "both", "bottleneck", "number"] = "squared"
    """Assignment of dancers to places: least squared distances (straight paths never meet), least sum, equal distances,
    both (T098-T100), least largest distance, or by the dancers' numbers."""
    way: Literal["mended", "straight", "divided"] = "mended"
    """Where straight paths would meet: starts are shifted or paths bent; nothing; paths bent by halves (T101)."""
    facing: Literal["linear", "tangent", "measures", "declared"] | None = None
    """How they turn on the path: evenly, along it, measure by measure, or by `headings_deg` (T102, T126); left out:
    evenly into a formation, along a path, measure by measure in an evolution."""
    headings_deg: Annotated[tuple[float, ...], Field(max_length=1000)] = ()
    """A heading for each measure: 0 faces the audience, positive towards +x."""
    soft: Annotated[float, Field(ge=0, le=0.5)] = 0.25
    """Share of the time for acceleration, and for deceleration."""
    ripple_beats: Annotated[float, Field(ge=0, le=1000)] = 0.0
    """Beats from the start of the first dancer to that of the last."""
    ripple_from: Literal["left", "right", "front", "back", "centre", "outside", "id", "random"] = "left"
    """Where the first dancer starts."""
    beats_later: Annotated[float, Field(ge=0, le=1000)] = 0.0
    """Beats by which it begins and ends later than its measures (a canon between groups)."""
    mirror: bool | tuple[Place, Place] = False
    """Formation or path mirrored, left for right or about the line through two points."""

    @model_validator(mode="after")
    def _one_thing(self) -> "SegmentSection":
        given = [key for key in ("formation", "path", "evolution") if getattr(self, key) is not None]
        if len(given) > 1:
            raise ValueError(f"{given[0]} and {given[1]}: leave one out; without either the dancers pause")
        if self.backwards and self.evolution is None:
            raise ValueError("backwards needs an evolution")
        if self.hold and self.formation is None:
            raise ValueError("hold needs a formation")
        if isinstance(self.mirror, tuple) and math.dist(*self.mirror) < 1e-3:
            raise ValueError("mirror: both points are the same, there is no line through them")
        if (self.facing == "declared") != bool(self.headings_deg):
            raise ValueError('facing = "declared" and headings_deg need each other')
        return self
