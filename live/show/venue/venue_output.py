"""`[[output]]` of a venue: which projector shows what part of the picture, and how it is bent there.

`[projector]` of a venue: where the hall's own projector stands, for every show that is played there.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Final, Self

from pydantic import Field, field_validator, model_validator

from live.base.errors import PersonError, named
from live.base.projector_perspective import matched
from live.render.outputs.output import UNBENT, WHOLE, Output, Rotation, SoftEdge
from live.render.outputs.warp import FARTHEST, check_corners, check_mesh
from live.show.patch.patch import Patch
from live.show.patch.section_base import Amiss, Far, Name, Section, Share
from live.show.patch.section_stage import CameraSection, FloorCorners, ProjectorSection, refuse_no_floor

Near = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST + 1, allow_inf_nan=False)]
Point = tuple[Near, Near]
Breadth = Annotated[float, Field(ge=0, le=0.5, allow_inf_nan=False)]
Curve = Annotated[float, Field(ge=0.5, le=4, allow_inf_nan=False)]

MOST_OUTPUTS: Final = 8


class VenueSoftEdge(Section):
    """`soft_edge`: how the picture fades out where another projector's begins."""

    left: Breadth = 0.0
    """Breadth at its left, as a share of what this output shows."""
    right: Breadth = 0.0
    """At its right."""
    top: Breadth = 0.0
    """Above."""
    bottom: Breadth = 0.0
    """Below."""
    gamma: Curve = 2.2
    """The projector's own: light = signal ** gamma."""
    black: Annotated[float, Field(ge=0, le=0.2, allow_inf_nan=False)] = 0.0
    """Light that the projector gives for black, as a share of white; what does not overlap is lifted by it."""

    @model_validator(mode="after")
    def _apart(self) -> Self:
        if self.left + self.right > 1.0 or self.top + self.bottom > 1.0:
            raise ValueError("two soft edges overlap: left + right and top + bottom are at most 1")
        return self


class VenueOutput(Section):
    """`[[output]]`: one projector."""

    name: Name = "picture"
    """What `/dance/output/card` calls it, and what stands on its test card."""
    monitor: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """Its monitor: a number, a name as `live devices` shows it, or a place, as in "right of primary"."""
    crop: tuple[Share, Share, Share, Share] = WHOLE
    """The part of the picture that it shows: x, y of its upper left corner, width, height, each 0 to 1."""
    corners: tuple[Point, Point, Point, Point] = UNBENT
    """Where its corners land in the window: upper left, upper right, lower right, lower left; (0, 0) is the window's
    upper left corner, (1, 1) its lower right one."""
    mesh: Annotated[tuple[tuple[Point, ...], ...], Field(max_length=64)] = ()
    """Rows of points that bend it smoothly, each row from left to right; the regular grid from 0 to 1 bends nothing."""
    rotation: Rotation = 0
    """It is turned so far clockwise [degrees]: 0, 90, 180 or 270."""
    mirror: bool = False
    """Left and right change places, for projection from behind."""
    soft_edge: VenueSoftEdge = VenueSoftEdge()
    """How it fades out where another projector's picture begins."""
    mask: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """A PNG beside this file, laid over the window: black hides, white shows."""
    brightness: Share = 1.0
    """Share of the light."""
    gamma: Curve = 1.0
    """Above 1 darkens the middle tones, to match another projector."""

    @field_validator("name")
    @classmethod
    def _printable(cls, name: str) -> str:
        if not name.isprintable() or not name.strip() or name == "*":
            raise ValueError("printable characters expected, and not * alone")
        return name

    @field_validator("crop")
    @classmethod
    def _inside(cls, crop: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        x, y, width, height = crop
        if width <= 0.0 or height <= 0.0 or x + width > 1.0 + 1e-6 or y + height > 1.0 + 1e-6:
            raise ValueError("x, y, width, height expected, within 0 to 1: x + width and y + height are at most 1")
        return crop

    @field_validator("corners")
    @classmethod
    def _convex(cls, corners: tuple[Point, Point, Point, Point]) -> tuple[Point, Point, Point, Point]:
        with _as_value_error():
            check_corners(corners)
        return corners

    @field_validator("mesh")
    @classmethod
    def _unfolded(cls, mesh: tuple[tuple[Point, ...], ...]) -> tuple[tuple[Point, ...], ...]:
        with _as_value_error():
            check_mesh(mesh)
        return mesh

    @field_validator("mask")
    @classmethod
    def _beside(cls, mask: str | None) -> str | None:
        if mask is not None and (Path(mask).is_absolute() or ".." in Path(mask).parts):
            raise ValueError("a file beside the venue's expected, without a path that leads elsewhere")
        return mask

    def output(self, folder: Path) -> Output:
        """The value that the renderer knows; `folder`: where the venue's file lies."""
        return Output(
            name=self.name, monitor=self.monitor, crop=self.crop, corners=self.corners,
            mesh=self.mesh, rotation=self.rotation, mirror=self.mirror,
            edge=SoftEdge(**self.soft_edge.model_dump()), mask=None if self.mask is None else folder / self.mask,
            brightness=self.brightness, gamma=self.gamma,
        )  # fmt: skip


@contextmanager
def _as_value_error() -> Iterator[None]:
    """What a person is told, as pydantic wants it."""
    try:
        yield
    except PersonError as error:
        raise ValueError(str(error)) from None


def check_outputs(outputs: Sequence[VenueOutput]) -> None:
    """Amiss if two of them have one name."""
    names: set[str] = set()
    for number, one in enumerate(outputs):
        if one.name.casefold() in names:
            raise Amiss(f"another output is called {one.name!r}, too", number, "name")
        names.add(one.name.casefold())


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
