"""Dancing along a drawn line: targets per measure, and a beam search for clips, mixtures and turns (T067-T070).

Targets are a place and a heading at the end of each measure (T067, T068, T127, T128). Places are positions, not
distances: a dancer who ends a measure off the path aims at the next place from the actual position, so errors do not
add up (T068).

The beam of hypotheses advances measure by measure; each holds the dancer's actual position. Steps wanted later are
never lost, because the number of wrong steps from every node to the end is computed exactly in advance.
"""

import math
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64, Int32
from live.base.errors import PersonError
from live.graph.motion_graph import MotionGraph
from live.graph.search.sequence_diagnostics import cost_to_go, wrong_steps
from live.graph.select.candidates import (
    Candidates,
    find_candidates,
    following_placement,
    next_axes,
    starting_placement,
    turn_vectors,
    wrap_angle,
)

MAX_POINTS: Final = 100_000
MAX_COORDINATE: Final = 1000.0
"""A place farther than this [m] from the centre of the stage is treated as a typing error."""
MIN_DISTANCE: Final = 1e-3
"""A path shorter than this [m] has no direction."""
Facing = Literal["public", "path"]


@dataclass(frozen=True, slots=True, eq=False)
class Targets:
    """Targets of a dancer at the N + 1 measure lines of a path, including the first."""

    place: Float64
    """x, z [m], shape (N + 1, 2)."""
    heading: Float64
    """Target heading [rad], unwrapped: a full turn is 2π away; shape (N + 1,)."""

    @property
    def measures(self) -> int:
        """Number of measures N."""
        return len(self.place) - 1

    @property
    def distances(self) -> Float64:
        """Return the straight distance of each measure [m], shape (N,)."""
        return np.asarray(np.hypot(*np.diff(self.place, axis=0).T), np.float64)


def read_path(text: str) -> Float64:
    """Parse the points (K, 2) of "x,z,x,z,…" [m]; semicolons and blanks may separate pairs. Raises PersonError."""
    words = [word.strip() for word in text.replace(";", ",").split(",")]
    if len(words) > 2 * MAX_POINTS:
        raise PersonError(f"path: {len(words)} numbers, at most {2 * MAX_POINTS} are read", "give fewer points")
    if len(words) % 2 or len(words) < 4:
        raise PersonError(
            f"path {_shortened(text)!r}: {len(words)} numbers read, an even number of at least 4 expected",
            'give points as x,z pairs in metres, as in "0,0, 4,0, 4,4"',
        )
    values = []
    for place, word in enumerate(words, start=1):
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not abs(value) <= MAX_COORDINATE:
            raise PersonError(
                f"path: number {place} is {_shortened(word)!r}, a number from {-MAX_COORDINATE:g} to "
                f"{MAX_COORDINATE:g} expected",
                "x goes to the right of the audience and z towards it, both in metres from the centre of the stage",
            )
        values.append(value)
    return np.array(values).reshape(-1, 2)


def follow_line(points: npt.ArrayLike, measures: int, *, facing: Facing | tuple[float, float] = "public") -> Targets:
    """Divide the line through `points` (K, 2) [m] into `measures` parts of equal length (T067).

    `facing`: "public" (heading 0), "path" (along the path at the middle of each measure), or two headings [rad] between
    which it turns evenly in the shorter direction. Repeated points count once; a line of no length is a dance on the
    spot. ValueError for no points, numbers that are not finite, or fewer than one measure.
    """
    points = np.asarray(points, np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or not len(points) or not np.isfinite(points).all():
        raise ValueError(f"points: finite numbers of shape (K, 2) expected, got shape {points.shape}")
    if measures < 1:
        raise ValueError(f"{measures} measures: at least 1 expected")
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    at = np.linspace(0.0, along[-1], measures + 1)
    place = np.stack([np.interp(at, along, points[:, axis]) for axis in (0, 1)], axis=1)
    place[-1] = points[-1]
    if facing == "public":
        heading = np.zeros(measures + 1)
    elif facing == "path":
        heading = along_headings(place)
    else:
        first, last = facing
        turn = math.remainder(last - first, 2.0 * math.pi)
        heading = first + turn * np.arange(measures + 1) / measures
    return Targets(place, heading)


def along_headings(place: Float64) -> Float64:
    """Return headings [rad], unwrapped, (N + 1,): at each place along the path to it; the first like the second."""
    way = np.diff(place, axis=0)
    moves = np.hypot(*way.T) > MIN_DISTANCE
    if not moves.any():
        return np.zeros(len(place))
    direction = np.arctan2(way[:, 0], way[:, 1])
    last = np.maximum.accumulate(np.where(moves, np.arange(len(way)), -1))  # a standing dancer keeps the last direction
    direction = direction[np.where(last >= 0, last, int(np.argmax(moves)))]
    return np.unwrap(np.concatenate((direction[:1], direction)))


def smooth_headings(heading: npt.ArrayLike) -> Float64:
    """Return O'(n) = 0.25 O(n - 1) + 0.5 O(n) + 0.25 O(n + 1) of headings (N,) [rad], unwrapped first (T127).

    The first and the last are repeated beyond the ends, so they change only by a quarter of the difference to their
    neighbours.
    """
    unwrapped = np.unwrap(np.asarray(heading, np.float64))
    held = np.concatenate((unwrapped[:1], unwrapped, unwrapped[-1:]))
    return 0.25 * held[:-2] + 0.5 * held[1:-1] + 0.25 * held[2:]


def smoothed(targets: Targets) -> Targets:
    """Return the targets with smoothed headings (T127); the places stay."""
    return Targets(targets.place, smooth_headings(targets.heading))


def _shortened(text: str) -> str:
    return text if len(text) <= 40 else text[:37] + "…"


@dataclass(frozen=True, slots=True, eq=False)
class FollowedPath:
    """The dance over M measures, and its errors relative to the targets."""

    node: Int32
    """Shape (M,)."""
    take: Int32
    """Node of the other take that is mixed in, NO_TAKE if none, shape (M,)."""
    share: Float64
    """Share of the other take, shape (M,)."""
    turn: Float64
    """Turn on the supporting foot in each measure [rad], shape (M,)."""
    correction: Float64
    """Additional displacement of the hips [m], shape (M, 2)."""
    place: Float64
    """Place of the hips at the end of each measure [m], shape (M, 2)."""
    error: Float64
    """Distance from the target [m], shape (M,)."""
    heading_error: Float64
    """Absolute difference to the target heading [rad], shape (M,)."""
    wrong: Bool
    """Measures with another step than the wanted one, shape (M,)."""


BEAM: Final = 48
MAX_CANDIDATES: Final = 40_000
"""Candidates evaluated for one measure; of more, those whose own clips come nearest, to bound the time."""
MAX_PER_NODE: Final = 6
"""Hypotheses kept in one node: more would hardly differ."""
HEADING_COST: Final = 0.05
"""Cost of a radian of heading error, in square metres of place error..."""
EDGE_COST: Final = 0.05
"""... of a metre between the poses of a join..."""
TURN_COST: Final = 0.005
"""... of a radian of turning in a measure, to avoid turning back and forth..."""
WRONG_COST: Final = 1e4
"""... and of a measure of another step: more than any place on the stage."""
FAR_THRESHOLD: Final = 0.1
FAR_COST: Final = 20.0
"""A place farther than NEAR [m] from its target costs in addition FAR times the square of the excess: one large error
is more visible than many small ones."""
CORRECTION_COST: Final = 0.3
"""Cost of a square metre of correction."""


def follow_path(
    graph: MotionGraph,
    targets: Targets,
    *,
    seconds: float,
    wanted: npt.ArrayLike | None = None,
    fits: Bool | None = None,
    correction_m: float = 0.0,
    candidates: Candidates | None = None,
    beam: int = BEAM,
) -> FollowedPath:
    """Return a dance along `targets` (M measures of `seconds`), beginning at the first of them.

    `wanted` (M,) are steps by index, `ANY` for any; `fits` (M, N) defines which nodes may be danced when (see
    `SequenceSpec`); with both, both must hold. Where no fitting node can be reached, something else is danced, in as
    few measures as possible. `correction_m` [m]: how far the hips may be displaced each measure beyond the clips; foot
    lock hides it within leg reach. Deterministic. ValueError for arrays of other lengths, or no measure.
    """
    count = targets.measures
    if count < 1 or not seconds > 0.0:
        raise ValueError(f"{count} measures of {seconds} s: at least one, longer than 0, expected")
    wrong = wrong_steps(graph, count, wanted, fits)
    search = _Search(
        graph, candidates if candidates is not None else find_candidates(graph), targets, seconds, correction_m, beam
    )
    return search.run(wrong, cost_to_go(graph, wrong))


@dataclass(frozen=True, slots=True, eq=False)
class _Front:
    """B hypotheses after a measure."""

    cost: Float64
    """Costs so far without that of this measure's end, which is known only when the next clip joins, (B,)."""
    node: Int32
    hips: Float64
    """(B, 2)"""
    heading: Float64
    back: Int32
    """Rows of the previous front, (B,)."""
    row: Int32
    """Candidates, (B,)."""
    turn: Float64
    correction: Float64
    """(B, 2)"""
    start_state: Float64
    """Hips and heading error at the beginning of this measure, (B, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    graph: MotionGraph
    candidates: Candidates
    targets: Targets
    seconds: float
    correction_m: float
    beam: int

    def run(self, wrong: Bool, to_go: Float64) -> FollowedPath:
        fronts = [self._begin(wrong[0], to_go[0])]
        for n in range(1, len(wrong)):
            fronts.append(self._continue(fronts[-1], n, wrong[n], to_go[n]))
        last = fronts[-1]
        return self._result(
            fronts, int(np.argmin(last.cost + self._end_cost(len(wrong), last.hips, last.heading))), wrong
        )

    def _begin(self, wrong: Bool, to_go: Float64) -> _Front:
        """Return the front of all steps that can be begun at the first place of the path."""
        library, first = self.graph.library, self.targets
        node = np.flatnonzero(self.graph.alive & np.isfinite(to_go)).astype(np.int32)
        if (library.node_measure[node] == 0).any():
            node = node[library.node_measure[node] == 0]
        if not len(node):
            raise ValueError("no step can begin: no node of the graph has a successor")
        count = len(node)
        placement = starting_placement(
            self.graph, node, np.tile(first.place[0], (count, 1)), np.full(count, first.heading[0])
        )  # fmt: skip
        start = np.column_stack([np.tile(first.place[0], (count, 1)), np.zeros(count)])
        cost = WRONG_COST * wrong[node].astype(np.float64)
        return self._evaluate(1, np.zeros(count, np.int32), cost, node, placement, start, to_go)

    def _continue(self, front: _Front, n: int, wrong: Bool, to_go: Float64) -> _Front:
        """Return the front of all nodes that can follow the hypotheses of `front` in measure n."""
        graph, library = self.graph, self.graph.library
        axes = next_axes(graph, front.node, front.hips, front.heading)
        first, last = graph.edge_start[front.node], graph.edge_start[front.node + 1]
        back = np.repeat(np.arange(len(front.node), dtype=np.int32), last - first)
        edge = np.concatenate([np.arange(a, b) for a, b in zip(first, last, strict=True)])
        node = graph.edge_target[edge]
        ahead = wrong[node] + to_go[node]
        useful = ahead <= ahead.min() + 1.0  # a detour costs more than any place on the stage
        back, edge, node = back[useful], edge[useful], node[useful]
        placement = following_placement(axes[back], graph.edge_transform[edge])
        hips = placement[:, :2] + turn_vectors(graph.node_start[node], placement[:, 2])
        heading = placement[:, 2] + graph.node_facing_start[node]
        inner = library.node_measure[node] > 0
        hips[inner], heading[inner] = front.hips[back[inner]], front.heading[back[inner]]
        cost = front.cost[back] + WRONG_COST * wrong[node] + EDGE_COST * graph.edge_cost[edge]
        cost += self._end_cost(n, hips, heading)
        off = wrap_angle(heading - self.targets.heading[n])
        return self._evaluate(n + 1, back, cost, node, placement, np.column_stack([hips, off]), to_go)

    def _end_cost(self, line: int, hips: Float64, heading: Float64) -> Float64:
        error = np.hypot(*(hips - self.targets.place[line]).T)
        off = wrap_angle(heading - self.targets.heading[line])
        return np.asarray(error**2 + FAR_COST * np.maximum(error - FAR_THRESHOLD, 0.0) ** 2 + HEADING_COST * off**2)

    def _evaluate(
        self, line: int, back: Int32, cost: Float64, node: Int32, placement: Float64, start: Float64, to_go: Float64
    ) -> _Front:
        """Return the best candidates of all `node` (n,), each at its placement, for the measure before `line`."""
        entry = self._preselect(line, cost, node, placement, to_go)
        count = np.diff(self.candidates.first)[node[entry]]
        before = np.repeat(np.cumsum(count) - count, count)
        row = np.repeat(self.candidates.first[node[entry]], count) + np.arange(count.sum()) - before
        entry = np.repeat(entry, count)
        return self._best_of(line, row.astype(np.int32), entry, back, cost, node, placement, start, to_go)

    def _preselect(
        self, line: int, cost: Float64, node: Int32, placement: Float64, to_go: Float64
    ) -> npt.NDArray[np.int64]:
        """Return the rows of `node` to try: all, or, of too many, those whose own clips, unmixed, come nearest."""
        count = np.diff(self.candidates.first)[node]
        if count.sum() <= MAX_CANDIDATES:
            return np.arange(len(node))
        row = self.candidates.first[node]
        _, _, hips, heading = self._ends(line, row, placement)
        score = cost + self._end_cost(line, hips, heading) + WRONG_COST * to_go[node]
        order = np.argsort(score, kind="stable")
        return np.sort(order[np.cumsum(count[order]) <= MAX_CANDIDATES])

    def _ends(self, line: int, row: Int32, placement: Float64) -> tuple[Float64, Float64, Float64, Float64]:
        """Return turn, correction (n, 2), hips (n, 2) and heading of candidates `row` (n,) at `placement` (n, 3)."""
        candidates = self.candidates
        most = candidates.max_turn(self.seconds)[candidates.node[row]]
        turn = wrap_angle(self.targets.heading[line] - placement[:, 2] - candidates.facing[row])
        turn = np.clip(turn, -most, most)
        hips, heading = candidates.turned_end(row, placement, turn)
        correction = self.targets.place[line] - hips
        size = np.maximum(np.hypot(*correction.T), 1e-9)
        correction *= np.minimum(1.0, self.correction_m / size)[:, None]
        return turn, correction, hips + correction, heading

    def _best_of(
        self, line: int, row: Int32, entry: npt.NDArray[np.int64], back: Int32, cost: Float64, node: Int32,
        placement: Float64, start: Float64, to_go: Float64,
    ) -> _Front:  # fmt: skip
        """Return the front of the best candidates `row` (n,), each for the row `entry` (n,) of the other arrays."""
        turn, correction, hips, heading = self._ends(line, row, placement[entry])
        spent = cost[entry] + TURN_COST * turn**2 + CORRECTION_COST * (correction**2).sum(axis=1)
        score = spent + self._end_cost(line, hips, heading) + WRONG_COST * to_go[node[entry]]
        best = _best(score, node[entry], self.beam)
        return _Front(
            cost=spent[best], node=node[entry[best]], hips=hips[best], heading=heading[best], back=back[entry[best]],
            row=row[best], turn=turn[best], correction=correction[best], start_state=start[entry[best]],
        )  # fmt: skip

    def _result(self, fronts: list[_Front], index: int, wrong: Bool) -> FollowedPath:
        picks = []
        for front in reversed(fronts):
            picks.append(index)
            index = int(front.back[index])
        rows = list(zip(fronts, reversed(picks), strict=True))
        row = np.array([front.row[pick] for front, pick in rows])
        node = np.array([front.node[pick] for front, pick in rows], np.int32)
        begins = np.array([front.start_state[pick] for front, pick in rows])
        last, pick = rows[-1]
        off = wrap_angle(last.heading[pick : pick + 1] - self.targets.heading[-1])
        ends = np.vstack([begins[1:], [[*last.hips[pick], off[0]]]])
        return FollowedPath(
            node=node,
            take=self.candidates.take[row],
            share=self.candidates.share[row],
            turn=np.array([front.turn[pick] for front, pick in rows]),
            correction=np.array([front.correction[pick] for front, pick in rows]),
            place=ends[:, :2],
            error=np.hypot(*(ends[:, :2] - self.targets.place[1:]).T),
            heading_error=np.abs(ends[:, 2]),
            wrong=wrong[np.arange(len(node)), node],
        )


def _best(score: Float64, node: Int32, beam: int) -> npt.NDArray[np.int64]:
    """Return the rows of the lowest scores, at most MAX_PER_NODE per node and `beam` in all, the lowest first."""
    order = np.argsort(score, kind="stable")[: 40 * beam]
    grouped = np.argsort(node[order], kind="stable")
    sorted_node = node[order][grouped]
    begins = np.flatnonzero(np.concatenate(([True], sorted_node[1:] != sorted_node[:-1])))
    place = np.arange(len(order)) - np.repeat(begins, np.diff(np.concatenate((begins, [len(order)]))))
    rank = np.empty(len(order), np.int64)
    rank[grouped] = place
    return np.asarray(order[rank < MAX_PER_NODE][:beam], np.int64)
