"""Elements of the score: `[[element]]` (T132)."""

from typing import Annotated, Literal

from pydantic import Field

from live.show.sections.section import Place, Section


class ElementSection(Section):
    """`[[element]]`: an attractor, repulsor or spreader of the score, in measures from 1 (T132)."""

    kind: Literal["attract", "repel", "spread"]
    """Gather at a place, leave it, or spread over the stage."""
    measure: Annotated[float, Field(ge=1, le=100000)]
    """The measure at which it begins."""
    measures: Annotated[float, Field(gt=0, le=10000)] = 4.0
    """How many measures it lasts; it fades in and out over a beat."""
    at: Place = (0.0, 0.0)
    """Where it is (x, z) [m]; a spreader is everywhere."""
    strength: Annotated[float, Field(ge=0, le=10)] = 1.0
    """1 is as fast as the steps can travel."""
