"""Wrong steps: which nodes are not the wanted step in which measure, and how many such measures are still to come."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

ANY: Final = -1
"""A measure in which any step is right."""


def wrong_steps(graph: MotionGraph, count: int, wanted: npt.ArrayLike | None, fits: Bool | None) -> Bool:
    """Whether each node would be another step than the wanted one in each of `count` measures, shape (M, N).

    `wanted` (M,) steps by index or `ANY`, `fits` (M, N) which nodes may be danced; ValueError for other shapes.
    """
    library = graph.library
    shape = (count, library.node_count)
    wrong = np.zeros(shape, np.bool_)
    if wanted is not None:
        values = np.asarray(wanted, np.int64)
        if values.shape != (count,):
            raise ValueError(f"wanted steps of shape {values.shape}, ({count},) expected")
        wrong |= (values[:, None] != ANY) & (library.node_step[None] != values[:, None])
    if fits is not None:
        if fits.shape != shape:
            raise ValueError(f"fits of shape {fits.shape}, {shape} expected")
        wrong |= ~fits
    return wrong


def cost_to_go(graph: MotionGraph, wrong: Bool) -> Float64:
    """The fewest wrong measures, (M, N), after node v is danced in measure n, backwards over all edges; exact."""
    filled = np.flatnonzero(np.diff(graph.edge_start) > 0)
    starts = graph.edge_start[filled]
    left = np.full(wrong.shape, np.inf)
    left[-1] = 0.0
    for n in range(len(wrong) - 2, -1, -1):
        after = left[n + 1] + wrong[n + 1]
        left[n, filled] = np.minimum.reduceat(after[graph.edge_target], starts)
    return left
