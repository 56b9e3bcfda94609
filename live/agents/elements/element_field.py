"""The active elements and their effect on every agent per tick (T083, T105-T110, T132).

Behaviours are blended (a weighted sum, at most the top speed) or switched: urgent behaviours use their part of the
speed first, the others share the rest (Reynolds 1987: prioritized acceleration allocation).
"""

from dataclasses import replace
from typing import Final, Literal, Protocol

import numpy as np

from live.agents.agent_command import AgentCommand
from live.agents.elements.audience_attractor_kernels import (
    MAX_AUDIENCES,
    MAX_PLACES,
    PLACE_COLUMNS,
    fair_attraction,
    find_places,
)
from live.agents.elements.crossing_kernels import MEMORY_COLUMNS, assign_goals, cross_over
from live.agents.elements.element import Element
from live.agents.elements.element_table import ElementTable
from live.agents.elements.element_table_kernels import (
    ACTIVE_START,
    HALF_DEPTH,
    HALF_WIDTH,
    LEVEL,
    PARAMETER_COUNT,
    PLACE_COUNT,
    SEED,
    SUM_COLUMNS,
    SWITCHED,
    TIME,
    copy_active_elements,
    reset_sums,
)
from live.agents.elements.field_kernels import blend_sums, flow_fields
from live.agents.elements.leader_kernels import follow_leaders, pursue_or_evade
from live.agents.elements.polyline_flow import GRID_COLUMNS, GRID_ROWS
from live.agents.elements.shape_kernels import NEAR_COLUMNS, nearest_sources
from live.agents.elements.spread_kernels import NODES_PER_DANCER, SPARE_NODES, fill_spread_field, spread
from live.agents.elements.wander_kernels import add_spreading, find_members, follow_paths, wander_agents
from live.base.arrays import Float32, Float64, UInt64
from live.base.element_kinds import (
    ATTRACTOR,
    CROSSING,
    EVADE,
    FLOCK,
    FLOW,
    FOLLOW,
    GRID,
    PARTICIPANT,
    PATH,
    PURSUE,
    REPULSOR,
    SPREADER,
    WANDER,
)
from live.base.errors import PersonError
from live.base.row_ranges import run_rows
from live.base.stage_snapshot import ELEMENT_CAPACITY, StageView

FEWEST_AGENTS: Final = 1024
"""So many agents at least are worth a range of their own."""


class Kinematics(Protocol):
    """State read by the field: position [m] and velocity [m/s] of the agents, each (A, 2)."""

    @property
    def position(self) -> Float32:
        """Stage position (x, z) [m], shape (A, 2)."""

    @property
    def velocity(self) -> Float32:
        """Velocity [m/s], shape (A, 2)."""


class ElementField:
    """The elements of a show of A agents.

    Each tick call `refresh`, then `apply` (as often as needed, also on copies).
    """

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
        """Set the stage's half sizes [m] and limits.

        `separation` [m] is the default for dancers moved by elements. `combine`: preferred velocities are summed, or
        urgent behaviours use the speed first (T083). At most `capacity` elements.
        """
        self._table = ElementTable(capacity, half_width=half_width, half_depth=half_depth, separation=separation)
        self.influence: Float32 = np.zeros(agent_count, np.float32)
        """Influence of the elements on each agent in the last `apply`, 0 to 1, shape (A,)."""
        self._memory: Float64 = np.zeros((agent_count, MEMORY_COLUMNS))
        self._sums: Float64 = np.zeros((agent_count, SUM_COLUMNS))
        self._nearest: Float64 = np.zeros((agent_count, NEAR_COLUMNS))
        self._spreading: Float64 = np.zeros((agent_count, 2))
        self._places: Float64 = np.zeros((MAX_PLACES * MAX_AUDIENCES, PLACE_COLUMNS))
        self._audience: UInt64 = np.zeros(MAX_PLACES * MAX_AUDIENCES, np.uint64)
        self._density: Float64 = np.zeros(capacity)
        self._numbers: Float64 = np.zeros(PARAMETER_COUNT)
        self._numbers[SEED] = seed
        self._numbers[SWITCHED] = combine == "switched"
        self._area: Float64 = np.zeros(4)
        self.resize(half_width, half_depth)
        nodes = NODES_PER_DANCER * agent_count + SPARE_NODES
        self._mesh: Float32 = np.zeros((3, nodes), np.float32)
        self._start = np.zeros(nodes, np.int32)
        self._order = np.zeros((2, agent_count), np.int32)

    def resize(self, half_width: float, half_depth: float) -> None:
        """Set the stage's half sizes [m]."""
        self._numbers[HALF_WIDTH], self._numbers[HALF_DEPTH] = half_width, half_depth
        self._area[:] = -half_width, half_width, -half_depth, half_depth
        self._table.resize(half_width, half_depth)

    # -- add, move and remove elements --------------------------------------------------------------------------

    @property
    def elements(self) -> tuple[Element, ...]:
        """Elements that have not ended, oldest first."""
        return tuple(self._table.elements)

    @property
    def levels(self) -> Float64:
        """How far each of them acts, 0 to 1, (E,)."""
        return self._table.rows[: len(self._table), LEVEL]

    def add(self, element: Element, grid: Float32 | None = None) -> bool:
        """Add an element; if the field is full, the oldest voice is removed, or else the oldest element.

        `grid` (24, 32, 2): the flow of an element of kind FLOW with flow GRID, at nodes over the stage, the first row
        at the back. Return False if there is no room for a voice. Raises PersonError if a grid is missing or has
        another shape.
        """
        good = grid is not None and grid.shape == (GRID_ROWS, GRID_COLUMNS, 2) and bool(np.isfinite(grid).all())
        if element.kind == FLOW and element.flow_kind == GRID and not good:
            raise PersonError("flow: its grid is missing or has another form", "give 24 rows of 32 finite (x, z)")
        return self._table.add(element, grid)

    def move(self, old: Element, new: Element) -> Element:
        """Replace `old` by `new` without a new fade in (a dragged attractor stays one); return the resulting element.

        If `old` is no longer active, `new` starts on its own.
        """
        row = self._table.row_of(old)
        if row is None:
            self.add(new)
            return new
        moved = replace(new, start_beat=min(old.start_beat, new.start_beat))
        self._table.replace(row, moved)
        return moved

    def remove(self, element: Element) -> bool:
        """Remove an element without a fade out; False if it is no longer active."""
        row = self._table.row_of(element)
        if row is not None:
            self._table.remove(row)
        return row is not None

    def end(self, beat: float, *, source: str | None = None, kind: int | None = None, groups: int | None = None) -> int:
        """Fade out all elements that match every given filter from `beat` on, from their current level.

        Elements that have not started are removed. `groups` matches elements that address any of these bits. Return the
        number of matches.
        """
        count = 0
        for row in reversed(range(len(self._table))):
            element = self._table.elements[row]
            fits = (source is None or element.source == source) and (kind is None or element.kind == kind)
            if not fits or (groups is not None and not element.groups & groups):
                continue
            count += 1
            if element.level(beat) > 0.0:
                self._table.replace(row, element.faded_out(beat))
            else:
                self._table.remove(row)
        return count

    def clear(self, beat: float) -> None:
        """Fade out every element from `beat` on."""
        self.end(beat)

    # -- each tick ---------------------------------------------------------------------------------------------

    def refresh(self, beat: float, commands: AgentCommand, state: Kinematics, groups: UInt64) -> None:
        """Update the acting elements at `beat` and assign targets of crossings; call once per tick, first.

        `groups` (A,) uint64: the bits of the groups each agent belongs to.
        """
        table, numbers = self._table, self._numbers
        table.refresh(beat)
        if table.is_active(CROSSING):
            assign_goals(
                table.rows, table.masks, table.vertices, table.active, state.position, commands.rows, groups,
                self._memory, numbers[HALF_WIDTH], numbers[HALF_DEPTH], int(numbers[SEED]),
            )  # fmt: skip
        numbers[PLACE_COUNT] = 0.0
        if table.is_active(PARTICIPANT):
            numbers[PLACE_COUNT] = find_places(
                table.rows, table.masks, table.active, self._places, self._audience, self._density
            )

    def preview(self, beat: float) -> None:
        """Set the elements expected to act at `beat`, before `apply` on a copy; the next `refresh` undoes it."""
        self._table.preview(beat)

    def apply(
        self,
        commands: AgentCommand,
        state: Kinematics,
        groups: UInt64,
        *,
        time: float,
        influence: Float32 | None = None,
    ) -> Float32:
        """Blend the elements into `commands`: (1 - influence) of the planned velocity and firmness, plus the elements'
        velocity.

        Also raises separation, alignment and cohesion to the elements' values. `time` [s] is the argument of the noise.
        Writes the influence of each agent, 0 to 1, into `influence` (A,) or else into the field's own array, and
        returns it. Has no other effect, so a look-ahead may call it on copies (with a separate `influence`).
        """
        out = self.influence if influence is None else influence
        table = self._table
        if not len(table.active_rows):
            out[:] = 0.0
            return out
        self._numbers[TIME] = time
        self._sum_kinds(commands.rows, state, groups)
        blend_sums(commands.rows, self._sums, out)
        return out

    def _sum_kinds(self, commands: Float32, state: Kinematics, groups: UInt64) -> None:
        """Add the wishes of each kind that acts to the sums (A, 5), urgent kinds first: a pass over the agents each."""
        table, numbers, sums, acts = self._table, self._numbers, self._sums, self._table.is_active
        rows, masks, vertices, active = table.rows, table.masks, table.vertices, table.active
        position, velocity = state.position, state.velocity
        reset_sums(rows, masks, active, commands, groups, sums)
        if acts(REPULSOR):
            self._follow_nearest(REPULSOR, position, groups, repels=True)
        if acts(EVADE):
            pursue_or_evade(rows, masks, active, True, position, velocity, commands, groups, numbers, sums)
        if acts(CROSSING):
            cross_over(rows, masks, active, position, groups, self._memory, numbers, sums)
        if acts(FOLLOW):
            follow_leaders(rows, masks, active, position, velocity, commands, groups, numbers, sums)
        if acts(PURSUE):
            pursue_or_evade(rows, masks, active, False, position, velocity, commands, groups, numbers, sums)
        if acts(PATH):
            follow_paths(rows, masks, vertices, active, position, velocity, commands, groups, numbers, sums)
        if acts(ATTRACTOR):
            self._follow_nearest(ATTRACTOR, position, groups, repels=False)
        if acts(PARTICIPANT):
            fair_attraction(self._places, self._audience, position, groups, numbers, sums)
        if acts(FLOW):
            flow_fields(rows, masks, vertices, active, table.grids, position, velocity, groups, numbers, sums)
        if acts(SPREADER):
            for row in active[ACTIVE_START + active[SPREADER] : ACTIVE_START + active[SPREADER + 1]].tolist():
                self._spread(row, position, commands, groups)
        if acts(WANDER) or acts(FLOCK) or acts(SPREADER):
            self._wander(position, velocity, groups)

    def _follow_nearest(self, kind: int, position: Float32, groups: UInt64, *, repels: bool) -> None:
        """Add the wishes of the agents by the nearest source of a kind."""
        table = self._table

        def part(begin: int, end: int) -> None:
            nearest_sources(
                table.rows, table.masks, table.vertices, table.active, kind, repels, position, groups, self._numbers,
                self._sums, self._nearest, begin, end,
            )  # fmt: skip

        run_rows(part, len(position), least=FEWEST_AGENTS)

    def _wander(self, position: Float32, velocity: Float32, groups: UInt64) -> None:
        """Add the wishes of the agents who wander, flock or spread."""
        table = self._table

        def part(begin: int, end: int) -> None:
            wander_agents(
                table.rows, table.masks, table.active, position, velocity, groups, self._numbers, self._sums, begin, end
            )

        run_rows(part, len(position), least=FEWEST_AGENTS)

    def _spread(self, row: int, position: Float32, commands: Float32, groups: UInt64) -> None:
        """Add the wishes of the agents whose newest spreader is the element `row`: even among all of them."""
        table, area, mesh, start, order = self._table, self._area, self._mesh, self._start, self._order
        members = find_members(table.rows, table.masks, table.active, row, commands, groups, order[0])
        if not members:
            return
        fill_spread_field(position, order[0], members, area, mesh, start, order[1])

        def part(begin: int, end: int) -> None:
            spread(members, area, mesh, start, order[1], self._spreading, begin, end)
            add_spreading(
                table.rows, row, commands, order[1], self._spreading, self._numbers, self._sums, begin, end
            )  # fmt: skip

        run_rows(part, members, least=FEWEST_AGENTS // 4)

    # -- drawing -----------------------------------------------------------------------------------------------

    def write_view(self, view: StageView) -> None:
        """Copy the acting elements into the drawing snapshot: kind, place, level, and the corners of lines and regions.

        Audience votes have kind VOICE. Corners that exceed the capacity are dropped, together with the line of their
        element.
        """
        table = self._table
        view.element_count = copy_active_elements(
            table.rows, table.active, table.outlines,
            view.element_kind, view.element_position, view.element_level, view.element_radius, view.element_strength,
            view.element_flow, view.element_first, view.element_corners, view.element_corner,
        )  # fmt: skip
