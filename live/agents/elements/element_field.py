"""ElementField: the elements in force, and what they wish of every agent at a tick (T105-T110, T132)."""

from dataclasses import replace
from typing import Literal, Protocol

import numpy as np

from live.agents.agent_command import Wants
from live.agents.elements.audience_attractor_kernels import AUDIENCES, PLACE_COLUMNS, PLACES, gather
from live.agents.elements.crossing_kernels import MEMORY_COLUMNS, claim
from live.agents.elements.element import Element
from live.agents.elements.element_kinds import CROSSING, ELEMENT_CAPACITY, FLOW, GRID, VOICE
from live.agents.elements.element_table import ElementTable, Float32, Float64, UInt64
from live.agents.elements.element_table_kernels import (
    HALF_DEPTH,
    HALF_WIDTH,
    LEVEL,
    NUMBERS,
    PLACE_COUNT,
    SEED,
    SUM_COLUMNS,
    SWITCHED,
    TIME,
    show_elements,
)
from live.agents.elements.field_kernels import wish_of_all
from live.agents.elements.polyline_flow import GRID_COLUMNS, GRID_ROWS
from live.agents.elements.shape_kernels import NEAR_COLUMNS
from live.agents.elements.spread_kernels import CELLS, MESH, fill_cosines
from live.base.errors import PersonError
from live.base.stage_snapshot import StageView


class Moving(Protocol):
    """What the field reads of the agents' state: position [m] and velocity [m/s], each (A, 2)."""

    @property
    def position(self) -> Float32:
        """Stage position (x, z) [m], shape (A, 2)."""

    @property
    def velocity(self) -> Float32:
        """Velocity [m/s], shape (A, 2)."""


class ElementField:
    """The elements of a show of A agents. Each tick: `refresh`, then `wish` (as often as needed, also on copies)."""

    def __init__(
        self,
        agent_count: int,
        *,
        half_width: float,
        half_depth: float,
        seed: int = 0,
        separation: float = 1.0,
        combine: Literal["blended", "switched"] = "blended",
        capacity: int = ELEMENT_CAPACITY,
    ) -> None:
        """Half sizes of the stage [m]; `separation` [m] of dancers whom elements move, unless an element says another.

        `combine`: wishes are summed, or urgent ones take the speed first (T083). At most `capacity` elements.
        """
        self._table = ElementTable(capacity, half_width=half_width, half_depth=half_depth, separation=separation)
        self.influence: Float32 = np.zeros(agent_count, np.float32)
        """How far the last `wish` has taken each agent from her plan, 0 to 1, shape (A,)."""
        self._memory: Float64 = np.zeros((agent_count, MEMORY_COLUMNS))
        self._sums: Float64 = np.zeros((agent_count, SUM_COLUMNS))
        self._near: Float64 = np.zeros((agent_count, NEAR_COLUMNS))
        self._spreading: Float64 = np.zeros((agent_count, 2))
        self._places: Float64 = np.zeros((PLACES * AUDIENCES, PLACE_COLUMNS))
        self._audience: UInt64 = np.zeros(PLACES * AUDIENCES, np.uint64)
        self._density: Float64 = np.zeros(capacity)
        self._numbers: Float64 = np.zeros(NUMBERS)
        self._numbers[SEED] = seed
        self._numbers[SWITCHED] = combine == "switched"
        self._area: Float64 = np.zeros(4)
        self.resize(half_width, half_depth)
        self._mesh: Float32 = np.zeros((3, MESH, MESH), np.float32)
        self._cosines: Float32 = np.zeros((2, MESH + 1, MESH, MESH), np.float32)
        fill_cosines(self._cosines)
        self._start = np.zeros(CELLS * CELLS + 1, np.int32)
        self._order = np.zeros((2, agent_count), np.int32)

    def resize(self, half_width: float, half_depth: float) -> None:
        """The stage's half sizes [m] are these from now on."""
        self._numbers[HALF_WIDTH], self._numbers[HALF_DEPTH] = half_width, half_depth
        self._area[:] = -half_width, half_width, -half_depth, half_depth
        self._table.resize(half_width, half_depth)

    # -- elements come, move and go ----------------------------------------------------------------------------

    @property
    def elements(self) -> tuple[Element, ...]:
        """The elements that have not ended, oldest first."""
        return tuple(self._table.elements)

    def add(self, element: Element, grid: Float32 | None = None) -> bool:
        """Put one more element in force; if there is no place, the oldest voice, else the oldest element gives way.

        `grid` (24, 32, 2): the flow of an element of kind FLOW with flow GRID, at nodes over the stage, the first row
        at the back. False if a voice found no place. Raises PersonError for a grid that is missing, or of another form.
        """
        good = grid is not None and grid.shape == (GRID_ROWS, GRID_COLUMNS, 2) and bool(np.isfinite(grid).all())
        if element.kind == FLOW and element.flow == GRID and not good:
            raise PersonError("flow: its grid is missing or has another form", "give 24 rows of 32 finite (x, z)")
        return self._table.add(element, grid)

    def move(self, old: Element, new: Element) -> Element:
        """Put `new` in the place of `old` without fading in anew (a dragged attractor stays one); returns what acts.

        If `old` is no longer in force, `new` begins for itself.
        """
        row = self._table.row_of(old)
        if row is None:
            self.add(new)
            return new
        moved = replace(new, start_beat=min(old.start_beat, new.start_beat))
        self._table.replace(row, moved)
        return moved

    def remove(self, element: Element) -> bool:
        """Take away an element that was put there, as if it had never been; False if it is not in force any more."""
        row = self._table.row_of(element)
        if row is not None:
            self._table.remove(row)
        return row is not None

    def end(self, beat: float, *, source: str | None = None, kind: int | None = None, groups: int | None = None) -> int:
        """Let the elements that fit all that is given fade out from `beat` on, from the level they have.

        Those yet to come never begin. `groups`: those that address any of these bits. Returns how many it were.
        """
        count = 0
        for row in reversed(range(len(self._table))):
            element = self._table.elements[row]
            fits = (source is None or element.source == source) and (kind is None or element.kind == kind)
            if not fits or (groups is not None and not element.groups & groups):
                continue
            count += 1
            if element.level(beat) > 0.0:
                self._table.replace(row, element.ending(beat))
            else:
                self._table.remove(row)
        return count

    def clear(self, beat: float) -> None:
        """Let every element fade out from `beat` on."""
        self.end(beat)

    # -- each tick ---------------------------------------------------------------------------------------------

    def refresh(self, beat: float, wants: Wants, state: Moving, groups: UInt64) -> None:
        """Once a tick, first: who acts at `beat`; whoever is to cross over gets her place on the other side.

        `groups` (A,) uint64: the bits of the groups each agent belongs to.
        """
        table, numbers = self._table, self._numbers
        table.refresh(beat)
        if table.acts(CROSSING):
            claim(
                table.rows, table.masks, table.vertices, table.active, state.position, wants.rows, groups,
                self._memory, numbers[HALF_WIDTH], numbers[HALF_DEPTH], int(numbers[SEED]),
            )  # fmt: skip
        numbers[PLACE_COUNT] = 0.0
        if table.acts(VOICE):
            numbers[PLACE_COUNT] = gather(
                table.rows, table.masks, table.active, self._places, self._audience, self._density
            )

    def foresee(self, beat: float) -> None:
        """Before `wish` on a copy: who will act at `beat`, as far as is known; the next `refresh` undoes it."""
        self._table.foresee(beat)

    def wish(
        self, wants: Wants, state: Moving, groups: UInt64, *, time: float, influence: Float32 | None = None
    ) -> Float32:
        """Blend what the elements wish into `wants`: (1 - influence) of the planned velocity and firmness, and theirs.

        Also raises separation, alignment and cohesion to what they ask for. `time` [s] is for seeded chance. Writes
        the influence of each agent, 0 to 1, into `influence` (A,) or else into the field's own, and returns it. It
        changes nothing else, so a look-ahead may call it on copies (with an `influence` of its own).
        """
        out = self.influence if influence is None else influence
        table = self._table
        if not len(table.acting):
            out[:] = 0.0
            return out
        self._numbers[TIME] = time
        wish_of_all(
            state.position, state.velocity, wants.rows, groups, table.rows, table.masks, table.vertices, table.active,
            table.grids, self._places, self._audience, self._memory, self._area, self._mesh, self._cosines, self._start,
            self._order, self._spreading, self._numbers, self._sums, self._near, out,
        )  # fmt: skip
        return out

    # -- what is seen ------------------------------------------------------------------------------------------

    def show(self, view: StageView) -> None:
        """Copy what acts now into the drawing snapshot: kind, place, level, and the corners of lines and regions.

        Audiences' voices are of kind VOICE. Corners for which there is no room are left out with their element's line.
        """
        table = self._table
        view.element_count = show_elements(
            table.rows, table.active, table.vertices,
            view.element_kind, view.element_position, view.element_level, view.element_radius, view.element_strength,
            view.element_flow, view.element_first, view.element_corners, view.element_corner,
        )  # fmt: skip

    def shown(self) -> list[tuple[Element, float]]:
        """The elements that act now with their levels, for pictures that draw lines and regions."""
        return [(self._table.elements[row], float(self._table.rows[row, LEVEL])) for row in self._table.acting]
