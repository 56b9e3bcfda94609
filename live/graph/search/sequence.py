"""Sequences: a list of wanted steps becomes a path through the motion graph, exactly on the measures (T063-T066)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.search.depth_first_reference import BUDGET, depth_first
from live.graph.search.sequence_spec import Specification
from live.graph.search.viterbi import CostToGo, Edges, cheapest

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

Method = Literal["layered", "depth first"]


class NoPath(ValueError):
    """There is no dance of so many measures at all, not even with other steps."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundPath:
    """A dance of M measures, and how far it is from what was wanted."""

    node: Int32
    """Shape (M,)."""
    wrong: Bool
    """Measures that are not as wanted, shape (M,)."""
    edge_cost: Float64
    """Distance of the poses where each measure begins [m] (K002), 0 for a first measure, shape (M,)."""

    @property
    def cost(self) -> int:
        """How many measures are not as wanted (T063)."""
        return int(self.wrong.sum())

    @property
    def roughness(self) -> float:
        """Sum of the edge costs [m]: of dances of one cost the one with the least is found."""
        return float(self.edge_cost.sum())


def find_sequence(
    graph: MotionGraph,
    specification: Specification,
    *,
    start: int | None = None,
    method: Method = "layered",
    budget: int = BUDGET,
) -> FoundPath:
    """The dance with the fewest wrong measures (T063), of those the smoothest.

    `start` is the node danced before the first measure; without it the dance begins with any step. Method "depth first"
    is the thesis' search (T064): the first dance without a wrong measure, not the smoothest; it raises SearchTooLong
    after `budget` nodes, and where there is none the layered search finds the nearest (T065). NoPath if there is no
    dance of so many measures.
    """
    edges = edges_of(graph)
    node = depth_first(edges, specification, start=start, budget=budget) if method == "depth first" else None
    if node is None and method == "layered":
        node = cheapest(CostToGo(edges, specification, wrong=False), start)
    if node is None:
        node = cheapest(CostToGo(edges, specification, wrong=True), start)
    if node is None:
        raise NoPath(f"no steps that follow each other fill {specification.measures} measures")
    return _measured(edges, specification, node, start)


def best_start(graph: MotionGraph, specification: Specification, nodes: npt.ArrayLike) -> int:
    """The one of some nodes after which the dance has the fewest wrong measures, of those the smoothest.

    One search for all of them; the first node if no dance follows any.
    """
    edges = edges_of(graph)
    value = CostToGo(edges, specification, wrong=True).layer(0)
    after = np.full(len(value), np.inf)
    np.minimum.at(after, np.repeat(np.arange(len(value)), np.diff(edges.start)), edges.cost + value[edges.target])
    choice = np.asarray(nodes)
    return int(choice[np.argmin(after[choice])])


def edges_of(graph: MotionGraph) -> Edges:
    """The graph's edges as the searches read them."""
    return Edges(graph.edge_start, graph.edge_target, graph.edge_cost)


def _measured(edges: Edges, specification: Specification, node: Int32, start: int | None) -> FoundPath:
    wrong = ~specification.fits[specification.kind, node]
    cost = np.zeros(len(node))
    before = -1 if start is None else start
    for measure, after in enumerate(node.tolist()):
        if before >= 0:
            row = slice(edges.start[before], edges.start[before + 1])
            cost[measure] = edges.cost[row][edges.target[row] == after].min()
        before = after
    return FoundPath(node, np.asarray(wrong), cost)
