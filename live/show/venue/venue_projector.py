"""`[projector]` of a venue: where the hall's own projector stands, for every show that is played there."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from live.base.errors import named
from live.base.projector_perspective import matched
from live.show.patch.patch import Patch
from live.show.patch.section_base import Far, Section
from live.show.patch.section_stage import CameraSection, FloorCorners, ProjectorSection, refuse_no_floor


class VenueProjector(Section):
    """As in a patch, and before it: the projector is the hall's."""

    at: tuple[Far, Far, Far]
    """Where its lens is: x, y (up), z [m]."""
    corners: FloorCorners | None = None
    """Where the picture has the floor's corners, as in a patch; nobody has measured them yet if left out."""
    aspect: Annotated[float, Field(gt=0.1, le=20)] = 16 / 9
    """Width of that picture by its height."""
    begins: bool = True
    """Whether shows begin with its view, whatever `[camera]` they have; it is the view `projector` anyway."""

    @model_validator(mode="after")
    def _a_floor(self) -> Self:
        if self.corners is not None:
            refuse_no_floor(self.corners)
        return self


def in_hall(patch: Patch, projector: VenueProjector | None) -> Patch:
    """The patch as it is played where that projector stands; PersonError if it cannot see this show's stage so."""
    if projector is None or projector.corners is None:
        return patch
    with named("venue: projector.corners"):
        matched(projector.at, projector.corners, (patch.stage.width, patch.stage.depth), projector.aspect)
    section = ProjectorSection(at=projector.at, corners=projector.corners, aspect=projector.aspect)
    values = {key: getattr(patch, key) for key in Patch.model_fields} | {"projector": section}
    written = patch.model_fields_set | {"projector"}
    if projector.begins:  # as if no camera had been written
        values["camera"] = CameraSection()
        written -= {"camera"}
    return Patch.model_construct(_fields_set=written, **values)
