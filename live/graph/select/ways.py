"""Ways: how far one measure of each step can go in each direction, so that nobody is asked for more (T068, T075)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import Candidates
from live.graph.select.placing import turn_vectors, wrapped

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

DIRECTIONS: Final = 32
"""Directions that are tabled, evenly over the circle."""
TURNS: Final = np.radians(np.linspace(-90.0, 90.0, 9))
"""Changes of heading over the measure that are tabled [rad]."""
NORMALS: Final = 72
"""Half planes whose meet is taken for a convex hull."""


@dataclass(frozen=True, slots=True, eq=False)
class Ways:
    """The farthest ends of C steps, seen by the dancer who begins: 0 is straight ahead, then towards her left."""

    farthest: Float64
    """[m], shape (C + 1, TURNS, DIRECTIONS); the last row is that of any step."""

    @staticmethod
    def of(graph: MotionGraph, candidates: Candidates) -> "Ways":
        """Measure all candidates of all steps, each turned so that the heading changes by each of TURNS."""
        step = graph.library.node_step[candidates.node]
        count = len(graph.library.steps)
        farthest = np.zeros((count + 1, len(TURNS), DIRECTIONS))
        alive = graph.alive[candidates.node]
        node = candidates.node
        heading = np.arange(DIRECTIONS) * (2.0 * np.pi / DIRECTIONS)
        towards = np.array([np.sin(heading), np.cos(heading)])
        for n, change in enumerate(TURNS):
            own = wrapped(candidates.facing - graph.node_facing_start[node])
            turn = wrapped(change - own)
            moved = candidates.turns.take(node).displacement(1.0, turn)
            way = moved + turn_vectors(candidates.end, turn) - graph.node_start[node]
            way = turn_vectors(way, -graph.node_facing_start[node])
            for s in range(count):
                rows = (step == s) & alive
                if rows.any():
                    farthest[s, n] = _along(way[rows], towards)
        farthest[-1] = farthest[:-1].max(axis=0)
        return Ways(farthest)

    def limit(
        self, step: Int32, heading: Float64, change: Float64, way: Float64, more: Float64, least: Float64 | float = 0.0
    ) -> Float64:
        """Of the `way` (A, 2) [m] of each dancer as much as her `step` (A,) can go in one measure and `more` (A,)
        [m], or as much as `least` (A,) [m].

        `heading` (A,) [rad] is where she faces at its beginning, `change` (A,) how far she is to turn until its end;
        a step below 0 is any.
        """
        length = np.hypot(*way.T)
        at = (np.arctan2(way[:, 0], way[:, 1]) - heading) * (DIRECTIONS / (2.0 * np.pi)) % DIRECTIONS
        first = np.floor(at).astype(np.int64)
        t = at - first
        turn = np.abs(np.clip(wrapped(change), TURNS[0], TURNS[-1])[:, None] - TURNS).argmin(axis=1)
        row = np.where(step < 0, len(self.farthest) - 1, step)
        reach = (1.0 - t) * self.farthest[row, turn, first % DIRECTIONS] + t * self.farthest[
            row, turn, (first + 1) % DIRECTIONS
        ]
        far = np.maximum(reach + more, least)
        return np.asarray(way * np.minimum(1.0, far / np.maximum(length, 1e-9))[:, None])


def _along(way: Float64, towards: Float64) -> Float64:
    """How far the convex hull of nowhere and the ends `way` (n, 2) goes in the directions `towards` (2, d), (d,) [m].

    Mixtures lie in the hull and, of a step in nine directions, fill it (T131). It is the meet of its half planes, of
    which NORMALS are taken: by a thousandth too large.
    """
    angle = np.arange(NORMALS) * (2.0 * np.pi / NORMALS)
    normal = np.array([np.sin(angle), np.cos(angle)])
    support = (way @ normal).max(axis=0, initial=0.0)
    facing = towards.T @ normal
    return np.asarray(np.where(facing > 1e-9, support / np.maximum(facing, 1e-9), np.inf).min(axis=1))
