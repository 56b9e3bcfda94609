"""Output: what one projector shows of the picture, and how it is bent, as plain frozen values.

Two spaces, both with x to the right and y down, 0 to 1: the *window*, which is what the projector throws, and the
*frame*, which is the picture's part that this output shows, upright. Crops are in the whole picture's own 0 to 1.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Literal

Point = tuple[float, float]
Rotation = Literal[0, 90, 180, 270]

WHOLE: Final = (0.0, 0.0, 1.0, 1.0)
"""The crop that shows all of the picture."""
UNBENT: Final[tuple[Point, Point, Point, Point]] = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
"""Corners that fill the window: upper left, upper right, lower right, lower left."""
MESH_LEAST: Final = 2
MESH_MOST: Final = 17
"""Points of a mesh in a row, and in a column."""


@dataclass(frozen=True, slots=True)
class SoftEdge:
    """How the picture fades out towards its borders, where another projector's begins."""

    left: float = 0.0
    right: float = 0.0
    top: float = 0.0
    bottom: float = 0.0
    """Breadth of each, as a share of this output's frame."""
    gamma: float = 2.2
    """The projector's own: light = signal ** gamma."""
    black: float = 0.0
    """How much light the projector gives for black, of its white: borders of overlaps are lifted to hide it."""

    @property
    def is_hard(self) -> bool:
        """Whether there is none."""
        return not (self.left or self.right or self.top or self.bottom)


@dataclass(frozen=True, slots=True)
class Output:
    """One projector."""

    name: str = "picture"
    monitor: str | None = None
    """Its monitor, by number, name or place; None: where the show opens anyway."""
    crop: tuple[float, float, float, float] = WHOLE
    """Which part of the picture it shows: x, y of its upper left corner, width, height."""
    corners: tuple[Point, Point, Point, Point] = UNBENT
    """Where the frame's corners land in the window: upper left, upper right, lower right, lower left."""
    mesh: tuple[tuple[Point, ...], ...] = ()
    """Rows of points in the frame, from the upper left one; the regular grid bends nothing. Empty: none."""
    rotation: Rotation = 0
    """The picture is turned so far clockwise [degrees]."""
    mirror: bool = False
    """Left is right, for projection from behind."""
    edge: SoftEdge = field(default_factory=SoftEdge)
    mask: Path | None = None
    """A picture over the window: black hides, white shows."""
    brightness: float = 1.0
    """Share of the light."""
    gamma: float = 1.0
    """Above 1 darkens the middle tones, to match another projector."""

    @property
    def is_bent(self) -> bool:
        """Whether it shows anything but an upright part of the picture that fills the window."""
        return self.corners != UNBENT or bool(self.mesh) or self.rotation != 0 or self.mirror

    @property
    def is_tinted(self) -> bool:
        """Whether pixels have other values than in the picture."""
        return not self.edge.is_hard or self.mask is not None or (self.brightness, self.gamma) != (1.0, 1.0)

    @property
    def is_plain(self) -> bool:
        """Whether the window shows the whole picture as it is."""
        return not self.is_bent and not self.is_tinted and self.crop == WHOLE
