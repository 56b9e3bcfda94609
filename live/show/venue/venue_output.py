"""`[[output]]` and `[projector]` of a venue: outputs with crop and warp, and the projector's position."""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Final, Self

from pydantic import Field, field_validator, model_validator

from live.base.errors import PersonError, error_context
from live.base.projector_perspective import camera_from_corners
from live.render.outputs.output import FULL_CROP, FULL_WINDOW, Output, Rotation, SoftEdge
from live.render.outputs.warp import MAX_CORNER_DISTANCE, check_corners, check_mesh
from live.show.patch.patch import Patch
from live.show.patch.section_base import InvalidEntry, Name, Section, Share, WorldCoordinate
from live.show.patch.section_stage import CameraSection, FloorCorners, ProjectorSection, check_floor_corners

WindowCoordinate = Annotated[float, Field(ge=-MAX_CORNER_DISTANCE, le=MAX_CORNER_DISTANCE + 1, allow_inf_nan=False)]
Point = tuple[WindowCoordinate, WindowCoordinate]
BlendWidth = Annotated[float, Field(ge=0, le=0.5, allow_inf_nan=False)]
Curve = Annotated[float, Field(ge=0.5, le=4, allow_inf_nan=False)]

MAX_OUTPUTS: Final = 64
MAX_MACHINE_OUTPUTS: Final = 8
"""Most outputs of one machine."""
NODE_PATTERN: Final = r"^[A-Za-z0-9_-]{1,64}$"
"""Regular expression for the name of a render node."""


class VenueSoftEdge(Section):
    """`soft_edge`: edge blending with overlapping projectors."""

    left: BlendWidth = 0.0
    """Width of the blend at the left edge, as a share of this output's picture."""
    right: BlendWidth = 0.0
    """Width at the right edge."""
    top: BlendWidth = 0.0
    """Width at the upper edge."""
    bottom: BlendWidth = 0.0
    """Width at the lower edge."""
    gamma: Curve = 2.2
    """The projector's gamma: light = signal ** gamma."""
    black: Annotated[float, Field(ge=0, le=0.2, allow_inf_nan=False)] = 0.0
    """The projector's black level, as a share of white; areas without overlap are raised by it."""

    @model_validator(mode="after")
    def _apart(self) -> Self:
        if self.left + self.right > 1.0 or self.top + self.bottom > 1.0:
            raise ValueError("two soft edges overlap: left + right and top + bottom are at most 1")
        return self


class VenueOutput(Section):
    """`[[output]]`: one projector."""

    name: Name = "picture"
    """Its name in `/dance/output/card` and on its test card."""
    monitor: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """Its monitor: a number, a name as in `live devices`, or a position, as in "right of primary"."""
    node: Annotated[str, Field(pattern=NODE_PATTERN)] | None = None
    """The render node that draws it (`live node`); left out: the machine that plays the show."""
    crop: tuple[Share, Share, Share, Share] = FULL_CROP
    """The part of the picture that it shows: x, y of the upper left corner, width, height, each 0 to 1."""
    corners: tuple[Point, Point, Point, Point] = FULL_WINDOW
    """Positions of its corners in the window: upper left, upper right, lower right, lower left; (0, 0) is the window's
    upper left corner, (1, 1) its lower right one."""
    mesh: Annotated[tuple[tuple[Point, ...], ...], Field(max_length=64)] = ()
    """Rows of points of a smooth warp, each row from left to right; the regular grid from 0 to 1 is the identity."""
    rotation: Rotation = 0
    """Clockwise rotation [degrees]: 0, 90, 180 or 270."""
    mirror: bool = False
    """Whether it is mirrored left to right, for rear projection."""
    soft_edge: VenueSoftEdge = VenueSoftEdge()
    """Edge blending with other projectors."""
    mask: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """A PNG in the folder of this file, laid over the window: black hides, white shows."""
    brightness: Share = 1.0
    """Brightness, 0 to 1."""
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
            raise ValueError("a file in the venue's folder expected, as a relative path without '..'")
        return mask

    def output(self, folder: Path) -> Output:
        """Return the renderer's value; `folder`: the folder of the venue's file."""
        return Output(
            name=self.name, monitor=self.monitor, node=self.node or "", crop=self.crop, corners=self.corners,
            mesh=self.mesh, rotation=self.rotation, mirror=self.mirror,
            edge=SoftEdge(**self.soft_edge.model_dump()), mask=None if self.mask is None else folder / self.mask,
            brightness=self.brightness, gamma=self.gamma,
        )  # fmt: skip


@contextmanager
def _as_value_error() -> Iterator[None]:
    """Convert a PersonError to the ValueError that pydantic expects."""
    try:
        yield
    except PersonError as error:
        raise ValueError(str(error)) from None


def check_outputs(outputs: Sequence[VenueOutput]) -> None:
    """Raise Amiss if two outputs have the same name."""
    names: set[str] = set()
    for number, one in enumerate(outputs):
        if one.name.casefold() in names:
            raise InvalidEntry(f"another output has the name {one.name!r}, too", number, "name")
        names.add(one.name.casefold())
    for node, count in Counter(one.node for one in outputs).items():
        if count > MAX_MACHINE_OUTPUTS:
            whose = "the machine that plays the show" if node is None else f"node {node!r}"
            raise InvalidEntry(f"{count} outputs of {whose}; at most {MAX_MACHINE_OUTPUTS}", len(outputs) - 1, "node")


class VenueProjector(Section):
    """`[projector]`: as in a patch, and with precedence over it, because the projector belongs to the hall."""

    at: tuple[WorldCoordinate, WorldCoordinate, WorldCoordinate]
    """Position of its lens: x, y (up), z [m]."""
    corners: FloorCorners | None = None
    """The floor's corners in the picture, as in a patch; left out if not measured yet."""
    aspect: Annotated[float, Field(gt=0.1, le=20)] = 16 / 9
    """Aspect ratio of that picture, width / height."""
    begins: bool = True
    """Whether shows begin with its view instead of their `[camera]`; it is always available as view `projector`."""

    @model_validator(mode="after")
    def _a_floor(self) -> Self:
        if self.corners is not None:
            check_floor_corners(self.corners)
        return self


def with_venue_projector(patch: Patch, projector: VenueProjector | None) -> Patch:
    """Return the patch adapted to a hall's projector; PersonError if its picture cannot match this show's stage.

    In a hall without one a camera stands still unless the patch asks for its director.
    """
    if projector is None or projector.corners is None:
        return patch if "camera" in patch.model_fields_set else patch.model_copy(update={"camera": patch.camera})
    with error_context("venue: projector.corners"):
        camera_from_corners(projector.at, projector.corners, (patch.stage.width, patch.stage.depth), projector.aspect)
    section = ProjectorSection(at=projector.at, corners=projector.corners, aspect=projector.aspect)
    values = {key: getattr(patch, key) for key in Patch.model_fields} | {"projector": section}
    written = patch.model_fields_set | {"projector"}
    if projector.begins:  # as if the patch had no [camera]
        values["camera"] = CameraSection()
        written -= {"camera"}
    return Patch.model_construct(_fields_set=written, **values)
