"""ElementTable: elements as rows of numbers for the kernels; bounded, the oldest gives way."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.elements import element_table_kernels
from live.agents.elements.element import FADE_BEATS, Element
from live.agents.elements.element_kinds import CROSSING, DRAWN, FLOCK, FLOW, GRID, KIND_COUNT, VERTEX_COUNT
from live.agents.elements.polyline_flow import GRID_COLUMNS, GRID_ROWS, corners_of, grid_along

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]

SLOTS: Final = 8
"""Drawn flows at a time; the flow drawn first gives way."""
CROSSING_SEPARATION: Final = 0.7
"""Dancers who cross keep this distance [m]: more would hold the two streams apart."""


class ElementTable:
    """Rows of elements, oldest first, in arrays that are allocated once."""

    def __init__(self, capacity: int, *, half_width: float, half_depth: float, separation: float) -> None:
        """`capacity` elements at most; half sizes of the stage [m]; the usual `separation` [m]."""
        self.elements: list[Element] = []
        # twice the room, over which the window of the rows slides: so the oldest gives way without moving the others
        self._all_rows: Float64 = np.zeros((2 * capacity, element_table_kernels.COLUMNS))
        self._all_masks: UInt64 = np.zeros(2 * capacity, np.uint64)
        self._all_vertices: Float32 = np.zeros((2 * capacity, VERTEX_COUNT, 2), np.float32)
        self._first = 0
        self._serials: dict[int, int] = {}  # by the elements' identity
        self._fair = 0
        self.grids: Float32 = np.zeros((SLOTS, GRID_ROWS, GRID_COLUMNS, 2), np.float32)
        self.active: Int32 = np.zeros(KIND_COUNT + 1 + capacity, np.int32)
        """Where each kind begins, and the rows that act, sorted by kind: see `refresh_table`."""
        self._half = (half_width, half_depth)
        self._separation = separation
        self._capacity = capacity
        self._serial = 0
        self._slot_use: list[int] = [0] * SLOTS
        self._slide(0)

    def _slide(self, first: int) -> None:
        self._first, window = first, slice(first, first + self._capacity)
        self.rows: Float64 = self._all_rows[window]
        self.masks: UInt64 = self._all_masks[window]
        self.vertices: Float32 = self._all_vertices[window]

    def number_again(self) -> None:
        """Find elements by those that there are now: those that were read back are others."""
        serials = self.rows[: len(self.elements), element_table_kernels.SERIAL]
        self._serials = {id(each): int(serial) for each, serial in zip(self.elements, serials, strict=True)}

    def row_of(self, element: Element) -> int | None:
        """Where this very element is; None if it is not in force."""
        serial = self._serials.get(id(element))
        if serial is None:
            return None
        return int(
            np.searchsorted(self.rows[: len(self.elements), element_table_kernels.SERIAL], serial)
        )  # rows keep their order

    def resize(self, half_width: float, half_depth: float) -> None:
        """The stage's half sizes [m] are these from now on: drawn flows are laid over it anew."""
        self._half = (half_width, half_depth)
        for row, element in enumerate(self.elements):
            if element.kind == FLOW and element.flow == DRAWN and self.rows[row, element_table_kernels.SLOT] >= 0.0:
                self.grids[int(self.rows[row, element_table_kernels.SLOT])] = grid_along(element.points, *self._half)

    def __len__(self) -> int:
        return len(self.elements)

    def add(self, element: Element, grid: Float32 | None = None) -> bool:
        """Put one more row at the end. If all are taken, the oldest voice gives way, to others also the oldest element.

        False if a voice found only elements of the show itself, which it does not push out.
        """
        if len(self.elements) >= self._capacity:
            place = next((row for row, old in enumerate(self.elements) if old.fair), None) if self._fair else None
            if place is None and element.fair:
                return False
            self.remove(place or 0)
        row = len(self.elements)
        self.elements.append(element)
        self._serial += 1
        self._serials[id(element)] = self._serial
        self._fair += element.fair
        self.rows[row, element_table_kernels.SERIAL] = self._serial
        self.rows[row, element_table_kernels.SLOT] = -1.0
        self._write(row, element)
        if element.kind == FLOW and element.flow in (DRAWN, GRID):
            self._take_slot(row, grid_along(element.points, *self._half) if grid is None else grid)
        return True

    def replace(self, row: int, element: Element) -> None:
        """Put `element` into the place of another; it keeps its number, so a crossing is not danced again."""
        old = self.elements[row]
        self.elements[row] = element
        self._serials[id(element)] = self._serials.pop(id(old))
        self._fair += element.fair - old.fair
        self._write(row, element)
        if element.kind == FLOW and element.flow == DRAWN and element.points != old.points:
            self._take_slot(row, grid_along(element.points, *self._half))

    def _write(self, row: int, element: Element) -> None:
        corners = corners_of(element.points)
        self.vertices[row, : len(corners)] = corners
        usual = CROSSING_SEPARATION if element.kind == CROSSING else self._separation
        flock = element.kind == FLOCK
        values = {
            element_table_kernels.START: element.start_beat,
            element_table_kernels.END: element.end_beat,
            element_table_kernels.KIND: element.table_kind,
            element_table_kernels.STRENGTH: element.strength,
            element_table_kernels.CORNERS: len(corners),
            element_table_kernels.CLOSED: element.closed and len(corners) > 2,
            element_table_kernels.RADIUS: element.radius,
            element_table_kernels.DECAY: element.decay_length,
            element_table_kernels.SEPARATION: usual if element.separation is None else element.separation,
            element_table_kernels.ALIGNMENT: element.alignment if flock else 0.0,
            element_table_kernels.COHESION: element.cohesion if flock else 0.0,
            element_table_kernels.FLOW_KIND: element.flow,
            element_table_kernels.TARGET: element.target,
            element_table_kernels.TARGET_GROUP: element.target_group,
            element_table_kernels.WEDGE: element.wedge,
            element_table_kernels.X: element.x,
            element_table_kernels.Z: element.z,
        }
        own = self.rows[row]
        for place, value in values.items():
            own[place] = value
        self.masks[row] = element.groups

    def _take_slot(self, row: int, grid: Float32) -> None:
        slot = int(self.rows[row, element_table_kernels.SLOT])
        serial = int(self.rows[row, element_table_kernels.SERIAL])
        if slot < 0 or self._slot_use[slot] != serial:
            slot = min(range(SLOTS), key=self._slot_use.__getitem__)
        for other in range(len(self.elements)):
            if other != row and self.rows[other, element_table_kernels.SLOT] == slot:  # its flow has given way
                self.rows[other, element_table_kernels.STRENGTH], self.rows[other, element_table_kernels.SLOT] = (
                    0.0,
                    -1.0,
                )
        self._slot_use[slot] = serial
        self.rows[row, element_table_kernels.SLOT] = slot
        self.grids[slot] = grid

    def remove(self, row: int) -> None:
        """Take one row out; those after it move up."""
        if self.rows[row, element_table_kernels.SLOT] >= 0.0:
            self._slot_use[int(self.rows[row, element_table_kernels.SLOT])] = 0
        last = len(self.elements)
        self._fair -= self.elements[row].fair
        del self._serials[id(self.elements[row])]
        del self.elements[row]
        if row == 0 and self._first < self._capacity:
            self._slide(self._first + 1)
            return
        for array in (self.rows, self.masks, self.vertices):
            array[row : last - 1] = array[row + 1 : last]
        if row == 0:  # the window has come to the end of its room
            for array in (self._all_rows, self._all_masks, self._all_vertices):
                array[: last - 1] = array[self._first : self._first + last - 1]
            self._slide(0)

    def refresh(self, beat: float) -> None:
        """Set levels and the list of who acts at `beat`; rows that have ended go."""
        if element_table_kernels.refresh_table(self.rows, len(self.elements), beat, FADE_BEATS, self.active):
            for row in reversed(range(len(self.elements))):
                if self.elements[row].end_beat <= beat:
                    self.remove(row)
            element_table_kernels.refresh_table(self.rows, len(self.elements), beat, FADE_BEATS, self.active)

    def foresee(self, beat: float) -> None:
        """Set levels and the list of who acts as they will be at `beat`; all rows stay, until the next `refresh`."""
        element_table_kernels.refresh_table(self.rows, len(self.elements), beat, FADE_BEATS, self.active)

    @property
    def acting(self) -> Int32:
        """The rows that act, sorted by kind."""
        first = KIND_COUNT + 1
        return self.active[first : first + int(self.active[KIND_COUNT])]

    def acts(self, kind: int) -> bool:
        """Whether an element of this kind acts."""
        return bool(self.active[kind] < self.active[kind + 1])
