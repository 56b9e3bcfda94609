"""Interactive editors for an output's corners and mesh, and for the corners of the real floor, with undo.

Points are moved by mouse and keys in the projected picture. For the floor, each projected mark is moved until it lies
on that corner of the real floor. Independent of windows and files: inputs are shares of the window.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Generic, TypeVar

import numpy as np

from live.base.errors import PersonError
from live.base.floor_corners import CORNERS
from live.base.floor_corners import check_corners as check_floor_corners
from live.render.outputs.output import FULL_WINDOW, MAX_MESH_POINTS, Output, Point
from live.render.outputs.output_coordinates import picture_to_window, window_to_picture
from live.render.outputs.warp import check_corners, check_mesh, homography, map_points, regular_mesh, warp_grid

GRAB_DISTANCE: Final = 0.06
"""Maximum distance at which a point can be grabbed, as a share of the window's width."""
MAX_UNDO_STEPS: Final = 200
"""Maximum number of undo steps."""

State = TypeVar("State")
"""Type of the edited value."""


class PointEditor(ABC, Generic[State]):
    """Editor for points with undo. Places are shares of the window. Invalid moves are refused; see `problem`."""

    def __init__(self) -> None:
        self.chosen = 0
        """The point that keys move."""
        self.is_changed = False
        """Whether there are unsaved changes."""
        self.problem = ""
        """Why the last move was refused; empty if it was not."""
        self._undo_stack: list[State] = []
        self._grabbed = False

    @property
    @abstractmethod
    def points(self) -> list[Point]:
        """The points that can be moved, in the window."""

    @abstractmethod
    def _move(self, place: Point) -> bool:
        """Move the chosen point there; return False and set `problem` if that is invalid."""

    @abstractmethod
    def _current_state(self) -> State:
        """Return the present state."""

    @abstractmethod
    def _restore(self, state: State) -> None:
        """Restore an earlier state."""

    def next(self, step: int = 1) -> None:
        """Choose the next point, or the previous one for `step` -1."""
        self.chosen = (self.chosen + step) % len(self.points)

    def grab(self, place: Point, aspect: float) -> bool:
        """Grab the nearest point at a place of the window; `aspect`: width / height. False if none is near."""
        far = np.array(self.points) - place
        distance = np.hypot(far[:, 0], far[:, 1] / aspect)
        nearest = int(distance.argmin())
        if distance[nearest] > GRAB_DISTANCE:
            return False
        self.chosen, self._grabbed = nearest, True
        self._push_undo()
        return True

    def release(self) -> None:
        """Release the grabbed point."""
        self._grabbed = False

    def drag(self, place: Point) -> None:
        """Move the grabbed point there; does nothing if none is grabbed."""
        if self._grabbed:
            self._move(place)

    def nudge(self, x: float, y: float) -> None:
        """Move the chosen point by (x, y) [shares of the window]."""
        self._push_undo()
        at = self.points[self.chosen]
        if not self._move((at[0] + x, at[1] + y)):
            self._undo_stack.pop()

    def undo(self) -> None:
        """Undo the last change."""
        if self._undo_stack:
            self._restore(self._undo_stack.pop())
            self.is_changed, self.problem = True, ""

    def _push_undo(self) -> None:
        self.is_changed = True
        self._undo_stack.append(self._current_state())
        del self._undo_stack[:-MAX_UNDO_STEPS]


INITIAL_MESH_SIZE: Final = 3
"""Points in each direction of a new mesh."""


POINT_RANGE: Final = (-1.0, 2.0)
"""Range of a mesh point's coordinates [shares of the frame]."""


class WarpEditor(PointEditor[Output]):
    """Editor for the warp of one output. A move that would fold or cross it is refused; see `problem`."""

    def __init__(self, output: Output) -> None:
        super().__init__()
        self.output = output
        """The edited output."""
        self.on_mesh = False
        """Whether mesh points are edited instead of corners."""

    @property
    def points(self) -> list[Point]:
        """The points that can be moved, in the window."""
        if not self.on_mesh:
            return list(self.output.corners)
        flat = [point for row in self.output.mesh for point in row]
        return [(float(x), float(y)) for x, y in map_points(homography(self.output.corners), flat)]

    def _move(self, place: Point) -> bool:
        output = self.output
        try:
            if self.on_mesh:
                back = map_points(np.linalg.inv(homography(output.corners)).astype(np.float64), place)
                u, v = (float(np.clip(share, *POINT_RANGE)) for share in back)
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

    def toggle_mesh(self) -> None:
        """Switch between editing corners and mesh; creates a mesh if there is none."""
        self.on_mesh, self.chosen = not self.on_mesh, 0
        if self.on_mesh and not self.output.mesh:
            self._push_undo()
            self.output = replace(self.output, mesh=regular_mesh(INITIAL_MESH_SIZE, INITIAL_MESH_SIZE))

    def refine(self, more: int) -> None:
        """Add `more` rows and columns to the mesh; resamples the present warp."""
        mesh = self.output.mesh
        if not self.on_mesh or not mesh:
            return
        columns, rows = (min(max(n + more, 2), MAX_MESH_POINTS) for n in (len(mesh[0]), len(mesh)))
        places = warp_grid(mesh, np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows))
        self._push_undo()
        self.output = replace(self.output, mesh=tuple(tuple((float(x), float(y)) for x, y in row) for row in places))
        self.chosen = 0

    # -- back --------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        """Reset the corners, or the mesh, to no warp."""
        self._push_undo()
        if self.on_mesh:
            mesh = self.output.mesh
            self.output = replace(self.output, mesh=regular_mesh(len(mesh[0]), len(mesh)))
        else:
            self.output = replace(self.output, corners=FULL_WINDOW)

    def _current_state(self) -> Output:
        return self.output

    def _restore(self, state: Output) -> None:
        self.output = state
        self.on_mesh = self.on_mesh and bool(state.mesh)
        self.chosen = min(self.chosen, len(self.points) - 1)


class FloorEditor(PointEditor[list[Point]]):
    """Editor for the four floor corners in the frame, moved in one output's window. The output does not change."""

    on_mesh = False

    def __init__(self, output: Output, corners: Sequence[Sequence[float]]) -> None:
        """`corners` (4, 2) in shares of the frame, in the order of `floor_corners.CORNERS`."""
        super().__init__()
        self.output = output
        self.corners: list[Point] = [(float(x), float(y)) for x, y in corners]
        """Present places, in shares of the frame."""
        self._start = list(self.corners)

    @property
    def points(self) -> list[Point]:
        """The corners in the window."""
        return [picture_to_window(self.output, corner) for corner in self.corners]

    @property
    def corner_name(self) -> str:
        """Name of the chosen corner."""
        return f"floor's {CORNERS[self.chosen]} corner"

    def _move(self, place: Point) -> bool:
        wanted = list(self.corners)
        wanted[self.chosen] = window_to_picture(self.output, place)
        try:
            check_floor_corners(wanted)
        except PersonError as error:
            self.problem = error.message
            return False
        self.corners, self.problem, self.is_changed = wanted, "", True
        return True

    def toggle_mesh(self) -> None:
        """Does nothing: there is no mesh."""

    def refine(self, more: int) -> None:
        """Does nothing: a floor has four corners."""

    def reset(self) -> None:
        """Reset the corners to their places before editing."""
        self._push_undo()
        self.corners = list(self._start)

    def _current_state(self) -> list[Point]:
        return list(self.corners)

    def _restore(self, state: list[Point]) -> None:
        self.corners = state
