"""The score: its sections `[[section]]`, calls at beats `[[at]]`, and signals `[[signal]]` (T015, T016).

Steps of the score: `[[sequence]]`, what a group dances over some measures (T009).

Improvisation in the score: `[[improvise]]`, its rules and what it may do to the group's motion.

Evolutions of the score: `[[segment]]`, and the formations they refer to: `[[formation]]` (T085-T087, T095-T103).
"""

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from live.agents.formations.formation_spec import FormationSpec, spec_from_table
from live.base.errors import PersonError
from live.control.events.events import ControlEvent, Signal
from live.control.registry.registry import REGISTRY
from live.show.patch.section_base import Name, Place, Section, Share
from live.show.patch.section_elements import Line, Words

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


Step = Annotated[str, Field(min_length=1, max_length=100)]


class SequenceSection(Section):
    """`[[sequence]]`: steps that a group dances over some measures of the score; then its own steps go on."""

    group: Name = "*"
    """The group; * is all."""
    measure: Measure = 1
    """The measure with which it begins, from 1; of its section, if it belongs to one."""
    section: Name | None = None
    """The section it belongs to, whose first measure is its measure 1; left out: measures of the whole score."""
    measures: Measure | None = None
    """How long it is danced, again and again; left out: once. Its steps must end with it."""
    steps: Annotated[tuple[Step, ...], Field(min_length=1, max_length=10000)]
    """Steps in order, as by `/dance/sequence`: "groove x4", "walk left", "*" for anything; with `choose = "random"` the
    set from which they are drawn."""
    choose: Literal["sequence", "random"] = "sequence"
    """In their order, or drawn by seeded chance, never one three times in a row; every pass of a section draws anew."""


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


def _readable(table: dict[str, Any]) -> dict[str, Any]:
    try:
        spec = spec_from_table(table)
    except PersonError as error:
        raise ValueError(str(error)) from None
    if not spec.name:
        raise ValueError("a formation needs a name")
    return table


FormationTable = Annotated[dict[str, Any], AfterValidator(_readable)]
"""`[[formation]]`: the keys of docs/formations.md."""


def formation_names(tables: tuple[dict[str, Any], ...]) -> list[str]:
    """Names of the formations of a patch, in their order."""
    return [str(table["name"]) for table in tables]


def spec_of(table: dict[str, Any]) -> FormationSpec:
    """The formation that a checked table says."""
    return spec_from_table(table)


class RegroupSection(Section):
    """`[[regroup]]`: at a measure line dancers leave their groups for another one's steps and colour (T104)."""

    measure: Annotated[int, Field(ge=1, le=100000)]
    """The measure with which they begin to dance with the other group, from 1."""
    section: Name | None = None
    """The section it belongs to, whose first measure is its measure 1; left out: measures of the whole score."""
    dancers: Words
    """Who: groups, attributes, numbers and places as in `ember & left + 12-14`; places mean where they stand then."""
    group: Name
    """Whose steps they dance from then on."""


class SegmentSection(Section):
    """`[[segment]]`: what a group does over some measures: be or go somewhere, stay, travel along a line."""

    measure: Annotated[int, Field(ge=1, le=100000)]
    """The measure at whose line it begins, from 1."""
    section: Name | None = None
    """The section it belongs to, whose first measure is its measure 1; left out: measures of the whole score."""
    measures: Annotated[int, Field(ge=1, le=10000)] = 4
    """Measures until all have arrived, exactly on a measure line."""
    group: Words = "*"
    """Who: a group, or groups, attributes, numbers and places as in `ember & left + 12-14`; places mean where they
    stand when it begins."""
    formation: Annotated[str, Field(min_length=1, max_length=250)] | None = None
    """Where they go: a `[[formation]]`, or words for one (`star:6`, `text:LIVE`, `circle poisson`)."""
    hold: bool = False
    """They are in the formation all the time; who is not there yet goes there within the first measure."""
    path: Line | None = None
    """In place of a formation: a drawn line (x, z) [m] along which they travel and keep their formation."""
    single_file: bool = False
    """They travel one behind another, on the line itself."""
    match: Literal["squared", "shortest", "equal", "both", "bottleneck", "number"] = "squared"
    """Who goes where: squared distances (straight ways never meet), shortest sum, equal ways, both (T098-T100), the
    shortest longest way, or by the dancers' numbers."""
    way: Literal["mended", "straight", "divided"] = "mended"
    """What is done where straight ways would meet: starts are shifted or ways bent; nothing; bent by halves (T101)."""
    facing: Literal["linear", "tangent", "measures", "declared"] | None = None
    """How they turn on the way: evenly, along it, measure by measure, or as `headings_deg` say (T102, T126);
    left out: evenly into a formation, along a path."""
    headings_deg: Annotated[tuple[float, ...], Field(max_length=1000)] = ()
    """A heading for each measure: 0 faces the public, positive towards +x."""
    soft: Annotated[float, Field(ge=0, le=0.5)] = 0.25
    """Share of the time in which they gather speed, and lose it."""
    ripple_beats: Annotated[float, Field(ge=0, le=1000)] = 0.0
    """Beats from the first who starts to the last."""
    ripple_from: Literal["left", "right", "front", "back", "centre", "outside", "id", "random"] = "left"
    """Who starts first."""
    beats_later: Annotated[float, Field(ge=0, le=1000)] = 0.0
    """It begins and ends so much later than its measures (a canon between groups)."""
    mirror: bool | tuple[Place, Place] = False
    """Formation or path mirrored left for right, or about the line through two points."""

    @model_validator(mode="after")
    def _one_thing(self) -> "SegmentSection":
        if self.formation is not None and self.path is not None:
            raise ValueError("formation and path: leave one out; without either the dancers pause")
        if self.hold and self.formation is None:
            raise ValueError("hold needs a formation")
        if isinstance(self.mirror, tuple) and math.dist(*self.mirror) < 1e-3:
            raise ValueError("mirror: both points are the same, there is no line through them")
        if (self.facing == "declared") != bool(self.headings_deg):
            raise ValueError('facing = "declared" and headings_deg need each other')
        return self
