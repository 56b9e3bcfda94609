"""Editing: an output's corners and mesh moved by hand, on the projector itself, with everything undone again.

Nothing here knows of windows or files: inputs in shares of the window come in, an output comes out.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from live.base.errors import PersonError
from live.render.outputs.corner_pin import check_corners, homography, mapped
from live.render.outputs.mesh import bent, check_mesh, regular
from live.render.outputs.moved_points import MovedPoints
from live.render.outputs.output import MESH_MOST, UNBENT, Output, Point

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
