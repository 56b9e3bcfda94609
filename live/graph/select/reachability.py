"""Reachability: how far a measure of each step can go in each direction, and missing directions (T068, T075)."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64, Int32
from live.graph.select.candidates import Candidates, turn_vectors, wrap_angle
from live.graph.takes import NO_TAKE

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph


TABLED_DIRECTIONS: Final = 32
"""Directions in the table, evenly over the circle."""
TURNS: Final = np.radians(np.linspace(-90.0, 90.0, 9))
"""Changes of heading over the measure in the table [rad]."""
HALF_PLANES: Final = 72
"""Half planes whose intersection approximates a convex hull."""


@dataclass(frozen=True, slots=True, eq=False)
class ReachTable:
    """The farthest ends of C steps relative to the dancer at the beginning: direction 0 is ahead, then to the left."""

    farthest: Float64
    """[m], shape (C + 1, TURNS, DIRECTIONS); the last row is for any step."""

    @staticmethod
    def of(graph: "MotionGraph", candidates: Candidates) -> "ReachTable":
        """Measure all candidates of all steps, each turned so that the heading changes by each of TURNS."""
        step = graph.library.node_step[candidates.node]
        count = len(graph.library.steps)
        farthest = np.zeros((count + 1, len(TURNS), TABLED_DIRECTIONS))
        alive = graph.alive[candidates.node]
        node = candidates.node
        heading = np.arange(TABLED_DIRECTIONS) * (2.0 * np.pi / TABLED_DIRECTIONS)
        towards = np.array([np.sin(heading), np.cos(heading)])
        for n, change in enumerate(TURNS):
            own = wrap_angle(candidates.facing - graph.node_facing_start[node])
            turn = wrap_angle(change - own)
            moved = candidates.turns.select(node).displacement(1.0, turn)
            way = moved + turn_vectors(candidates.end, turn) - graph.node_start[node]
            way = turn_vectors(way, -graph.node_facing_start[node])
            for s in range(count):
                rows = (step == s) & alive
                if rows.any():
                    farthest[s, n] = _hull_extent(way[rows], towards)
        farthest[-1] = farthest[:-1].max(axis=0)
        return ReachTable(farthest)

    def limit_travel(
        self,
        step: Int32,
        heading: Float64,
        change: Float64,
        travel: Float64,
        margin: Float64,
        least: Float64 | float = 0.0,
    ) -> Float64:
        """Shorten each `travel` (A, 2) [m] to what `step` (A,) can travel in one measure plus `margin` (A,) [m].

        At least `least` (A,) [m] remains possible. `heading` (A,) [rad] is the heading at the beginning of the measure,
        `change` (A,) the wanted change until its end; a step below 0 means any.
        """
        length = np.hypot(*travel.T)
        at = (
            (np.arctan2(travel[:, 0], travel[:, 1]) - heading) * (TABLED_DIRECTIONS / (2.0 * np.pi)) % TABLED_DIRECTIONS
        )
        first = np.floor(at).astype(np.int64)
        t = at - first
        turn = np.abs(np.clip(wrap_angle(change), TURNS[0], TURNS[-1])[:, None] - TURNS).argmin(axis=1)
        row = np.where(step < 0, len(self.farthest) - 1, step)
        reach = (1.0 - t) * self.farthest[row, turn, first % TABLED_DIRECTIONS] + t * self.farthest[
            row, turn, (first + 1) % TABLED_DIRECTIONS
        ]
        far = np.maximum(reach + margin, least)
        return np.asarray(travel * np.minimum(1.0, far / np.maximum(length, 1e-9))[:, None])


PACES: Final = np.arange(1, 31) * 0.1
"""Distances [m per measure] that are tried as the pace of a step."""
PACE_DIRECTIONS: Final = 16
PACE_NODES: Final = 64
"""Measures from which they are tried, evenly chosen."""
PACE_MISS: Final = 0.15
"""Mean distance [m] by which a dancer may miss at the pace."""
PACE_MARGIN: Final = 0.7
"""Part of the correction that may be needed for it; the rest is kept for avoiding others."""


def paces(graph: "MotionGraph", correction: float) -> Float64:
    """Return how far a measure of each step follows an agent in any direction [m], (C + 1,).

    It is the largest distance at which the best following measure, with part of a correction of at most `correction`
    [m], misses by no more than PACE_MISS, on average over directions and the measures danced before. The farthest
    measure of a library says nothing about that: it may be the only one. The last entry is for any step.
    """
    library = graph.library
    ways = turn_vectors(library.node_travel, -graph.node_facing_start)
    give = PACE_MARGIN * np.minimum(graph.node_reach_margin, correction)
    angle = np.arange(PACE_DIRECTIONS) * (2.0 * np.pi / PACE_DIRECTIONS)
    goals = PACES[:, None, None] * np.stack([np.sin(angle), np.cos(angle)], axis=1)[None]
    before = _spread(np.flatnonzero(graph.edge_start[1:] > graph.edge_start[:-1]), PACE_NODES).tolist()
    after = [graph.edge_target[graph.edge_start[node] : graph.edge_start[node + 1]] for node in before]
    choices = [
        [_spread(some, PACE_NODES) for each in after if len(some := each[library.node_step[each] == s])]
        for s in range(len(library.steps))
    ]
    choices.append([_spread(each, PACE_NODES) for each in after])
    used = np.unique(np.concatenate([np.zeros(0, np.int64), *(some for step in choices for some in step)]))
    off = np.hypot(*np.moveaxis(goals[:, :, None] - ways[used], -1, 0)) - give[used]
    off = np.maximum(off, 0.0)  # (distances, directions, nodes)
    found = np.zeros(len(choices))
    for s, step in enumerate(choices):
        if step:
            miss = np.mean([off[:, :, np.searchsorted(used, some)].min(axis=2).mean(axis=1) for some in step], axis=0)
            good = np.flatnonzero(miss <= max(PACE_MISS, 1.1 * float(miss.min())))
            found[s] = PACES[good[-1]]
    return found


def _spread(values: npt.NDArray[np.integer], most: int) -> npt.NDArray[np.integer]:
    """Return at most `most` of `values` (n,), evenly chosen."""
    return values if len(values) <= most else values[np.linspace(0, len(values) - 1, most).astype(np.int64)]


def _hull_extent(way: Float64, towards: Float64) -> Float64:
    """Return the extent of the convex hull of the origin and the ends `way` (n, 2) along `towards` (2, d), (d,) [m].

    Mixtures lie in the hull and fill it for a step in nine directions (T131). It is the intersection of its half
    planes, of which HALF_PLANES are used; the result is too large by a thousandth at most.
    """
    angle = np.arange(HALF_PLANES) * (2.0 * np.pi / HALF_PLANES)
    normal = np.array([np.sin(angle), np.cos(angle)])
    support = (way @ normal).max(axis=0, initial=0.0)
    facing = towards.T @ normal
    return np.asarray(np.where(facing > 1e-9, support / np.maximum(facing, 1e-9), np.inf).min(axis=1))


DIRECTION_NAMES: Final = (
    "forward",
    "forward and to the left",
    "to the left",
    "back and to the left",
    "back",
    "back and to the right",
    "to the right",
    "forward and to the right",
)
"""Eight directions relative to the dancer, 45 degrees apart, counted towards the left."""
ARC: Final = np.pi / 4
TURN_SAMPLES: Final = 33
"""Angles at which turned measures are sampled, between the largest turns to both sides."""
MAX_TURN: Final = np.pi / 2
"""A larger turn [rad] in one measure is a spin and does not travel."""
MIN_RELATIVE_REACH: Final = 0.3
"""A direction is missing if its reach is less than this share of the farthest direction's..."""
MIN_REACH: Final = 0.15
"""... or less than this [m] (steps with less reach are danced in place)."""


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """Displacements of one measure of a step, relative to the dancer at its beginning: x left, z ahead [m]."""

    step: str
    clips: Float64
    """Displacements of the clips themselves, shape (n, 2)."""
    mixed: Float64
    """Displacements of their mixtures (T069), shape (m, 2)."""
    turned: Float64
    """Displacements of all of these with a turn inserted (T070), at TURNED angles each, shape (n + m, TURNED, 2)."""
    farthest: Float64
    """Reach in each of the eight DIRECTIONS, turns included [m], shape (8,)."""
    straight: Float64
    """The same without turns, [m], shape (8,)."""

    @property
    def max_travel(self) -> float:
        """The longest displacement of one measure without a turn [m]: the speed limit of the step along a path."""
        return float(self.straight.max())

    @property
    def missing(self) -> tuple[str, ...]:
        """Directions with little or no reach without a turn: what to record (T075)."""
        bar = max(MIN_REACH, MIN_RELATIVE_REACH * float(self.straight.max()))
        return tuple(name for name, way in zip(DIRECTION_NAMES, self.straight, strict=True) if way < bar)


def reach_of(graph: "MotionGraph", candidates: Candidates, step: int, seconds: float) -> Reach:
    """Return the reach of a measure of `seconds` of `step` (an index). ValueError if the graph has none of it."""
    rows = np.flatnonzero(graph.library.node_step[candidates.node] == step).astype(np.int32)
    if not len(rows):
        raise ValueError(f"no measure of step {step} in the graph")
    node = candidates.node[rows]
    straight = turned_displacements(graph, candidates, rows, np.zeros(len(rows)))
    most = np.minimum(candidates.max_turn(seconds)[node], MAX_TURN)
    angles = most[:, None] * np.linspace(-1.0, 1.0, TURN_SAMPLES)
    turned = turned_displacements(graph, candidates, np.repeat(rows, TURN_SAMPLES), angles.reshape(-1)).reshape(
        len(rows), TURN_SAMPLES, 2
    )
    own = candidates.take[rows] == NO_TAKE
    return Reach(
        step=graph.library.steps[step],
        clips=straight[own],
        mixed=straight[~own],
        turned=turned,
        farthest=_by_direction(np.concatenate([straight, turned.reshape(-1, 2)])),
        straight=_by_direction(straight),
    )


def turned_displacements(graph: "MotionGraph", candidates: Candidates, rows: Int32, angle: Float64) -> Float64:
    """Return displacements (n, 2) of candidates `rows` (n,) turned by `angle` (n,) [rad], relative to the dancer."""
    node = candidates.node[rows]
    moved = candidates.turns.select(node).displacement(1.0, angle)
    end = moved + turn_vectors(candidates.end[rows], angle)
    return turn_vectors(end - graph.node_start[node], -graph.node_facing_start[node])


def direction_of(way: Float64) -> str:
    """Return the name of the direction of `way` (2,), relative to the dancer."""
    return DIRECTION_NAMES[round(float(np.arctan2(way[0], way[1])) / ARC) % len(DIRECTION_NAMES)]


def _by_direction(ways: Float64) -> Float64:
    """Return the length of the longest of `ways` (n, 2) within half an arc of each direction, (8,)."""
    heading, length = np.arctan2(ways[:, 0], ways[:, 1]), np.hypot(*ways.T)
    farthest = np.zeros(len(DIRECTION_NAMES))
    for n in range(len(DIRECTION_NAMES)):
        inside = np.abs(wrap_angle(heading - n * ARC)) <= 0.5 * ARC + 1e-9
        farthest[n] = length[inside].max(initial=0.0)
    return farthest
