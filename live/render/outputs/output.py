"""Settings of one projector output: crop, warp, soft edge, mask, brightness; plain frozen values.

Two spaces, both with x to the right and y down, 0 to 1: the *window* is the projected image; the *frame* is the
part of the picture that this output shows, upright. Crops are in the 0 to 1 space of the whole picture.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Literal

Point = tuple[float, float]
Rotation = Literal[0, 90, 180, 270]

FULL_CROP: Final = (0.0, 0.0, 1.0, 1.0)
"""The crop that shows all of the picture."""
FULL_WINDOW: Final[tuple[Point, Point, Point, Point]] = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
"""Corners that fill the window: upper left, upper right, lower right, lower left."""
MAX_PICTURE_SIDE: Final = 65_536
"""Maximum side length of a whole picture of which each machine draws a part [pixels]."""
MIN_MESH_POINTS: Final = 2
MAX_MESH_POINTS: Final = 17
"""Smallest and largest number of points of a mesh in a row, and in a column."""


@dataclass(frozen=True, slots=True)
class SoftEdge:
    """Edge blending: how the picture fades out where it overlaps with another projector's."""

    left: float = 0.0
    right: float = 0.0
    top: float = 0.0
    bottom: float = 0.0
    """Width of each edge, as a share of this output's frame."""
    gamma: float = 2.2
    """Gamma of the projector: light = signal ** gamma."""
    black: float = 0.0
    """Black level of the projector as a share of white: areas without overlap are lifted to match overlaps."""

    @property
    def is_hard(self) -> bool:
        """Whether there is no soft edge."""
        return not (self.left or self.right or self.top or self.bottom)


@dataclass(frozen=True, slots=True)
class Output:
    """One projector."""

    name: str = "picture"
    monitor: str | None = None
    """Its monitor, by number, name or place; None: the show's default monitor."""
    crop: tuple[float, float, float, float] = FULL_CROP
    """The part of the picture that is shown: x, y of its upper left corner, width, height."""
    corners: tuple[Point, Point, Point, Point] = FULL_WINDOW
    """Places of the frame's corners in the window: upper left, upper right, lower right, lower left."""
    mesh: tuple[tuple[Point, ...], ...] = ()
    """Rows of points in the frame, from the upper left one; the regular grid does not warp. Empty: no mesh."""
    rotation: Rotation = 0
    """Clockwise rotation of the picture [degrees]."""
    mirror: bool = False
    """Swap left and right, for rear projection."""
    edge: SoftEdge = field(default_factory=SoftEdge)
    mask: Path | None = None
    """An image over the window: black hides, white shows."""
    brightness: float = 1.0
    """Factor of the light."""
    gamma: float = 1.0
    """Values above 1 darken the middle tones, to match another projector."""
    node: str = ""
    """The render node that draws it; empty: the machine that plays the show."""

    @property
    def is_warped(self) -> bool:
        """Whether the output is warped, rotated or mirrored."""
        return self.corners != FULL_WINDOW or bool(self.mesh) or self.rotation != 0 or self.mirror

    @property
    def is_tinted(self) -> bool:
        """Whether pixel values are changed."""
        return not self.edge.is_hard or self.mask is not None or (self.brightness, self.gamma) != (1.0, 1.0)

    @property
    def is_plain(self) -> bool:
        """Whether the window shows the whole picture without changes."""
        return not self.is_warped and not self.is_tinted and self.crop == FULL_CROP
