"""Editing: an output's corners and mesh moved by hand, on the projector itself, with everything undone again.

Nothing here knows of windows or files: inputs in shares of the window come in, an output comes out.

MovedPoints: points in an output's window that are moved by mouse and keys, with everything undone again.

Floor editing: the corners of the real stage's floor, pointed at on the projector itself.

Each mark is light on the real floor: it is moved until it lies where the floor has that corner.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Generic, TypeVar

import numpy as np

from live.base.errors import PersonError
from live.base.projector_perspective import CORNERS
from live.base.projector_perspective import check_corners as check_floor_corners
from live.render.outputs.output import MESH_MOST, UNBENT, Output, Point
from live.render.outputs.output_coordinates import picture_place, window_place
from live.render.outputs.warp import bent, check_corners, check_mesh, homography, mapped, regular

REACH: Final = 0.06
"""A point is taken hold of from so far away, as a share of the window's width."""
KEPT: Final = 200
"""Steps that can be undone."""

State = TypeVar("State")
"""What is changed by moving, as a value."""


class MovedPoints(ABC, Generic[State]):
    """Places are shares of the window. A move that cannot be is left out, and `problem` says why."""

    def __init__(self) -> None:
        self.chosen = 0
        """The point that keys move."""
        self.is_changed = False
        """Whether anything was moved that nobody has kept yet."""
        self.problem = ""
        """Why the last move was left out; empty if it was not."""
        self._before: list[State] = []
        self._held = False

    @property
    @abstractmethod
    def points(self) -> list[Point]:
        """The points that can be moved, in the window."""

    @abstractmethod
    def _move(self, place: Point) -> bool:
        """The chosen point goes there; False, and `problem`, if it cannot."""

    @abstractmethod
    def _now(self) -> State:
        """All as it is."""

    @abstractmethod
    def _restore(self, state: State) -> None:
        """All as it was."""

    def next(self, step: int = 1) -> None:
        """Choose the next point, or the one before."""
        self.chosen = (self.chosen + step) % len(self.points)

    def take_hold(self, place: Point, aspect: float) -> bool:
        """Choose the point at a place of the window, of that width by its height; False if there is none."""
        far = np.array(self.points) - place
        distance = np.hypot(far[:, 0], far[:, 1] / aspect)
        nearest = int(distance.argmin())
        if distance[nearest] > REACH:
            return False
        self.chosen, self._held = nearest, True
        self._keep()
        return True

    def let_go(self) -> None:
        """The point that was held stays where it is."""
        self._held = False

    def pull(self, place: Point) -> None:
        """The point that is held goes there; nothing if none is."""
        if self._held:
            self._move(place)

    def nudge(self, x: float, y: float) -> None:
        """The chosen point goes so far [shares of the window]."""
        self._keep()
        at = self.points[self.chosen]
        if not self._move((at[0] + x, at[1] + y)):
            self._before.pop()

    def undo(self) -> None:
        """As it was before the last move."""
        if self._before:
            self._restore(self._before.pop())
            self.is_changed, self.problem = True, ""

    def _keep(self) -> None:
        self.is_changed = True
        self._before.append(self._now())
        del self._before[:-KEPT]


FIRST_MESH: Final = 3
"""Points each way of a mesh that begins."""


FARTHEST_POINT: Final = (-1.0, 2.0)
"""Between these shares of the frame lie a mesh's points."""


class Editing(MovedPoints[Output]):
    """One output being bent. A move that would fold or cross it is left out, and `problem` says why."""

    def __init__(self, output: Output) -> None:
        super().__init__()
        self.output = output
        """As it is bent now."""
        self.on_mesh = False
        """Whether the mesh's points are moved, and not the corners."""

    @property
    def points(self) -> list[Point]:
        """The points that can be moved, in the window."""
        if not self.on_mesh:
            return list(self.output.corners)
        flat = [point for row in self.output.mesh for point in row]
        return [(float(x), float(y)) for x, y in mapped(homography(self.output.corners), flat)]

    def _move(self, place: Point) -> bool:
        output = self.output
        try:
            if self.on_mesh:
                back = mapped(np.linalg.inv(homography(output.corners)).astype(np.float64), place)
                u, v = (float(np.clip(share, *FARTHEST_POINT)) for share in back)
                rows = [list(row) for row in output.mesh]
                rows[self.chosen // len(rows[0])][self.chosen % len(rows[0])] = (u, v)
                mesh = tuple(tuple(row) for row in rows)
                check_mesh(mesh)
                self.output = replace(output, mesh=mesh)
            else:
                corners = list(output.corners)
                corners[self.chosen] = (float(place[0]), float(place[1]))
                check_corners(corners)
                self.output = replace(output, corners=(corners[0], corners[1], corners[2], corners[3]))
        except PersonError as error:
            self.problem = error.message
            return False
        self.problem, self.is_changed = "", True
        return True

    # -- the mesh ----------------------------------------------------------------------------------------------

    def switch(self) -> None:
        """From the corners to the mesh, which is made if there is none, or back."""
        self.on_mesh, self.chosen = not self.on_mesh, 0
        if self.on_mesh and not self.output.mesh:
            self._keep()
            self.output = replace(self.output, mesh=regular(FIRST_MESH, FIRST_MESH))

    def refine(self, more: int) -> None:
        """So many more rows and columns of the mesh; it is bent as before, as well as its points can."""
        mesh = self.output.mesh
        if not self.on_mesh or not mesh:
            return
        columns, rows = (min(max(n + more, 2), MESH_MOST) for n in (len(mesh[0]), len(mesh)))
        places = bent(mesh, np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows))
        self._keep()
        self.output = replace(self.output, mesh=tuple(tuple((float(x), float(y)) for x, y in row) for row in places))
        self.chosen = 0

    # -- back --------------------------------------------------------------------------------------------------

    def straighten(self) -> None:
        """Nothing is bent any more: the corners', or the mesh's part."""
        self._keep()
        if self.on_mesh:
            mesh = self.output.mesh
            self.output = replace(self.output, mesh=regular(len(mesh[0]), len(mesh)))
        else:
            self.output = replace(self.output, corners=UNBENT)

    def _now(self) -> Output:
        return self.output

    def _restore(self, state: Output) -> None:
        self.output = state
        self.on_mesh = self.on_mesh and bool(state.mesh)
        self.chosen = min(self.chosen, len(self.points) - 1)


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
