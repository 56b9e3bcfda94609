"""Elements as rows of numbers for the kernels, with a fixed capacity; a full table drops the oldest."""

from typing import Final

import numpy as np

from live.agents.elements import element_table_kernels
from live.agents.elements.element import FADE_BEATS, Element
from live.agents.elements.polyline_flow import GRID_COLUMNS, GRID_ROWS, flow_grid_along, simplified_vertices
from live.base.arrays import Float32, Float64, Int32, UInt64
from live.base.element_kinds import DRAWN, FLOW, GRID, KIND_COUNT, MAX_VERTICES, OUTLINE_VERTICES

GRID_SLOTS: Final = 8
"""Largest number of drawn flows; the oldest is replaced."""


class ElementTable:
    """Rows of elements, oldest first, in preallocated arrays."""

    def __init__(self, capacity: int, *, half_width: float, half_depth: float, separation: float) -> None:
        """`capacity` elements at most; half sizes of the stage [m]; default `separation` [m]."""
        self.elements: list[Element] = []
        # twice the capacity: the window of rows slides over it, so that dropping the oldest row moves no other
        self._all_rows: Float64 = np.zeros((2 * capacity, element_table_kernels.COLUMNS))
        self._all_masks: UInt64 = np.zeros(2 * capacity, np.uint64)
        self._all_vertices: Float32 = np.zeros((2 * capacity, MAX_VERTICES, 2), np.float32)
        self._all_outlines: Float32 = np.zeros((2 * capacity, OUTLINE_VERTICES, 2), np.float32)
        self._first = 0
        self._serials: dict[int, int] = {}  # by id() of the element
        self._voice_count = 0
        self.grids: Float32 = np.zeros((GRID_SLOTS, GRID_ROWS, GRID_COLUMNS, 2), np.float32)
        self.active: Int32 = np.zeros(KIND_COUNT + 1 + capacity, np.int32)
        """Start index of each kind, then the acting rows sorted by kind: see `refresh_table`."""
        self._half_size = (half_width, half_depth)
        self._separation = separation
        self._capacity = capacity
        self._serial = 0
        self._slot_use: list[int] = [0] * GRID_SLOTS
        self._slide(0)

    def _slide(self, first: int) -> None:
        self._first, window = first, slice(first, first + self._capacity)
        self.rows: Float64 = self._all_rows[window]
        self.masks: UInt64 = self._all_masks[window]
        self.vertices: Float32 = self._all_vertices[window]
        self.outlines: Float32 = self._all_outlines[window]

    def rebuild_index(self) -> None:
        """Rebuild the identity index after unpickling, which creates new element objects."""
        serials = self.rows[: len(self.elements), element_table_kernels.SERIAL]
        self._serials = {id(each): int(serial) for each, serial in zip(self.elements, serials, strict=True)}

    def row_of(self, element: Element) -> int | None:
        """Return the row of this element object, or None if it is not active."""
        serial = self._serials.get(id(element))
        if serial is None:
            return None
        return int(
            np.searchsorted(self.rows[: len(self.elements), element_table_kernels.SERIAL], serial)
        )  # rows are in order of their serials

    def resize(self, half_width: float, half_depth: float) -> None:
        """Set the stage's half sizes [m] and recompute drawn flows."""
        self._half_size = (half_width, half_depth)
        for row, element in enumerate(self.elements):
            if (
                element.kind == FLOW
                and element.flow_kind == DRAWN
                and self.rows[row, element_table_kernels.SLOT] >= 0.0
            ):
                self.grids[int(self.rows[row, element_table_kernels.SLOT])] = flow_grid_along(
                    element.points, *self._half_size
                )

    def __len__(self) -> int:
        return len(self.elements)

    def add(self, element: Element, grid: Float32 | None = None) -> bool:
        """Append a row. If the table is full, drop the oldest voice; if there is none, an element of the show drops the
        oldest.

        Return False if a voice finds only elements of the show, which it does not displace.
        """
        if len(self.elements) >= self._capacity:
            place = (
                next((row for row, old in enumerate(self.elements) if old.fair), None) if self._voice_count else None
            )
            if place is None and element.fair:
                return False
            self.remove(place or 0)
        row = len(self.elements)
        self.elements.append(element)
        self._serial += 1
        self._serials[id(element)] = self._serial
        self._voice_count += element.fair
        self.rows[row, element_table_kernels.SERIAL] = self._serial
        self.rows[row, element_table_kernels.SLOT] = -1.0
        self._write_row(row, element)
        if element.kind == FLOW and element.flow_kind in (DRAWN, GRID):
            self._assign_slot(row, flow_grid_along(element.points, *self._half_size) if grid is None else grid)
        return True

    def replace(self, row: int, element: Element) -> None:
        """Replace the element of a row; it keeps its serial, so a crossing does not start again."""
        old = self.elements[row]
        self.elements[row] = element
        self._serials[id(element)] = self._serials.pop(id(old))
        self._voice_count += element.fair - old.fair
        self._write_row(row, element)
        if element.kind == FLOW and element.flow_kind == DRAWN and element.points != old.points:
            self._assign_slot(row, flow_grid_along(element.points, *self._half_size))

    def _write_row(self, row: int, element: Element) -> None:
        points = element.points
        corners = points if len(points) <= MAX_VERTICES else simplified_vertices(points, MAX_VERTICES)
        outline = corners if len(corners) <= OUTLINE_VERTICES else simplified_vertices(points, OUTLINE_VERTICES)
        self.vertices[row, : len(corners)] = corners
        self.outlines[row, : len(outline)] = outline
        self.rows[row, : element_table_kernels.ELEMENT_COLUMNS] = element.table_row(
            self._separation, len(corners), len(outline)
        )
        self.masks[row] = element.groups

    def _assign_slot(self, row: int, grid: Float32) -> None:
        slot = int(self.rows[row, element_table_kernels.SLOT])
        serial = int(self.rows[row, element_table_kernels.SERIAL])
        if slot < 0 or self._slot_use[slot] != serial:
            slot = min(range(GRID_SLOTS), key=self._slot_use.__getitem__)
        for other in range(len(self.elements)):
            if other != row and self.rows[other, element_table_kernels.SLOT] == slot:  # its flow is replaced
                self.rows[other, element_table_kernels.STRENGTH], self.rows[other, element_table_kernels.SLOT] = (
                    0.0,
                    -1.0,
                )
        self._slot_use[slot] = serial
        self.rows[row, element_table_kernels.SLOT] = slot
        self.grids[slot] = grid

    def remove(self, row: int) -> None:
        """Remove a row; later rows move up."""
        if self.rows[row, element_table_kernels.SLOT] >= 0.0:
            self._slot_use[int(self.rows[row, element_table_kernels.SLOT])] = 0
        last = len(self.elements)
        self._voice_count -= self.elements[row].fair
        del self._serials[id(self.elements[row])]
        del self.elements[row]
        if row == 0 and self._first < self._capacity:
            self._slide(self._first + 1)
            return
        for array in (self.rows, self.masks, self.vertices, self.outlines):
            array[row : last - 1] = array[row + 1 : last]
        if row == 0:  # the window has reached the end of the array
            for array in (self._all_rows, self._all_masks, self._all_vertices, self._all_outlines):
                array[: last - 1] = array[self._first : self._first + last - 1]
            self._slide(0)

    def refresh(self, beat: float) -> None:
        """Update levels and the list of acting rows at `beat`; remove rows that have ended."""
        if element_table_kernels.refresh_table(self.rows, len(self.elements), beat, FADE_BEATS, self.active):
            for row in reversed(range(len(self.elements))):
                if self.elements[row].end_beat <= beat:
                    self.remove(row)
            element_table_kernels.refresh_table(self.rows, len(self.elements), beat, FADE_BEATS, self.active)

    def preview(self, beat: float) -> None:
        """Set levels and the list of acting rows for `beat`; no row is removed before the next `refresh`."""
        element_table_kernels.refresh_table(self.rows, len(self.elements), beat, FADE_BEATS, self.active)

    @property
    def active_rows(self) -> Int32:
        """Acting rows, sorted by kind."""
        first = KIND_COUNT + 1
        return self.active[first : first + int(self.active[KIND_COUNT])]

    def is_active(self, kind: int) -> bool:
        """Whether an element of this kind acts."""
        return bool(self.active[kind] < self.active[kind + 1])
