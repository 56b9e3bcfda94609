"""Insertion: a new take joins a library and its graph while they are danced, without building everything anew.

The old nodes keep their indices, and nothing that the old graph holds is changed, so dancers go on in it as long as it
takes. A show lets `insert_clips` run in a worker thread (its matrix products, kernels and copies leave the interpreter
to the main thread), and takes up the new graph at a measure line, when every dancer has crossed it and nobody's next
measure is decided: from then on nodes of the old graph are looked up in the new one. A dancer whose node is alive in
the old graph but not in the new one (a larger component has come into being elsewhere) has to be placed anew; see
`stranded`.
"""

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from live.graph.build.transitions import Boundaries, joins_with
from live.graph.motion_graph import MotionGraph, graph_of
from live.graph.node_features import NodeFacts, node_facts
from live.graph.step_library import build_library, joined_library
from live.motion.step_clip import StepClip

Int32 = npt.NDArray[np.int32]


def insert_clips(graph: MotionGraph, clips: Sequence[StepClip]) -> MotionGraph:
    """The graph of the library with `clips` after all others: equal to a graph of all of them built from nothing.

    The measures of `clips` are compared with everything, everything else is taken over. Nodes, clips and steps of
    `graph` keep their indices in the new graph; measure lines that an `interval` has moved stay where they are, and
    those of `clips` are not moved. ValueError for no clips, or clips of another metre.
    """
    part = build_library(clips)
    library = joined_library(graph.library, part)
    boundaries = graph.boundaries.joined(Boundaries.of(part, graph.rule))
    joins = joins_with(library, boundaries, graph.joins, graph.library.node_count, graph.rule)
    facts = facts_of(graph).joined(node_facts(part, graph.window))
    leaving = np.concatenate([graph.leaving, np.zeros(part.node_count, np.bool_)])
    return graph_of(library, boundaries, joins, facts, graph.rule, leaving)


def without_clips(graph: MotionGraph, clips: Iterable[int]) -> MotionGraph:
    """The same graph, but that nobody begins these `clips` (indices into its library's) any more.

    Whoever dances in one finishes her step and goes on as before. Indices stay. ValueError if nothing is left.
    """
    leaving = graph.leaving | np.isin(graph.library.node_clip, list(clips))
    return graph_of(graph.library, graph.boundaries, graph.joins, facts_of(graph), graph.rule, leaving)


def facts_of(graph: MotionGraph) -> NodeFacts:
    """What a graph knows of its nodes."""
    return NodeFacts(
        start=graph.node_start,
        end=graph.node_end,
        facing=graph.node_facing,
        facing_start=graph.node_facing_start,
        facing_mean=graph.node_facing_mean,
        turns=graph.node_turns,
        quickest=graph.node_quickest,
        rise=graph.node_rise,
        gives=graph.node_gives,
        holds=graph.node_holds,
        moments=graph.moments,
    )


def stranded(graph: MotionGraph, nodes: Int32) -> npt.NDArray[np.bool_]:
    """Whether nothing leads on from each of `nodes` (A,), so that whoever dances there must begin elsewhere, (A,)."""
    return np.asarray(graph.edge_start[nodes + 1] == graph.edge_start[nodes], np.bool_)
