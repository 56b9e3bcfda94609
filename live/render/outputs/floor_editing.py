"""Floor editing: the corners of the real stage's floor, pointed at on the projector itself.

Each mark is light on the real floor: it is moved until it lies where the floor has that corner.
"""

from collections.abc import Sequence

from live.base.errors import PersonError
from live.base.projector_perspective import CORNERS
from live.base.projector_perspective import check_corners as check_floor_corners
from live.render.outputs.moved_points import MovedPoints
from live.render.outputs.output import Output, Point
from live.render.outputs.output_coordinates import picture_place, window_place


class FloorEditing(MovedPoints[list[Point]]):
    """Four points of the picture being moved in one output's window; like `Editing`, but the output stays as it is."""

    on_mesh = False

    def __init__(self, output: Output, corners: Sequence[Sequence[float]]) -> None:
        """`corners` (4, 2) of the whole picture, in the order of `perspective.CORNERS`."""
        super().__init__()
        self.output = output
        self.corners: list[Point] = [(float(x), float(y)) for x, y in corners]
        """Where they are now, in the whole picture."""
        self._start = list(self.corners)

    @property
    def points(self) -> list[Point]:
        """The corners in the window."""
        return [window_place(self.output, corner) for corner in self.corners]

    @property
    def what(self) -> str:
        """The chosen corner in words."""
        return f"floor's {CORNERS[self.chosen]} corner"

    def _move(self, place: Point) -> bool:
        wanted = list(self.corners)
        wanted[self.chosen] = picture_place(self.output, place)
        try:
            check_floor_corners(wanted)
        except PersonError as error:
            self.problem = error.message
            return False
        self.corners, self.problem, self.is_changed = wanted, "", True
        return True

    def switch(self) -> None:
        """There is nothing else to move here."""

    def refine(self, more: int) -> None:
        """A floor has four corners."""

    def straighten(self) -> None:
        """As they were when this began."""
        self._keep()
        self.corners = list(self._start)

    def _now(self) -> list[Point]:
        return list(self.corners)

    def _restore(self, state: list[Point]) -> None:
        self.corners = state
