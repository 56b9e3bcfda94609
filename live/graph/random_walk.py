"""Random walks through a motion graph: unplanned dances that fit the metre (T038, T120)."""

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph

Int32 = npt.NDArray[np.int32]


def random_walk(graph: MotionGraph, measures: int, *, seed: int, start: int | None = None) -> Int32:
    """Return the nodes of a random dance, (`measures`,), choosing one of the edges uniformly at every measure line.

    Nodes lie at measure ends only, so any walk keeps to the metre; in a pruned graph it never ends (T037). It begins
    at `start`, or at random where a step begins. The same seed gives the same dance. ValueError for less than one
    measure, a start that is not alive, or a dead end in an unpruned graph.
    """
    if measures < 1:
        raise ValueError(f"a walk of {measures} measures: at least 1 expected")
    chance = np.random.default_rng(seed)
    library = graph.library
    if start is None:
        begins = np.flatnonzero(graph.alive & (library.node_measure == 0))
        start = int(chance.choice(begins))
    elif not (0 <= start < library.node_count and graph.alive[start]):
        raise ValueError(f"a walk cannot begin at node {start}: no endless dance contains it")
    walk = np.empty(measures, np.int32)
    walk[0] = start
    for n in range(1, measures):
        low, high = graph.edge_start[walk[n - 1]], graph.edge_start[walk[n - 1] + 1]
        if low == high:
            raise ValueError(f"the walk ends after measure {n}: nothing follows {library.describe(int(walk[n - 1]))}")
        walk[n] = graph.edge_target[chance.integers(low, high)]
    return walk
