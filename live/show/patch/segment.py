"""Evolutions of the score: `[[segment]]`, and the formations they refer to: `[[formation]]` (T085-T087, T095-T103)."""

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from live.agents.formations.spec import FormationSpec
from live.agents.formations.spec_table import spec_from_table
from live.base.errors import PersonError
from live.show.patch.section_base import Name, Place, Section
from live.show.patch.section_elements import Line, Words


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
