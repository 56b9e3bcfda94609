"""Patch section for the elements of the score: `[[element]]` (T132)."""

from typing import Annotated, Final, Literal

from pydantic import Field, model_validator

from live.base.element_kinds import ELEMENT_KINDS, KIND_NAMES, TARGETED_KINDS
from live.show.patch.section_base import Name, Place, Section

Selection = Annotated[str, Field(min_length=1, max_length=400)]
Polyline = Annotated[tuple[Place, ...], Field(min_length=2, max_length=1000)]


_KINDS_TEXT: Final = f"In this order: {', '.join(kind.text for kind in ELEMENT_KINDS)}."


class ElementSection(Section):
    """`[[element]]`: a force that moves dancers without fixed target positions; measures from 1 (T105-T110, T132)."""

    kind: Annotated[Literal[tuple(KIND_NAMES)], Field(description=_KINDS_TEXT)]  # type: ignore[valid-type]
    measure: Annotated[float, Field(ge=1, le=100000)]
    """The measure at which it begins."""
    section: Name | None = None
    """The section it belongs to, whose first measure is its measure 1; left out: measures of the whole score."""
    measures: Annotated[float, Field(gt=0, le=10000)] = 4.0
    """How many measures it lasts; it fades in and out over a beat."""
    group: Selection = "*"
    """The dancers: a group, or groups, attributes, numbers and places as in `ember & left + 12-14`."""
    at: Place = (0.0, 0.0)
    """Where it is (x, z) [m]."""
    to: Place | None = None
    """The other end of a line, bar or uniform flow (x, z) [m]."""
    points: Polyline | None = None
    """A drawn line instead of `at` and `to`: points (x, z) [m]."""
    closed: bool = False
    """The drawn line is closed: a region, or a round path."""
    radius: Annotated[float, Field(ge=0, le=100, allow_inf_nan=False)] = 0.0
    """Radius of a region around the point, or of a broad line; for a path half its width [m]."""
    strength: Annotated[float, Field(ge=-10, le=10)] = 1.0
    """1 is as fast as the steps can travel; below 0 a flow is reversed."""
    flow: Literal["uniform", "radial", "vortex", "drawn"] = "uniform"
    """Shape of a flow: from `at` to `to`, outwards from `at`, around it, along the drawn line."""
    whom: Annotated[str, Field(max_length=64)] = ""
    """Target of follow, pursue and evade: a dancer's number from 1, or a group."""

    @model_validator(mode="after")
    def _strength_is_valid(self) -> "ElementSection":
        if self.strength < 0 and self.kind != "flow":
            raise ValueError(f"{self.kind}: only a flow can have a strength below 0")
        return self

    @model_validator(mode="after")
    def _has_required_keys(self) -> "ElementSection":
        if KIND_NAMES[self.kind] in TARGETED_KINDS and not self.whom:
            raise ValueError(f"{self.kind} needs whom: a dancer's number or a group")
        drawn = self.kind == "path" or (self.kind == "flow" and self.flow == "drawn")
        if drawn and self.points is None:
            raise ValueError(f"{self.kind} needs points: a drawn line")
        if (self.kind == "cross" or (self.kind == "flow" and self.flow == "uniform")) and not (self.points or self.to):
            raise ValueError(f"{self.kind} needs to: the other point of its line")
        return self
