"""Voices: what each phone wants, and what all of them want together: a few places that many of them chose.

One voice for each phone. It weighs what its region weighs, all of that while it is fresh, and half of it a second after
its finger is lifted. Voices are gathered at the modes of their density (mean shift, Comaniciu and Meer 2002): who is
alone somewhere is no place beside a crowd, however far away or loud, so that one person has no force among many.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.control.audience.phone_protocol import ATTRACT, FULL_SCALE, REPEL, TOUCHES

Float64 = npt.NDArray[np.float64]

FRESH: Final = 0.75
"""A voice is fresh for so long [s] after its last message; fingers that rest say so three times a second."""
FADES: Final = 1.0
"""Half-life [s] of a voice that is not."""
GONE: Final = 0.05
"""A voice of which less than this is left is none."""
BANDWIDTH: Final = 1.2
"""Voices within this distance [m] of each other are one place."""
CELL: Final = 0.4
"""Cells [m] in which their density is looked for first."""
PLACES: Final = 4
LEAST: Final = 0.3
"""A place with a smaller part than this of the heaviest one's voices is none."""
FEW: Final = 4.0
ENOUGH: Final = 0.05
"""All of the force is there from this share of the phones on, and never with fewer than `FEW` of several."""
SHAKES: Final = 1.0
"""A phone that was shaken counts for so long [s]."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where voices gather: (x, z) [m], weight in parts of the heaviest place, mode."""

    x: float
    z: float
    weight: float
    mode: int


@dataclass(frozen=True, slots=True)
class Force:
    """What all want: how strongly, 0 to 1, where, and which share of those who play shakes."""

    share: float
    places: tuple[Place, ...]
    shaken: float


class Voices:
    """Voices in rows; each phone that is there has one. Thread: one."""

    def __init__(self, most: int) -> None:
        """`most`: so many phones at a time."""
        self.x: Float64 = np.zeros(most)
        self.z: Float64 = np.zeros(most)
        self.said: Float64 = np.full(most, -np.inf)
        """When each spoke last [s]."""
        self.shook: Float64 = np.full(most, -np.inf)
        self.mode = np.zeros(most, np.int8)
        self.held = np.zeros(most, np.bool_)
        """Whether the finger is on the glass."""
        self.region = np.zeros(most, np.int64)
        self.number = np.zeros(most, np.int64)
        """The phone's number; 0: the row is free."""
        self.heard = np.ones(most, np.bool_)
        """False for a phone that is banned."""
        self.part: Float64 = np.ones(most)
        """Which part of a voice each has."""
        self.said_now: dict[int, tuple[bytes, float]] = {}
        """What rows have said since the last `take_up`, as it came, and when [s]: the last of each counts."""
        self._free = list(range(most - 1, -1, -1))
        self._weights: Float64 = np.ones(1)
        self._half = (6.0, 4.0)

    @property
    def count(self) -> int:
        """Phones that are there."""
        return len(self.number) - len(self._free)

    def add(self, number: int, region: int, *, heard: bool) -> int:
        """A phone has joined: its row; -1 if there is no room."""
        if not self._free:
            return -1
        row = self._free.pop()
        self.number[row], self.region[row], self.heard[row] = number, region, heard
        self.mode[row], self.held[row], self.part[row] = 0, False, 1.0
        self.said[row] = self.shook[row] = -np.inf
        return row

    def remove(self, row: int) -> None:
        """A phone has gone."""
        self.number[row] = 0
        self.mode[row] = 0
        self.said_now.pop(row, None)
        self._free.append(row)

    def rule(self, weights: Sequence[float], banned: Sequence[int], half: tuple[float, float]) -> None:
        """What regions weigh, who is banned, and the stage's half sizes [m], from now on."""
        self._weights = np.array(weights or [1.0], np.float64)
        self.heard = ~np.isin(self.number, np.array(banned, np.int64))
        self._half = half

    def take_up(self) -> None:
        """Heed what rows have said: touches as in `wire`, which are well formed."""
        if not self.said_now:
            return
        rows = np.fromiter(self.said_now, np.int64, len(self.said_now))
        said = np.frombuffer(b"".join(data for data, _ in self.said_now.values()), TOUCHES)
        self.said[rows] = [when for _, when in self.said_now.values()]
        self.said_now.clear()
        self.held[rows] = said["mode"] != 0
        there = said["mode"] != 0
        rows, said = rows[there], said[there]
        self.mode[rows] = said["mode"]
        self.x[rows] = (2.0 * said["x"] / FULL_SCALE - 1.0) * self._half[0]
        self.z[rows] = (2.0 * said["z"] / FULL_SCALE - 1.0) * self._half[1]

    def touch(self, row: int, mode: int, x: float, z: float, now: float) -> None:
        """A finger is at (x, z), shares of the stage from the left and from the back, 0 to 1; or has gone (mode 0)."""
        if mode:
            self.mode[row] = mode
            self.x[row], self.z[row] = (2.0 * x - 1.0) * self._half[0], (2.0 * z - 1.0) * self._half[1]
        self.held[row] = mode != 0
        self.said[row] = now

    def weights(self, now: float) -> Float64:
        """What each row's voice weighs now, (N,)."""
        region = np.minimum(self.region, len(self._weights) - 1)
        age = np.maximum(now - self.said - FRESH * self.held, 0.0)
        fresh = 0.5 ** (age / FADES)
        weight = self._weights[region] * self.part * fresh
        weight[(fresh < GONE) | (self.mode == 0) | ~self.heard] = 0.0
        return weight

    def people(self) -> float:
        """How many voices there are in all, whether they speak or not: those that have a part of one count so much."""
        return float(self.part[(self.number > 0) & self.heard].sum())

    def shaken(self, now: float) -> float:
        """Which share of the voices is being shaken."""
        people = self.people()
        shaken = (now - self.shook < SHAKES) & self.heard & (self.number > 0)
        return min(float(self.part[shaken].sum()) / people, 1.0) if people > 0.0 else 0.0

    def force(self, now: float, weight: Float64 | None = None) -> Force:
        """What all of them want together; `weight`: what `weights` said."""
        count, shaken = self.people(), self.shaken(now)
        weight = self.weights(now) if weight is None else weight
        rows = np.flatnonzero(weight)
        if not len(rows):
            return Force(0.0, (), shaken)
        x, z, mode, weight = self.x[rows], self.z[rows], self.mode[rows], weight[rows]
        enough = max(min(FEW, count), ENOUGH * count)
        share = min(float(weight.sum()) / enough, 1.0) ** 2
        found = [
            place for kind in (ATTRACT, REPEL) for place in _places(x, z, np.where(mode == kind, weight, 0.0), kind)
        ]
        found.sort(key=lambda place: -place.weight)
        most = found[0].weight
        kept = [place for place in found[:PLACES] if place.weight >= LEAST * most]
        return Force(share, tuple(Place(p.x, p.z, p.weight / most, p.mode) for p in kept), shaken)


def _places(x: Float64, z: Float64, weight: Float64, mode: int) -> list[Place]:
    """The densest places of voices, heaviest first, with the weight around each.

    Voices of one cell are one, in their middle: so thousands cost no more than the cells that a stage has.
    """
    if not weight.any():
        return []
    x, z, left, wide = _cells(x, z, weight)
    found: list[Place] = []
    for _ in range(PLACES):
        around = _around(left, wide)
        best = int(np.argmax(around * (left > 0.0)))
        if left[best] <= 0.0:
            break
        at_x, at_z = float(x[best]), float(z[best])
        for _ in range(4):
            t = np.maximum(1.0 - ((x - at_x) ** 2 + (z - at_z) ** 2) / BANDWIDTH**2, 0.0)
            near = t * t * left
            total = float(near.sum())
            if total <= 0.0:
                break
            at_x, at_z = float(near @ x) / total, float(near @ z) / total
        within = ((x - at_x) ** 2 + (z - at_z) ** 2 < BANDWIDTH**2) & (left > 0.0)
        if not within.any():
            break
        found.append(Place(at_x, at_z, float(left[within].sum()), mode))
        left[within] = 0.0
    return found


def _cells(x: Float64, z: Float64, weight: Float64) -> tuple[Float64, Float64, Float64, int]:
    """The middle (x, z) of the voices in each cell [m] and their weight, in rows of `wide` cells with empty borders."""
    column = ((x - x.min()) / CELL).astype(np.int64) + 1
    row = ((z - z.min()) / CELL).astype(np.int64) + 1
    wide, deep = int(column.max()) + 2, int(row.max()) + 2
    cell, count = row * wide + column, wide * deep
    total: Float64 = np.bincount(cell, weight, count).astype(np.float64)
    parts = np.maximum(total, 1e-12)
    return np.bincount(cell, weight * x, count) / parts, np.bincount(cell, weight * z, count) / parts, total, wide


def _around(weight: Float64, wide: int) -> Float64:
    """The weight of each cell and its eight neighbours."""
    cells = weight.reshape(-1, wide)
    around = cells.copy()
    around[1:-1] += cells[:-2] + cells[2:]
    across = around.copy()
    across[:, 1:-1] += around[:, :-2] + around[:, 2:]
    return across.reshape(-1)
