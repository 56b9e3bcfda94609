"""Patterns of garments: particles in rows and columns, what joins them, where they hang and what they keep out of.

A garment is a grid: row 0 lies on the body, the last row is the hem. A closed one (skirt, sleeve, ponytail) goes
around, so its last column is joined to its first. Particles are stored row by row, in each row the even columns first,
then the odd ones: so the constraints along a row are two runs (see `cloth_kernels`).
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64, Int32
from live.motion.cloth.body_sections import BRIDGES, LIMBS, limb_index
from live.motion.cloth.cloth_kernels import AT_MOST, EXACT, MATTER_COLUMNS
from live.motion.cloth.contact_kernels import CLOSED, COLUMNS, OPEN, PARTICLES
from live.motion.cloth.fabric import Fabric
from live.motion.skeleton import SKELETON

Pairs = Sequence[tuple[int, int]]
RestShape = Callable[[Float32], Float64]
"""Returns the particles' places in the rest pose, (rows, columns, 3) [m], on a body with these cross-sections."""

UPRIGHT: Final = "upright"
"""Instead of a joint: an upright one at the place of the garment's first joint; so a ribbon hangs from a hand."""
LONGEST: Final = 1.035
"""Cloth is stretched at most so many times along its columns, which hang from the body ..."""
WIDEST: Final = 1.035
"""... and along its rows."""
TETHER: Final = 1.01
"""A particle is at most so many times its way along the cloth from the row above that stays on the body."""
ROW_REPEATS: Final = 1
LAST_REPEATS: Final = 9
"""Sweeps along a row to limit its length, in a substep and in the last one of a tick."""
THICKNESS: Final = 0.014
"""Distance of particles from the body [m]."""
LEAST_SECTOR: Final = 0.4
"""Between two neighbours in a row of a tube is at least this share of the area that they have in a circle."""
LEAST_AROUND: Final = 0.1
"""The same for a row that stays around a limb, which may lie on one side within it."""
FOLDED: Final = 1.9
"""Distance between next but one neighbours in a row of a tube, in widths between neighbours: it hangs in folds."""
FOLD_SOFTNESS: Final = 2.0
"""How much softer cloth bends along its rows than down its columns, so that it still falls in folds."""
FLOOR_FRICTION: Final = 0.25
_REST: Final = SKELETON.rest_positions()


@dataclass(frozen=True, slots=True)
class Contact:
    """Particles of rows `first` to `last` keep out of a limb; `middles`: the middles between neighbours, too."""

    limb: str
    first: int
    last: int
    middles: bool = False
    often: bool = True
    """Whether in each substep, or only in every other one."""


@dataclass(frozen=True, slots=True)
class Pattern:
    """The description of a garment."""

    name: str
    kind: str
    """Its material: `cloth`, `hair` or `ribbon`."""
    rows: int
    columns: int
    closed: bool
    pinned_rows: int
    """The first so many rows stay on the body."""
    length: float
    """Length along a column from the first row to the last [m]."""
    widths: tuple[float, ...]
    """Length between neighbours in each row [m]."""
    joints: tuple[str, ...]
    """The joints that it hangs on, the first one is the one that carries it; `UPRIGHT` may follow."""
    rest_shape: RestShape
    share: tuple[tuple[float, ...], ...]
    """How much the second joint of a particle moves it where nothing is simulated, (rows, columns)."""
    second: tuple[tuple[int, ...], ...]
    """Index in `joints` of this second joint, (rows, columns)."""
    contacts: tuple[Contact, ...]
    sheared: bool = True
    """Whether it resists shearing."""
    tubular: bool = False
    """Whether its cross-section stays open, as a ponytail's."""
    around: tuple[str, int] = ("", 0)
    """The limb that a tube stays around, and the last row of it that does."""
    follows: float = 0.0
    """Share of its wearer's falls beyond gravity that it follows."""
    strands: bool = False
    """Whether neighbours in a row are only kept from parting, as hair is."""

    @property
    def count(self) -> int:
        """Number of particles."""
        return self.rows * self.columns

    @property
    def spacing(self) -> float:
        """Length between two rows [m]."""
        return self.length / (self.rows - 1)

    def place(self, row: int, column: int) -> int:
        """Return the index of a particle."""
        column %= self.columns
        return row * self.columns + (column % 2) * ((self.columns + 1) // 2) + column // 2

    def order(self) -> Int32:
        """Return the particle at each place of the grid, (rows, columns)."""
        return np.array([[self.place(r, c) for c in range(self.columns)] for r in range(self.rows)], np.int32)


@dataclass(frozen=True, slots=True, eq=False)
class CompiledPattern:
    """A pattern of a fabric as arrays for the kernels."""

    pattern: Pattern
    joints: Int32
    """Joints of the skeleton that it needs, (J,); the first one carries it."""
    standing: Float32
    """Where these are in the rest pose, relative to the first one, (J, 3) [m]."""
    limb_joint: Int32
    """Index in `joints` of each of its limbs' joints, (K,)."""
    limbs: Int32
    """Indices of these limbs, (K,)."""
    bridges: Int32
    """What is between two limbs, (N, 3): its place after the limbs, and theirs."""
    by: Int32
    """Indices in `joints` of the two joints that carry each particle as skin, (P, 2); -1: upright."""
    weight: Float32
    """Their shares, (P, 2)."""
    runs: Int32
    amounts: Float32
    limit_runs: Int32
    limits: Float32
    last_runs: Int32
    last_limits: Float32
    contacts: Int32
    more_contacts: Int32
    rings: Int32
    """Rows that keep their order around their middles, or around a limb, (N, 4), …"""
    areas: Float32
    """… and how, (N, 2): see `keep_order`."""
    matter: Float32
    order: Int32
    """The particle at each place of the grid, (rows, columns)."""

    def rest(self, sections: Float32) -> Float32:
        """Return the places of the particles relative to their two joints in the rest pose, (6, P) [m]; for an upright
        one the offset from the first joint."""
        points = np.empty((self.pattern.count, 3))
        points[self.order.ravel()] = self.pattern.rest_shape(sections).reshape(-1, 3)
        own = _REST[self.joints]
        first, second = own[self.by[:, 0]], own[np.maximum(self.by[:, 1], 0)]
        second = np.where(self.by[:, 1:] < 0, points, second)  # what hangs upright is turned by nothing
        out = np.concatenate([(points - first).T, (points - second).T])
        hanging = self.by[:, 1] < 0
        if hanging.any():  # the pin carries it, and the rest hangs down from there
            out[:3, hanging] = (points[self.order[0, 0]] - own[0])[:, None]
            out[3:, hanging] = (points[hanging] - points[self.order[0, 0]]).T
        return np.ascontiguousarray(out, np.float32)


def compile_pattern(pattern: Pattern, fabric: Fabric) -> CompiledPattern:
    """Return the arrays of a pattern; ValueError for one that the kernels cannot hold."""
    if pattern.columns > COLUMNS or (pattern.closed and pattern.columns % 2):
        raise ValueError(f"{pattern.name}: {pattern.columns} columns")
    limbs, bridges = _limbs(pattern)
    names = [name for name in pattern.joints if name != UPRIGHT]
    joints = [SKELETON.index(name) for name in names]
    joints += [joint for joint in dict.fromkeys(LIMBS[limb].joint for limb in limbs) if joint not in joints]
    order = pattern.order()
    by = np.zeros((pattern.count, 2), np.int32)
    weight = np.zeros((pattern.count, 2), np.float32)
    second = np.array([[-1 if pattern.joints[s] == UPRIGHT else s for s in row] for row in pattern.second])
    by[order.ravel(), 1] = second.ravel()
    weight[order.ravel(), 1] = np.array(pattern.share).ravel()
    weight[:, 0] = 1.0 - weight[:, 1]
    runs = _Runs(pattern)
    _add_structure(runs, pattern, fabric)
    _add_folds(runs, pattern, fabric)
    limits, last = _Runs(pattern), _Runs(pattern)
    _add_limits(limits, pattern, ROW_REPEATS)
    _add_limits(last, pattern, LAST_REPEATS)
    matter = np.zeros(MATTER_COLUMNS, np.float32)
    matter[:] = fabric.drag, fabric.gravity, THICKNESS, 0.012, FLOOR_FRICTION, fabric.facing, pattern.follows
    return CompiledPattern(
        pattern, np.array(joints, np.int32), (_REST[joints] - _REST[joints[0]]).astype(np.float32),
        np.array([joints.index(LIMBS[limb].joint) for limb in limbs], np.int32), np.array(limbs, np.int32),
        bridges, by, weight, *runs.arrays(), *limits.arrays(), *last.arrays(),
        _contacts(pattern, limbs, often=True), _contacts(pattern, limbs, often=False), *_rings(pattern, limbs), matter,
        order,
    )  # fmt: skip


def _limbs(pattern: Pattern) -> tuple[list[int], Int32]:
    """Return the limbs of a pattern, and what is between them."""
    touched = {contact.limb for contact in pattern.contacts}
    pairs = [pair for name, pair in BRIDGES.items() if name in touched]
    limbs = sorted({limb_index(name) for name in touched - BRIDGES.keys() | {one for pair in pairs for one in pair}})
    rows = [(len(limbs) + n, *(limbs.index(limb_index(name)) for name in pair)) for n, pair in enumerate(pairs)]
    return limbs, np.array(rows, np.int32).reshape(-1, 3)


class _Runs:
    """Constraints, gathered into runs."""

    def __init__(self, pattern: Pattern) -> None:
        self._pinned = pattern.pinned_rows * pattern.columns
        self._runs: list[tuple[int, int, int, int]] = []
        self._amounts: list[tuple[float, float, float, float]] = []

    def add(
        self, pairs: Iterable[tuple[int, int]], rest: float, *, kind: int = EXACT, compliance: float = 0.0,
        first_held: bool = False,
    ) -> None:  # fmt: skip
        """Add constraints of pairs of particles, none of which is in two of them. `first_held`: the first stays."""
        free = [(a, b) for a, b in pairs if max(a, b) >= self._pinned]
        begin = len(self._runs)
        for a, b in sorted(free):
            masses = (0.0 if a < self._pinned or first_held else 1.0, 0.0 if b < self._pinned else 1.0)
            amounts = (rest, compliance, *masses)
            last = self._runs[-1] if len(self._runs) > begin else None
            alike = last is not None and self._amounts[-1] == amounts
            if last is not None and alike and (last[1] + last[3], last[2] + last[3]) == (a, b):
                self._runs[-1] = (*last[:3], last[3] + 1)
                continue
            self._runs.append((kind, a, b, 1))
            self._amounts.append(amounts)

    def arrays(self) -> tuple[Int32, Float32]:
        return np.array(self._runs, np.int32).reshape(-1, 4), np.array(self._amounts, np.float32).reshape(-1, 4)


def _row_pairs(pattern: Pattern, row: int, step: int = 1) -> list[list[tuple[int, int]]]:
    """Return neighbours along a row, in lists in which no particle is twice."""
    columns = pattern.columns
    last = columns if pattern.closed else columns - step
    pairs = [(c, pattern.place(row, c), pattern.place(row, c + step)) for c in range(last)]
    return [[(a, b) for c, a, b in pairs if c // step % 2 == odd] for odd in (0, 1)]


def _add_structure(runs: _Runs, pattern: Pattern, fabric: Fabric) -> None:
    place, columns, rows = pattern.place, pattern.columns, pattern.rows
    for row in range(1, rows):
        runs.add([(place(row - 1, c), place(row, c)) for c in range(columns)], pattern.spacing)
        if row >= pattern.pinned_rows and columns > 1:
            for pairs in _row_pairs(pattern, row):
                kind = AT_MOST if pattern.strands else EXACT
                runs.add(pairs, pattern.widths[row], kind=kind)
    if pattern.sheared and columns > 1:
        last = columns if pattern.closed else columns - 1
        for row in range(1, rows):
            width = 0.5 * (pattern.widths[row - 1] + pattern.widths[row])
            long_ = float(np.hypot(pattern.spacing, width))
            left, right = (row % 2, 1 - row % 2)  # one diagonal of each cell, to the other side in every other row
            pairs = [(place(row - 1, c + left), place(row, c + right)) for c in range(last)]
            runs.add(pairs, long_, compliance=fabric.shear)
    for row in range(2, rows):
        pairs = [(place(row - 2, c), place(row, c)) for c in range(columns)]
        runs.add(pairs, 2.0 * pattern.spacing, compliance=fabric.bend)
    if pattern.tubular:
        for row in range(pattern.pinned_rows, rows):
            across = pattern.widths[row] / np.sin(np.pi / columns)
            for c in range(columns // 2):
                runs.add([(place(row, c), place(row, c + columns // 2))], float(across), compliance=fabric.bend)


def _add_folds(runs: _Runs, pattern: Pattern, fabric: Fabric) -> None:
    """Add what a tube of cloth has against bending along its rows."""
    if not pattern.closed or pattern.kind != "cloth":
        return
    for row in range(pattern.pinned_rows, pattern.rows):
        for pairs in _row_pairs(pattern, row, 2):
            runs.add(pairs, FOLDED * pattern.widths[row], compliance=FOLD_SOFTNESS * fabric.bend)


def _add_limits(limits: _Runs, pattern: Pattern, repeats: int) -> None:
    """Add the limits of lengths: `repeats` sweeps over the whole garment, then one from the body on in which what is
    above a row does not move any more, so that no column is longer than its limit."""
    place, columns, rows = pattern.place, pattern.columns, pattern.rows
    root = pattern.pinned_rows - 1
    for row in range(pattern.pinned_rows, rows):
        tethers = [(place(root, c), place(row, c)) for c in range(columns)]
        limits.add(tethers, TETHER * (row - root) * pattern.spacing, kind=AT_MOST)
    for sweep in range(repeats + 1):
        for row in range(pattern.pinned_rows, rows):
            for _ in range(1 if columns > 1 else 0):
                for pairs in _row_pairs(pattern, row):
                    limits.add(pairs, WIDEST * pattern.widths[row], kind=AT_MOST)
            above = [(place(row - 1, c), place(row, c)) for c in range(columns)]
            limits.add(above, LONGEST * pattern.spacing, kind=AT_MOST, first_held=sweep == repeats)


def _rings(pattern: Pattern, limbs: list[int]) -> tuple[Int32, Float32]:
    """Return the rows of a tube of cloth that keep their order, and twice their areas."""
    if not pattern.closed or pattern.kind != "cloth":
        return np.zeros((0, 4), np.int32), np.zeros((0, 2), np.float32)
    columns, half = pattern.columns, pattern.columns // 2
    name, last = pattern.around
    around = [limbs.index(limb_index(name)) if row <= last and name else -1 for row in range(pattern.rows)]
    rings = [(row * columns, half, half, around[row]) for row in range(pattern.rows)]
    circles = np.square(columns * np.array(pattern.widths)) / (2.0 * np.pi)
    least = np.where(np.array(around) < 0, LEAST_SECTOR, LEAST_AROUND)
    areas = np.stack([1.0 / circles, least * circles / columns], axis=1)
    return np.array(rings, np.int32), areas.astype(np.float32)


def _contacts(pattern: Pattern, limbs: list[int], *, often: bool) -> Int32:
    """Return the contacts that are kept in each substep (`often`), or the others: those that are less frequent, and the
    middles between particles."""
    out: list[tuple[int, int, int, int]] = []
    middles = CLOSED if pattern.closed else OPEN
    between = [name for name in BRIDGES if any(contact.limb == name for contact in pattern.contacts)]

    def place(contact: Contact) -> int:
        name = contact.limb
        return len(limbs) + between.index(name) if name in BRIDGES else limbs.index(limb_index(name))

    for contact in sorted(pattern.contacts, key=lambda contact: (contact.limb not in BRIDGES, place(contact))):
        limb = place(contact)
        for row in range(max(contact.first, pattern.pinned_rows), min(contact.last, pattern.rows - 1) + 1):
            if contact.often == often:
                out.append((row * pattern.columns, pattern.columns, limb, PARTICLES))
            if contact.middles and not often:
                out.append((row * pattern.columns, pattern.columns, limb, middles))
    return np.array(out, np.int32).reshape(-1, 4)
