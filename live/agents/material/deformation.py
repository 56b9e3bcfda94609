"""Deformation of a group's places and ways that keeps neighbours, bodies apart and everyone inside a region (T145).

The displacement from a first guess is as even along the edges of the neighbours as possible, as in Laplacian editing of
group motion (Kwon et al. 2008), while penalties keep bodies apart, places inside, ways smooth, and each edge of the
Delaunay graph an edge: the two angles opposite to it stay below half a turn together.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.agents.material.neighbours import neighbours_of, opposite_angles
from live.agents.material.room import LEAST_GAP, Room
from live.base.arrays import Float64, Int64

EASY_GAP: Final = 0.75
"""Distance of dancers that is aimed at where there is room [m]: straight ways into such places meet nowhere."""
EVEN: Final = 0.1
ANGLES: Final = 3.0
APART: Final = 30.0
INSIDE: Final = 30.0
SMOOTH: Final = 2.0
"""Weights of the even displacement, of the angles, of bodies, of the region, and of smooth ways."""
ANGLE_MARGIN: Final = 0.05
"""Two angles opposite to an edge are aimed to stay so far below half a turn [rad]."""
STAGES: Final = (1.0, 0.5, 0.2, 0.0, 0.0)
"""The region grows smaller in stages: shares of the greatest distance of a first place from it."""
ITERATIONS: Final = 60
"""Most iterations in each stage."""
INSET: Final = 0.02
"""Places are aimed so far inside the region [m]."""
WAY_INSET: Final = 0.06
"""Places of ways, which are not moved inside afterwards."""
FIRM: Final = 10.0
"""Weights of bodies and of the region are so many times as large in a last stage of ways."""
ROUNDS: Final = 400
"""Most rounds in which places are parted and moved inside."""
PRECISION: Final = 3
"""Decimals of the places [m], so that the last bits of a computer's arithmetic do not matter."""
WANTED_SHARE: Final = 0.95
"""Share of the edges that are to be kept."""


@dataclass(frozen=True, slots=True, eq=False)
class Deformed:
    """A deformed group."""

    places: Float64
    """Places of D dancers at S moments, (S, D, 2) [m]."""
    displacement: Float64
    """Displacement of C control points of each way from the first guess, (C, D, 2) [m]."""
    kept: float
    """Share of the neighbours, over all moments, who still are."""
    first: Float64
    """The first guess, (S, D, 2) [m]."""
    edges: Int64
    """The neighbours at the first moment, (E, 2)."""


class Deformation:
    """The places of D dancers at S moments, whose neighbours are to be kept."""

    def __init__(self, source: Float64, basis: Float64 | None = None, *, mirrored: bool = False) -> None:
        """`source` (S, D, 2) [m] says who are neighbours, `mirrored`: on the other side of each other; `basis` (S, C)
        makes places of C control points."""
        self._moments, self._count = source.shape[:2]
        self._basis = np.eye(self._moments) if basis is None else basis
        self._graphs = [neighbours_of(places, mirrored=mirrored) for places in source]
        self._edges = self._joined([graph.edges for graph in self._graphs])
        self._inner = self._joined([graph.inner for graph in self._graphs])
        self._side = np.concatenate([graph.side for graph in self._graphs])
        self._second = np.diff(np.eye(self._moments), 2, axis=0) if self._moments > 2 else None

    def _joined(self, rows: list[Int64]) -> Int64:
        """Return the rows of all moments with numbers of places counted on over the moments."""
        return np.concatenate([row + moment * self._count for moment, row in enumerate(rows)])

    def share_kept(self, places: Float64) -> float:
        """Return the share of the neighbours over all moments who are neighbours in `places` (S, D, 2)."""
        edges = [len(graph.edges) for graph in self._graphs]
        kept = [graph.share_kept(now) for graph, now in zip(self._graphs, places, strict=True)]
        return float(np.dot(kept, edges) / max(sum(edges), 1)) if sum(edges) else 1.0

    def solve(self, first: Float64, room: Room | None, gap: float = EASY_GAP) -> Deformed:
        """Return the deformed group for a first guess `first` (S, D, 2) [m], inside `room` if one is given.

        Distances of `gap` [m] are aimed at; of places (one moment) `LEAST_GAP` is then certain where there is room.
        """
        from scipy.optimize import minimize

        flat = first.reshape(-1, 2)
        displacement = np.zeros((self._basis.shape[1], self._count, 2))
        deepest = 0.0 if room is None else max(0.0, -float(room.depth(flat)[0].min()))
        length = np.maximum(np.hypot(*(flat[self._edges[:, 0]] - flat[self._edges[:, 1]]).T), 0.3)
        stages = [(stage, 1.0) for stage in (STAGES if room is not None else STAGES[-2:])]
        if self._moments > 1:
            stages.append((0.0, FIRM))
        for stage, firm in stages:
            now = first + np.einsum("sc,cdk->sdk", self._basis, displacement)
            task = (first, 1.0 / length**2, self._near(now, 2.5 * gap), gap, room, stage * deepest, firm)
            found = minimize(
                self._cost, displacement.ravel(), args=task, jac=True, method="L-BFGS-B",
                options={"maxiter": ITERATIONS},
            )  # fmt: skip
            displacement = found.x.reshape(displacement.shape)
        places = first + np.einsum("sc,cdk->sdk", self._basis, displacement)
        if self._moments == 1:
            finished = np.round(finish(places[0], room, gap), PRECISION)[None]
            displacement = finished - first
            places = finished
        return Deformed(places, displacement, self.share_kept(places), first, self._graphs[0].edges)

    def _near(self, places: Float64, distance: float) -> Int64:
        """Return the pairs of each moment within `distance` [m], (P, 2)."""
        from scipy.spatial import cKDTree

        return self._joined([cKDTree(now).query_pairs(distance, output_type="ndarray") for now in places])

    def _cost(
        self,
        values: Float64,
        first: Float64,
        even: Float64,
        near: Int64,
        gap: float,
        room: Room | None,
        beyond: float,
        firm: float,
    ) -> tuple[float, Float64]:
        """Return the cost of a displacement and its gradient."""
        moved = np.einsum("sc,cdk->sdk", self._basis, values.reshape(-1, self._count, 2))
        shift = moved.reshape(-1, 2)
        places = first.reshape(-1, 2) + shift
        sums = _Sums(len(places))
        uneven = shift[self._edges[:, 0]] - shift[self._edges[:, 1]]
        cost = EVEN * float((uneven * uneven * even[:, None]).sum())
        sums.add_pairs(self._edges, 2.0 * EVEN * even[:, None] * uneven)
        cost += self._add_angles(places, sums)
        if len(near):
            way = places[near[:, 0]] - places[near[:, 1]]
            apart = np.sqrt((way * way).sum(axis=1) + 1e-9)
            short = np.maximum(1.0 - apart / gap, 0.0)
            cost += firm * APART * float((short * short).sum())
            sums.add_pairs(near, (-2.0 * firm * APART * short / gap / apart)[:, None] * way)
        gradient = sums.total()
        if room is not None:
            depth, slope = room.depth(places)
            out = np.maximum((INSET if self._moments == 1 else WAY_INSET) - depth - beyond, 0.0)
            cost += firm * INSIDE * float((out * out).sum())
            gradient += (-2.0 * firm * INSIDE * out)[:, None] * slope
        by_moment = gradient.reshape(moved.shape)
        if self._second is not None:
            jerky = np.einsum("ts,sdk->tdk", self._second, moved)
            cost += SMOOTH * float((jerky * jerky).sum())
            by_moment = by_moment + 2.0 * SMOOTH * np.einsum("ts,tdk->sdk", self._second, jerky)
        return cost / self._moments, np.einsum("sc,sdk->cdk", self._basis, by_moment).ravel() / self._moments

    def _add_angles(self, places: Float64, sums: "_Sums") -> float:
        """Add the gradient of the angles opposite to the edges, and return their cost."""
        if not len(self._inner):
            return 0.0
        total = opposite_angles(self._inner, self._side, places).sum(axis=0)
        over = np.maximum(total - (np.pi - ANGLE_MARGIN), 0.0)
        bad = np.flatnonzero(over)
        first, second, factor = self._inner[bad, 0], self._inner[bad, 1], (2.0 * ANGLES * over[bad])[:, None]
        for corner in (0, 1):
            third, side = self._inner[bad, 2 + corner], self._side[bad, corner]
            at_first = factor * _across(places[first] - places[third], -side)
            at_second = factor * _across(places[second] - places[third], side)
            sums.add(first, at_first)
            sums.add(second, at_second)
            sums.add(third, -(at_first + at_second))
        return ANGLES * float((over * over).sum())


def _across(way: Float64, side: Float64) -> Float64:
    """Return the gradient of an angle by the end of one of its legs `way` (K, 2)."""
    square = np.maximum((way * way).sum(axis=1), 1e-4)
    return np.asarray(np.stack([-way[:, 1], way[:, 0]], axis=1) * (side / square)[:, None])


class _Sums:
    """Sums of vectors for each place, added together at the end."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._rows: list[Int64] = []
        self._values: list[Float64] = []

    def add(self, rows: Int64, values: Float64) -> None:
        self._rows.append(rows)
        self._values.append(values)

    def add_pairs(self, pairs: Int64, values: Float64) -> None:
        self.add(pairs[:, 0], values)
        self.add(pairs[:, 1], -values)

    def total(self) -> Float64:
        rows, values = np.concatenate(self._rows), np.concatenate(self._values)
        sums = [np.bincount(rows, values[:, axis], self._size) for axis in (0, 1)]
        return np.stack(sums, axis=1).astype(np.float64)  # without any rows they are integers


def finish(places: Float64, room: Room | None, gap: float) -> Float64:
    """Return `places` (D, 2) moved as little as needed so that all are inside and `LEAST_GAP` apart [m], or `gap` if
    that is less; if that does not succeed and there is room, on places of the room's lattice."""
    from scipy.spatial import cKDTree

    least = min(gap, LEAST_GAP) + 0.002  # places are rounded
    now = places if room is None else room.nearest(places)
    for _ in range(ROUNDS):
        pairs = cKDTree(now).query_pairs(least - 1e-4, output_type="ndarray")
        if not len(pairs):
            return now
        way = now[pairs[:, 0]] - now[pairs[:, 1]]
        apart = np.hypot(way[:, 0], way[:, 1])
        aside = np.stack([np.cos(pairs[:, 0] * 2.4), np.sin(pairs[:, 0] * 2.4)], axis=1)  # for two at one place
        way = np.where((apart > 1e-6)[:, None], way / np.maximum(apart, 1e-6)[:, None], aside)
        sums = _Sums(len(now))
        sums.add_pairs(pairs, 0.5 * (least + 1e-3 - apart)[:, None] * way)
        now = now + sums.total()
        now = now if room is None else room.nearest(now)
    return now if room is None or room.capacity < len(places) else _on_lattice(now, room)


def _on_lattice(places: Float64, room: Room) -> Float64:
    """Return places of the room's lattice, each near one of `places` (D, 2)."""
    from scipy.optimize import linear_sum_assignment

    way = places[:, None] - room.lattice[None]
    _, column = linear_sum_assignment((way * way).sum(axis=-1))
    return np.asarray(room.lattice[column])


def fitted_into(task: Deformation, guesses: list[Float64], room: Room, gap: float) -> Deformed:
    """Return the first of some guesses (S, D, 2) that keeps `WANTED_SHARE` of the neighbours when it is deformed into
    `room`, or the one that keeps most."""
    best: Deformed | None = None
    for guess in guesses:
        found = task.solve(guess, room, gap)
        if best is None or found.kept > best.kept:
            best = found
        if found.kept >= WANTED_SHARE:
            break
    assert best is not None
    return best
