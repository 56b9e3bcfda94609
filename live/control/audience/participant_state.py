"""State of each phone's voice, and the common places that many voices chose.

Each phone has one voice. Its weight is its region's weight; after the finger is lifted it halves every second. Voices
are clustered at the modes of their density (mean shift, Comaniciu and Meer 2002). A single voice far from a crowd forms
no place, so one person has no force among many.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.control.audience.phone_protocol import ATTRACT, FULL_SCALE, REPEL, TOUCHES

Float64 = npt.NDArray[np.float64]

FRESH: Final = 0.75
"""A voice keeps its full weight this long [s] after its last message; resting fingers send three messages a second."""
FADES: Final = 1.0
"""Half-life [s] of a voice after that."""
GONE: Final = 0.05
"""A voice below this share of its weight is ignored."""
BANDWIDTH: Final = 1.2
"""Voices within this distance [m] of each other form one place."""
CELL: Final = 0.4
"""Cell size [m] of the initial density estimate."""
PLACES: Final = 4
LEAST: Final = 0.3
"""Places with less than this share of the heaviest place's weight are ignored."""
FEW: Final = 4.0
ENOUGH: Final = 0.05
"""The force is full from this share of the phones on, but needs at least `FEW` phones if there are several."""
SHAKES: Final = 1.0
"""A shake counts this long [s]."""


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


class Voices:
    """Voices in rows, one per connected phone. Thread: one."""

    def __init__(self, most: int) -> None:
        """`most`: maximum number of simultaneous phones."""
        self.x: Float64 = np.zeros(most)
        self.z: Float64 = np.zeros(most)
        self.said: Float64 = np.full(most, -np.inf)
        """Time of each row's last message [s]."""
        self.shook: Float64 = np.full(most, -np.inf)
        self.mode = np.zeros(most, np.int8)
        self.held = np.zeros(most, np.bool_)
        """Whether the finger is on the screen."""
        self.region = np.zeros(most, np.int64)
        self.number = np.zeros(most, np.int64)
        """The phone's number; 0: the row is free."""
        self.heard = np.ones(most, np.bool_)
        """False for a banned phone."""
        self.part: Float64 = np.ones(most)
        """Fraction of a voice of each row."""
        self.said_now: dict[int, tuple[bytes, float]] = {}
        """Latest raw message and its time [s] of each row since the last `take_up`."""
        self._free = list(range(most - 1, -1, -1))
        self._weights: Float64 = np.ones(1)
        self._half = (6.0, 4.0)

    @property
    def count(self) -> int:
        """Number of connected phones."""
        return len(self.number) - len(self._free)

    def add(self, number: int, region: int, *, heard: bool) -> int:
        """Add a phone; return its row, -1 if there is no room."""
        if not self._free:
            return -1
        row = self._free.pop()
        self.number[row], self.region[row], self.heard[row] = number, region, heard
        self.mode[row], self.held[row], self.part[row] = 0, False, 1.0
        self.said[row] = self.shook[row] = -np.inf
        return row

    def remove(self, row: int) -> None:
        """Free a row."""
        self.number[row] = 0
        self.mode[row] = 0
        self.said_now.pop(row, None)
        self._free.append(row)

    def rule(self, weights: Sequence[float], banned: Sequence[int], half: tuple[float, float]) -> None:
        """Set the regions' weights, the banned phones, and the stage's half sizes [m]."""
        self._weights = np.array(weights or [1.0], np.float64)
        self.heard = ~np.isin(self.number, np.array(banned, np.int64))
        self._half = half

    def take_up(self) -> None:
        """Apply the collected touch messages, which are well formed (see `phone_protocol`)."""
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
        """Set a touch at (x, z), as shares of the stage from the left and the back, 0 to 1; mode 0 lifts the finger."""
        if mode:
            self.mode[row] = mode
            self.x[row], self.z[row] = (2.0 * x - 1.0) * self._half[0], (2.0 * z - 1.0) * self._half[1]
        self.held[row] = mode != 0
        self.said[row] = now

    def weights(self, now: float) -> Float64:
        """Return the present weight of each row, (N,)."""
        region = np.minimum(self.region, len(self._weights) - 1)
        age = np.maximum(now - self.said - FRESH * self.held, 0.0)
        fresh = 0.5 ** (age / FADES)
        weight = self._weights[region] * self.part * fresh
        weight[(fresh < GONE) | (self.mode == 0) | ~self.heard] = 0.0
        return weight

    def people(self) -> float:
        """Return the total number of voices, speaking or not; fractions of a voice are added."""
        return float(self.part[(self.number > 0) & self.heard].sum())

    def shaken(self, now: float) -> float:
        """Return the share of voices that are being shaken."""
        people = self.people()
        shaken = (now - self.shook < SHAKES) & self.heard & (self.number > 0)
        return min(float(self.part[shaken].sum()) / people, 1.0) if people > 0.0 else 0.0

    def force(self, now: float, weight: Float64 | None = None) -> Force:
        """Return the combined force; `weight`: the result of `weights`, if known."""
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
    """Return the densest places of voices, heaviest first, each with the weight around it.

    The voices of a cell are merged at their mean, so the cost is bounded by the stage's cells even with thousands.
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
    """Return each cell's mean (x, z) [m] and weight, in rows of `wide` cells with empty borders."""
    column = ((x - x.min()) / CELL).astype(np.int64) + 1
    row = ((z - z.min()) / CELL).astype(np.int64) + 1
    wide, deep = int(column.max()) + 2, int(row.max()) + 2
    cell, count = row * wide + column, wide * deep
    total: Float64 = np.bincount(cell, weight, count).astype(np.float64)
    parts = np.maximum(total, 1e-12)
    return np.bincount(cell, weight * x, count) / parts, np.bincount(cell, weight * z, count) / parts, total, wide


def _around(weight: Float64, wide: int) -> Float64:
    """Return the total weight of each cell and its eight neighbours."""
    cells = weight.reshape(-1, wide)
    around = cells.copy()
    around[1:-1] += cells[:-2] + cells[2:]
    across = around.copy()
    across[:, 1:-1] += around[:, :-2] + around[:, 2:]
    return across.reshape(-1)
