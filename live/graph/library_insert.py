"""Insertion of new takes into a library and its graph during a show, without a complete rebuild.

The old nodes keep their indices and the old graph is not changed, so dancers can stay in it. A show runs `insert_clips`
in a worker thread (its matrix products, kernels and copies release the GIL). It switches to the new graph at a measure
line, when every dancer has crossed it and no next measure is decided. Nodes of the old graph are then valid in the new
one. A dancer whose node is alive in the old graph but not in the new one (because another component is now the largest)
must be placed again; see `stranded`.
"""

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from live.base.arrays import Int32
from live.graph.build.transitions import Boundaries, extend_joins, reduce_joins
from live.graph.motion_graph import MotionGraph, graph_of
from live.graph.node_features import NodeFacts, node_facts
from live.graph.step_library import build_library, joined_library
from live.motion.step_clip import StepClip


def insert_clips(graph: MotionGraph, clips: Sequence[StepClip]) -> MotionGraph:
    """Return the graph with `clips` added at the end: equal to a graph built from all clips at once.

    Only the measures of `clips` are compared; everything else is reused. Nodes, clips and steps of `graph` keep their
    indices; measure lines moved by an `interval` stay, and those of `clips` are not moved. ValueError for no clips, or
    clips of another metre.
    """
    part = build_library(clips)
    library = joined_library(graph.library, part)
    boundaries = graph.boundaries.joined(Boundaries.of(part, graph.rule))
    joins = extend_joins(library, boundaries, graph.joins, graph.library.node_count, graph.rule)
    facts = facts_of(graph).joined(node_facts(part, graph.window))
    leaving = np.concatenate([graph.leaving, np.zeros(part.node_count, np.bool_)])
    return graph_of(library, boundaries, joins, facts, graph.rule, leaving)


def without_clips(graph: MotionGraph, clips: Iterable[int]) -> MotionGraph:
    """Return the same graph in which these `clips` (indices into its library's) are not begun any more.

    A dancer in one of them finishes the step and continues as before. Indices stay. ValueError if nothing is left.
    """
    leaving = graph.leaving | np.isin(graph.library.node_clip, list(clips))
    joins = reduce_joins(graph.library, graph.boundaries, graph.joins, leaving, graph.rule)
    return graph_of(graph.library, graph.boundaries, joins, facts_of(graph), graph.rule, leaving)


def facts_of(graph: MotionGraph) -> NodeFacts:
    """Return the node facts of a graph."""
    return NodeFacts(
        start=graph.node_start,
        end=graph.node_end,
        facing=graph.node_facing,
        facing_start=graph.node_facing_start,
        facing_mean=graph.node_facing_mean,
        turns=graph.node_turns,
        peak_turn_rate=graph.node_peak_turn_rate,
        warp_curve=graph.node_warp_curve,
        foot_curve=graph.node_foot_curve,
        reach_margins=graph.node_reach_margins,
        lift_shares=graph.node_lift_shares,
        moments=graph.moments,
    )


def stranded(graph: MotionGraph, nodes: Int32) -> npt.NDArray[np.bool_]:
    """Whether no edge leaves each of `nodes` (A,), so that a dancer there must begin elsewhere, (A,)."""
    return np.asarray(graph.edge_start[nodes + 1] == graph.edge_start[nodes], np.bool_)
