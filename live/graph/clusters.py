"""Summary of a motion graph for people: clusters, components, connectivity, and which steps can follow a step.

A cluster is a step with all its instances (T041, Fig 3.4). A component is a structural variation of it: the clips that
begin on one foot and in one pose, and end in one pose (T062, Fig 3.11). Step successors: T003, T043.
"""

from dataclasses import dataclass

import numpy as np

from live.base.arrays import Bool, Float64, Int32
from live.graph.build.components import largest_component, strong_components
from live.graph.build.metric import FlatClouds
from live.graph.build.transitions import Boundaries, JoinSettings, find_joins
from live.graph.motion_graph import MotionGraph
from live.graph.step_library import StepLibrary
from live.graph.structure_rules import initial_side, may_follow_between, plain_pose

_BLOCK = 256


@dataclass(frozen=True, slots=True)
class Component:
    """A structural variation of a step."""

    step: int
    side: str
    """The leading foot; if that is not given, whether the clip is as danced or mirrored."""
    begin_pose: str
    end_pose: str
    nodes: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class JoinSummary:
    """Joins from the variations of one group (a step, a component) to those of another."""

    source: int
    target: int
    join_count: int
    nearest: float
    """Distance of the nearest join [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Connectivity:
    """Connectivity of the N nodes, dead ends included."""

    label: Int32
    """Strongly connected component of each node, shape (N,)."""
    alive: Bool
    """Whether a node is in the largest component that allows an endless dance, shape (N,)."""
    has_successor: Bool
    """Whether any node can follow it, shape (N,)."""
    has_predecessor: Bool
    """Whether it can follow any node, shape (N,)."""


def structural_components(library: StepLibrary) -> list[Component]:
    """Return the components of a library, step by step, each with its nodes."""
    found: dict[tuple[int, str, str, str], list[int]] = {}
    for node in range(library.node_count):
        clip = library.clips[library.node_clip[node]]
        key = (int(library.node_step[node]), initial_side(clip), plain_pose(clip.begin_pose), plain_pose(clip.end_pose))
        found.setdefault(key, []).append(node)
    return [Component(*key, tuple(nodes)) for key, nodes in sorted(found.items(), key=lambda one: one[0][0])]


def join_summaries(graph: MotionGraph, group: Int32, count: int) -> list[JoinSummary]:
    """Return the joins between groups of nodes, where one step ends and another begins; `group` (N,) below `count`.

    Joins of pruned nodes are included.
    """
    joins = graph.joins
    between = graph.library.node_measure[joins.target] == 0
    pair = group[joins.source[between]].astype(np.int64) * count + group[joins.target[between]]
    nearest = np.full(count * count, np.inf)
    np.minimum.at(nearest, pair, joins.cost[between])
    number = np.bincount(pair, minlength=count * count)
    return [
        JoinSummary(int(p) // count, int(p) % count, int(number[p]), float(nearest[p])) for p in np.flatnonzero(number)
    ]


def connectivity(graph: MotionGraph) -> Connectivity:
    """Return strongly connected components and dead ends over all joins, pruned or not."""
    source, target, count = graph.joins.source, graph.joins.target, graph.library.node_count
    alive = largest_component(count, source, target) if len(source) else np.zeros(count, np.bool_)
    if not (alive[source] & alive[target]).any():
        alive = np.zeros(count, np.bool_)
    return Connectivity(
        label=strong_components(count, source, target),
        alive=alive,
        has_successor=np.bincount(source, minlength=count) > 0,
        has_predecessor=np.bincount(target, minlength=count) > 0,
    )


def nearest_steps(graph: MotionGraph) -> Float64:
    """Return the distance [m] of the nearest end of each step to the nearest beginning of each other, shape (C, C).

    Only pairs with matching structure count; inf if there is none. Computed in blocks: no array of size N × N.
    """
    library = graph.library
    leaves = np.flatnonzero(library.node_measure == library.node_measures - 1)
    enters = np.flatnonzero(library.node_measure == 0)
    starts = graph.boundaries.starts.select(enters)
    nearest = np.full((len(library.steps), len(library.steps)), np.inf)
    for begin in range(0, len(leaves), _BLOCK):
        rows = leaves[begin : begin + _BLOCK]
        squared = _squared(graph.boundaries.ends.select(rows), starts)
        squared[~may_follow_between(library, rows, enters)] = np.inf
        for step in np.unique(library.node_step[rows]):
            best = squared[library.node_step[rows] == step].min(axis=0)
            np.minimum.at(nearest[step], library.node_step[enters], best)
    return np.asarray(np.sqrt(np.maximum(nearest, 0.0)))


def _squared(a: FlatClouds, b: FlatClouds) -> Float64:
    """Return K003 for all pairs, (N, M) [m²]."""
    product = np.abs(a.floor.conj() @ b.floor.T) + a.height @ b.height.T
    return np.asarray(a.size[:, None] + b.size[None] - 2.0 * product)


@dataclass(frozen=True, slots=True)
class Successor:
    """A step that can come next."""

    step: str
    distance_m: float
    """Distance of the nearest pair of measures [m] (T034)."""
    pairs: int
    """Joins between variations of the two steps, as many as a graph keeps."""


def successors(library: StepLibrary, step: int, *, window: float = 0.1875, threshold: float = 0.16) -> list[Successor]:
    """Return the steps that can follow the step of that index within `threshold` [m], the nearest first."""
    rule = JoinSettings(window, threshold)
    joins = find_joins(library, Boundaries.of(library, rule), rule)
    own = (library.node_step[joins.source] == step) & (library.node_measure[joins.target] == 0)
    follows, cost = library.node_step[joins.target[own]], joins.cost[own]
    found = []
    for index, name in enumerate(library.steps):
        distances = cost[follows == index]
        if len(distances):
            found.append(Successor(name, float(distances.min()), len(distances)))
    return sorted(found, key=lambda follower: (follower.distance_m, follower.step))
