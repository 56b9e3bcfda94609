"""Sketch of voices: sums over the cells of a fixed grid, from which the places that many voices chose are found.

The grid begins at the stage's corner, so it is the same in every gateway. A cell holds whole numbers only: the weight
of its voices, and the weighted places of the voices within it. Merging adds them, so it does not matter how voices are
divided among gateways, nor in which order sketches arrive (a mergeable summary: Agarwal et al., PODS 2012). Places
are the modes of the merged density (mean shift, Comaniciu and Meer 2002). A single voice far from a crowd forms no
place, so one person has no force among many.

A sketch has at most `MAX_SKETCH_BYTES`, however many voices it has: a bit for each cell, then for each cell in use its
weight (a half float: 0.05 %) and the mean place within it (2 bytes: 1 mm in a cell of 0.4 m).
"""

import math
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64, Int64
from live.control.audience.phone_protocol import ATTRACT, REPEL

UNIT: Final = 65536
"""Weight of one voice in whole numbers."""
BANDWIDTH: Final = 1.2
"""Voices within this distance [m] of each other form one place."""
CELL: Final = 0.4
"""Smallest size of a cell [m]."""
MAX_CELLS: Final = 600
"""Cells of a stage: one of 12 m by 8 m. Cells of a larger stage are larger."""
OFFSETS: Final = 255
"""Steps of a place within a cell."""
PLACES: Final = 4
STILL: Final = 0.0005
"""A place that moves by less [m] from step to step has been found."""
MIN_PLACE_WEIGHT: Final = 0.3
"""Places with less than this share of the heaviest place's weight are ignored."""
MIN_PHONES: Final = 4.0
FULL_FORCE_SHARE: Final = 0.05
"""The force is full from this share of the phones on, but needs at least `MIN_PHONES` phones if there are several."""
MODES: Final = (ATTRACT, REPEL)
MAX_HALF: Final = 500.0
"""Largest half size of a stage that is accepted from another process [m]."""
_TWICE: Final = 2.0 / BANDWIDTH**2
_HEAD: Final = struct.Struct("<BddQQ")
_VERSION: Final = 1
MAX_SKETCH_BYTES: Final = _HEAD.size + len(MODES) * (MAX_CELLS // 8 + 4 * MAX_CELLS)


def _weights() -> Int64:
    """Return the weight in `UNIT` of each half float that is one, by its bits, at least 1; 0 for 0."""
    halves = np.arange(0x7C00, dtype=np.uint16).view(np.float16)  # those after that are infinite, or negative
    found: Int64 = np.maximum(np.rint(halves.astype(np.float64) * UNIT), 1.0).astype(np.int64)
    found[0] = 0
    return found


_WEIGHTS: Final = _weights()


@dataclass(frozen=True, slots=True)
class Place:
    """A cluster of voices: (x, z) [m], weight relative to the heaviest place, mode."""

    x: float
    z: float
    weight: float
    mode: int


@dataclass(frozen=True, slots=True)
class Force:
    """Combined force: its strength, 0 to 1, its places, and the share of participants that shake."""

    share: float
    places: tuple[Place, ...]
    shaken: float


@dataclass(frozen=True, slots=True)
class VoiceGrid:
    """Cells of a stage with the half sizes `half` [m], in `rows` (along z) of `columns` (along x)."""

    half: tuple[float, float]
    cell: float
    columns: int
    rows: int

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.columns * self.rows

    def split(self, x: Float64, z: Float64) -> tuple[Int64, Int64, Int64]:
        """Return the cell of each place (x, z) [m], and where it lies in the cell in `OFFSETS` steps along x and z."""
        found = []
        for value, half, count in ((x, self.half[0], self.columns), (z, self.half[1], self.rows)):
            share = np.clip((value + half) / self.cell, 0.0, count)
            line = np.minimum(share.astype(np.int64), count - 1)
            found += [line, np.rint((share - line) * OFFSETS).astype(np.int64)]
        column, along_x, row, along_z = found
        return row * self.columns + column, along_x, along_z


@lru_cache(maxsize=8)
def grid_of(half: tuple[float, float]) -> VoiceGrid:
    """Return the grid of a stage with these half sizes [m]."""

    def count(cell: float) -> tuple[int, int]:
        return max(math.ceil(2.0 * half[0] / cell - 1e-9), 1), max(math.ceil(2.0 * half[1] / cell - 1e-9), 1)

    cell = CELL
    while math.prod(count(cell)) > MAX_CELLS:
        cell *= 1.02
    return VoiceGrid((float(half[0]), float(half[1])), cell, *count(cell))


@dataclass(frozen=True, slots=True, eq=False)
class VoiceSketch:
    """Sums of voices in the cells that are used. Whole numbers, weights in `UNIT`."""

    grid: VoiceGrid
    cells: Int64
    """(N,) rising: the cell, and for the second of `MODES` so many more as the grid has."""
    sums: Int64
    """(3, N): the weight of each of them, and the weight times the place in it along x and z."""
    people: int = 0
    """All voices, whether they speak or not."""
    shaken: int = 0
    """Voices that are being shaken."""

    @classmethod
    def of_voices(
        cls,
        grid: VoiceGrid,
        x: Float64,
        z: Float64,
        weight: Int64,
        mode: npt.NDArray[np.int8],
        people: int,
        shaken: int,
    ) -> "VoiceSketch":  # fmt: skip
        """Return the sketch of N voices: place (x, z) [m], weight, and mode, each (N,); weights are above 0."""
        cell, along_x, along_z = grid.split(x, z)
        cells = cell + grid.cells * (mode == REPEL)
        return cls(grid, *_added(grid, cells, np.stack([weight, weight * along_x, weight * along_z])), people, shaken)

    def scaled(self, share: float) -> "VoiceSketch":
        """Return it with all weights reduced to a share, 0 to 1."""
        part = round(share * 1024)
        sums = self.sums * part >> 10
        left = sums[0] > 0
        return VoiceSketch(
            self.grid, self.cells[left], sums[:, left], self.people * part >> 10, self.shaken * part >> 10
        )

    def total(self) -> int:
        """Return the weight of all that speak."""
        return int(np.add.reduce(self.sums[0]))

    # -- places ----------------------------------------------------------------------------------------------------

    def force(self) -> Force:
        """Return the combined force."""
        shaken = min(self.shaken / self.people, 1.0) if self.people > 0 else 0.0
        speaking = self.total()
        if not speaking:
            return Force(0.0, (), shaken)
        count = self.people / UNIT
        enough = max(min(MIN_PHONES, count), FULL_FORCE_SHARE * count)
        share = min(speaking / UNIT / enough, 1.0) ** 2 if enough > 0.0 else 0.0
        found: list[Place] = []
        for index, mode in enumerate(MODES):
            part = slice(*np.searchsorted(self.cells, (index * self.grid.cells, (index + 1) * self.grid.cells)))
            _add_places(found, self.grid, self.cells[part] - index * self.grid.cells, self.sums[:, part], mode)
        found.sort(key=lambda place: -place.weight)
        most = found[0].weight
        kept = [place for place in found[:PLACES] if place.weight >= MIN_PLACE_WEIGHT * most]
        return Force(share, tuple(Place(p.x, p.z, p.weight / most, p.mode) for p in kept), shaken)

    # -- bytes -----------------------------------------------------------------------------------------------------

    def encode(self) -> bytes:
        """Return it as bytes, `MAX_SKETCH_BYTES` at most."""
        flags = np.zeros(len(MODES) * self.grid.cells, np.bool_)
        flags[self.cells] = True
        weight = np.clip(self.sums[0] / UNIT, 2.0**-14, 65504.0).astype("<f2")
        means = (2 * self.sums[1:] + self.sums[0]) // (2 * self.sums[0])
        head: bytes = _HEAD.pack(_VERSION, *self.grid.half, self.people, self.shaken)
        return head + b"".join(part.tobytes() for part in (np.packbits(flags), weight, means.astype(np.uint8)))

    @classmethod
    def decode(cls, data: bytes) -> "VoiceSketch":
        """Return the sketch of these bytes; ValueError says what is wrong with them."""
        if not _HEAD.size <= len(data) <= MAX_SKETCH_BYTES or data[0] != _VERSION:
            raise ValueError(f"a sketch of version {_VERSION} with at most {MAX_SKETCH_BYTES} bytes expected")
        _, half_x, half_z, people, shaken = _HEAD.unpack_from(data)
        if not (0.0 < half_x <= MAX_HALF and 0.0 < half_z <= MAX_HALF):
            raise ValueError(f"half sizes of the stage between 0 and {MAX_HALF:g} m expected")
        grid = grid_of((half_x, half_z))
        count = len(MODES) * grid.cells
        flags = (count + 7) // 8
        if len(data) < _HEAD.size + flags:
            raise ValueError(f"{flags} bytes expected that say which cells are used")
        cells = np.unpackbits(np.frombuffer(data, np.uint8, flags, _HEAD.size), count=count).nonzero()[0]
        many, begin = len(cells), _HEAD.size + flags
        if len(data) != begin + 4 * many:
            raise ValueError(f"{begin + 4 * many} bytes expected for {many} cells")
        halves = np.frombuffer(data, "<u2", many, begin)
        sums: Int64 = np.empty((3, many), np.int64)
        try:
            _WEIGHTS.take(halves, out=sums[0])
        except IndexError:
            sums[0] = 0
        if many and not np.minimum.reduce(sums[0]):
            raise ValueError("weights of cells above 0 expected")
        np.multiply(np.frombuffer(data, np.uint8, 2 * many, begin + 2 * many).reshape(2, many), sums[0], out=sums[1:])
        return cls(grid, cells, sums, people, shaken)


def merge(grid: VoiceGrid, sketches: Iterable[VoiceSketch]) -> VoiceSketch:
    """Return the sum of sketches of one grid; those of another stage are left out."""
    there = [sketch for sketch in sketches if sketch.grid == grid]
    people, shaken = sum(sketch.people for sketch in there), sum(sketch.shaken for sketch in there)
    if not there:
        return VoiceSketch(grid, np.zeros(0, np.int64), np.zeros((3, 0), np.int64))
    cells = np.concatenate([sketch.cells for sketch in there])
    sums = np.concatenate([sketch.sums for sketch in there], axis=1)
    return VoiceSketch(grid, *_added(grid, cells, sums), people, shaken)


def _added(grid: VoiceGrid, cells: Int64, parts: Int64) -> tuple[Int64, Int64]:
    """Return the cells that are used, and the sums of the parts (3, N) of each; exact, as sums are below 2^53."""
    count = len(MODES) * grid.cells
    weight = np.bincount(cells, parts[0], count)
    used = weight.nonzero()[0]
    sums = [part[used] for part in (weight, *(np.bincount(cells, part, count) for part in parts[1:]))]
    return used, np.stack(sums).astype(np.int64)


def _add_places(found: list[Place], grid: VoiceGrid, used: Int64, sums: Int64, mode: int) -> None:
    """Add the densest places of voices, each with the weight around it, at most `PLACES`.

    `used`: cells (N,); `sums`: theirs (3, N).

    Those are left out that would be too light beside a place that was found before.
    """
    if not len(used):
        return
    weight, step = sums[0], grid.cell / OFFSETS
    row, column = np.divmod(used, grid.columns)
    x = column * grid.cell + sums[1] / weight * step - grid.half[0]
    z = row * grid.cell + sums[2] / weight * step - grid.half[1]
    # (x, z, 1, 1 - r^2 / B^2): one product gives 1 - d^2 / B^2 of the distance d to any centre, one more the mean
    at = np.empty((4, len(used)))
    at[0], at[1], at[2], at[3] = x, z, 1.0, 1.0 - (x * x + z * z) / BANDWIDTH**2
    left = weight / UNIT
    dense = np.zeros((grid.rows, grid.columns))
    down, across = _neighbours(grid.rows), _neighbours(grid.columns)
    most = max((place.weight for place in found), default=0.0)
    for _ in range(PLACES):
        if np.add.reduce(left) <= MIN_PLACE_WEIGHT * most:
            return
        dense.reshape(-1)[used] = left
        around = (down @ dense @ across).reshape(-1)[used]
        around *= left > 0.0
        centre = at[:2, int(around.argmax())].tolist()
        for _ in range(4):
            near = np.maximum(_closeness(at, centre), 0.0)
            near *= near
            near *= left
            sum_x, sum_z, total = (at[:3] @ near).tolist()
            if total <= 0.0:
                break
            before, centre = centre, [sum_x / total, sum_z / total]
            if math.dist(before, centre) < STILL:
                break
        within = _closeness(at, centre) > 0.0
        inside = float(left[within].sum())
        if inside <= 0.0:
            return
        found.append(Place(centre[0], centre[1], inside, mode))
        most = max(most, inside)
        left[within] = 0.0


def _closeness(at: Float64, centre: list[float]) -> Float64:
    """Return 1 - d^2 / `BANDWIDTH`^2 of the distance d to a centre (x, z) [m], (N,); `at`: see `_add_places`."""
    x, z = centre
    found: Float64 = np.array((x * _TWICE, z * _TWICE, -0.5 * _TWICE * (x * x + z * z), 1.0)) @ at
    return found


@lru_cache(maxsize=16)
def _neighbours(count: int) -> Float64:
    """Return the matrix that adds to each of so many lines its neighbours, (count, count)."""
    line = np.arange(count)
    found: Float64 = (np.abs(line[:, None] - line) <= 1).astype(np.float64)
    return found


def whole_weights(share: Float64 | Sequence[float]) -> Int64:
    """Return weights of voices as whole numbers."""
    found: Int64 = np.rint(np.asarray(share) * UNIT).astype(np.int64)
    return found
