"""NearestSteps: what dancers dance next while the selection of steps is out of service: whatever follows and stays.

It needs the graph and where everybody ends, and nothing that plans, steers or wishes.
"""

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import joined, turn_vectors
from live.graph.takes import NO_TAKE
from live.show.dancers.dancers import Dancers
from live.show.dancers.measure_state import Danced

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

OUTSIDE = 100.0
"""A metre outside of the stage weighs as much as so many within."""


def decide_nearest(dancers: Dancers, half: npt.NDArray[np.floating]) -> Float64:
    """Decide the next measure of every dancer: of what may follow hers, what ends nearest to where it begins.

    `half` (2,) [m]: half of the stage's width and depth. Returns where everybody begins it [m], (A, 2).
    """
    hips, _, axes = dancers.present.ends_and_axes()
    edge = nearest_edges(dancers.graph, dancers.node, hips, axes, half)
    follows = edge >= 0
    coming, known = dancers.coming, np.maximum(edge, 0)
    coming.node[:] = np.where(follows, dancers.graph.edge_target[known], dancers.node)
    coming.placement[:] = np.where(follows[:, None], joined(axes, dancers.graph.edge_transform[known]), axes)
    _dance_plainly(coming)
    return hips


def repeat_measure(dancers: Dancers) -> None:
    """Decide that everybody dances her measure once more, where she has danced it."""
    dancers.coming.node[:] = dancers.present.node
    dancers.coming.placement[:] = dancers.present.placement
    _dance_plainly(dancers.coming)


def nearest_edges(
    graph: MotionGraph, node: Int32, hips: Float64, axes: Float64, half: npt.NDArray[np.floating]
) -> Int32:
    """The edge of the graph that each dancer follows, -1 where there is none, shape (A,).

    She ends `node` (A,) with her hips at `hips` (A, 2) [m], her next clip joins the `axes` (A, 3). The first of equals
    counts, so the choice is the same everywhere.
    """
    chosen = np.full(len(node), -1, np.int32)
    first, count = graph.edge_start[node], graph.edge_start[node + 1] - graph.edge_start[node]
    some = np.flatnonzero(count)
    if not len(some):
        return chosen
    whose = np.repeat(some, count[some])
    begins = np.cumsum(count[some]) - count[some]
    edge = np.arange(len(whose)) - np.repeat(begins - first[some], count[some])
    place = joined(axes[whose], graph.edge_transform[edge])
    end = place[:, :2] + turn_vectors(graph.node_end[graph.edge_target[edge]], place[:, 2])
    outside = np.maximum(np.abs(end) - half, 0.0).sum(axis=1)
    cost = np.hypot(*(end - hips[whose]).T) + OUTSIDE * outside + graph.edge_cost[edge]
    best = np.lexsort((edge, cost, whose))
    leads = np.flatnonzero(np.diff(whose[best], prepend=-1))
    chosen[whose[best[leads]]] = edge[best[leads]]
    return chosen


def _dance_plainly(coming: Danced) -> None:
    """The measure as its clip has it: nothing corrected, mixed in, varied or turned."""
    coming.correction[:] = coming.aimed[:] = 0.0
    coming.on_support[:] = 0.0
    coming.take[:], coming.take_share[:] = NO_TAKE, 0.0
    coming.amplitude[:], coming.warp[:] = 1.0, 0.0
    coming.decided = True
