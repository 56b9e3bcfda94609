"""Fallback step selection: the measure that may follow and stays nearest to the dancer's place.

It depends only on the graph and on the ends of the present measures, not on planning or steering.
"""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64, Int32
from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import following_placement, turn_vectors
from live.graph.takes import NO_TAKE
from live.show.dancers.measure_state import MeasureState

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers


OUTSIDE = 100.0
"""Weight of a metre outside of the stage, relative to a metre on it."""


def decide_nearest(dancers: "Dancers", half: npt.NDArray[np.floating]) -> Float64:
    """Decide the next measure of each dancer: of those that may follow, the one that ends nearest to its beginning.

    `half` (2,) [m]: half of the stage's width and depth. Returns the dancers' positions at its beginning [m], (A, 2).
    """
    hips, _, axes = dancers.present.ends_and_axes()
    edge = nearest_edges(dancers.graph, dancers.node, hips, axes, half)
    follows = edge >= 0
    coming, known = dancers.coming, np.maximum(edge, 0)
    coming.node[:] = np.where(follows, dancers.graph.edge_target[known], dancers.node)
    coming.placement[:] = np.where(
        follows[:, None], following_placement(axes, dancers.graph.edge_transform[known]), axes
    )
    _set_plain(coming)
    return hips


def repeat_measure(dancers: "Dancers") -> None:
    """Decide that all dancers repeat their present measure at the same placement."""
    dancers.coming.node[:] = dancers.present.node
    dancers.coming.placement[:] = dancers.present.placement
    _set_plain(dancers.coming)


def nearest_edges(
    graph: MotionGraph, node: Int32, hips: Float64, axes: Float64, half: npt.NDArray[np.floating]
) -> Int32:
    """Return the edge of the graph for each dancer, -1 where there is none, shape (A,).

    The dancers end `node` (A,) with hips at `hips` (A, 2) [m]; the next clip joins at `axes` (A, 3). Of equal edges the
    first is chosen, so that the choice is deterministic.
    """
    chosen = np.full(len(node), -1, np.int32)
    first, count = graph.edge_start[node], graph.edge_start[node + 1] - graph.edge_start[node]
    some = np.flatnonzero(count)
    if not len(some):
        return chosen
    whose = np.repeat(some, count[some])
    begins = np.cumsum(count[some]) - count[some]
    edge = np.arange(len(whose)) - np.repeat(begins - first[some], count[some])
    place = following_placement(axes[whose], graph.edge_transform[edge])
    end = place[:, :2] + turn_vectors(graph.node_end[graph.edge_target[edge]], place[:, 2])
    outside = np.maximum(np.abs(end) - half, 0.0).sum(axis=1)
    cost = np.hypot(*(end - hips[whose]).T) + OUTSIDE * outside + graph.edge_cost[edge]
    best = np.lexsort((edge, cost, whose))
    leads = np.flatnonzero(np.diff(whose[best], prepend=-1))
    chosen[whose[best[leads]]] = edge[best[leads]]
    return chosen


def _set_plain(coming: MeasureState) -> None:
    """Set a measure to its plain clip: no correction, mixed take, variation or turn."""
    coming.clear_correction()
    coming.on_support[:] = 0.0
    coming.take[:], coming.take_share[:] = NO_TAKE, 0.0
    coming.amplitude[:], coming.warp[:] = 1.0, 0.0
    coming.decided = True
