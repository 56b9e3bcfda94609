"""Motion graph: nodes only at measure ends, edges between compatible measures, dead ends pruned (T031-T042)."""

from dataclasses import dataclass

import numpy as np

from live.base.arrays import Bool, Float64, Int32
from live.graph.build.components import largest_component
from live.graph.build.metric import Metric
from live.graph.build.nearest_pairs import EdgeLimits
from live.graph.build.transitions import Boundaries, Joins, JoinSettings, find_joins, retime_library
from live.graph.distance_kernels import count_hops, reverse_edges
from live.graph.node_features import Moments, NodeFacts, node_facts
from live.graph.step_library import StepLibrary
from live.graph.structure_rules import UNREACHABLE, unmatched_poses
from live.graph.takes import Takes, find_takes


@dataclass(frozen=True, slots=True, eq=False)
class MotionGraph:
    """N nodes (measures of the library) and E edges as compressed rows (C steps)."""

    library: StepLibrary
    edge_start: Int32
    """Edges of node u are edge_start[u] to edge_start[u + 1], shape (N + 1,)."""
    edge_target: Int32
    edge_cost: Float64
    """Distance of the aligned clouds [m], shape (E,); 0 within a step."""
    edge_transform: Float64
    """x, z [m], yaw [rad] that place the next clip in the axes of the last (K001), shape (E, 3)."""
    hops: Int32
    """Measures from a node to the first measure of a step; 0: it is in it, UNREACHABLE if there is none, shape (C,
    N)."""
    node_end: Float64
    """Hips at the end of each measure, in its clip's axes (x, z) [m], shape (N, 2)."""
    node_facing: Float64
    """Heading of the body at the end of each measure, in its clip's axes [rad], shape (N,)."""
    node_facing_start: Float64
    """The same at its beginning, shape (N,)."""
    node_facing_mean: Float64
    """Mean heading over the whole measure, a circular mean (T122), shape (N,)."""
    node_start: Float64
    """Hips at the beginning of each measure, in its clip's axes (x, z) [m], shape (N, 2)."""
    node_turns: Float64
    """Where in each measure a dancer can turn on a supporting foot, shape (N, 8, 8): per segment start, stop, weight,
        x, z [m] of the foot at both ends, softness (T048-T050)."""
    node_peak_turn_rate: Float64
    """Peak speed of a turn, in whole angles per measure, shape (N,)."""
    node_warp_curve: Float64
    """When in each measure the hips take a correction: share and rate at its knots (`footstep_plan`), (N, 65, 2)."""
    node_foot_curve: Float64
    """When the left and the right foot take their part of it, shape (N, 2, 65, 5)."""
    node_reach_margins: Float64
    """How far a dancer can be displaced beyond each measure's own path [m] with planted feet, in 16 directions about
        clip's axes, shape (N, 16)."""
    node_lift_shares: Float64
    """Share of a correction that is applied before the left and the right foot are first lifted, (N, 2)."""
    moments: Moments
    """Poses and speeds of every measure at each quarter of a beat."""
    takes: Takes
    """The other takes of each node's measure (T044-T047)."""
    alive: Bool
    """Whether a node is in the largest strongly connected component, shape (N,)."""
    window: float
    """Length of a transition as a share of the measure."""
    missing: tuple[str, ...]
    """Steps that cannot be both entered and left, as texts."""
    joins: Joins
    """The pairs that may follow each other and are kept, those of pruned nodes included; used when the graph grows."""
    boundaries: Boundaries
    """The point clouds at both ends of each measure, kept for the same purpose."""
    rule: JoinSettings
    """The settings that the joins were made with."""
    leaving: Bool
    """Measures of removed clips: a dancer there finishes the step, but none begins it, shape (N,)."""

    @property
    def edge_count(self) -> int:
        """Number of edges E."""
        return len(self.edge_target)

    @property
    def node_reach_margin(self) -> Float64:
        """Mean of `reach_margins` over all directions [m], shape (N,)."""
        return np.asarray(self.node_reach_margins.mean(axis=1))

    def entries(self, step: int) -> Int32:
        """Return the alive nodes that begin the step."""
        library = self.library
        chosen = (library.node_step == step) & (library.node_measure == 0) & self.alive
        return np.flatnonzero(chosen).astype(np.int32)


def build_graph(
    library: StepLibrary,
    *,
    window: float = 0.1875,
    threshold: float = 0.16,
    metric: Metric | None = None,
    prune: bool = True,
    interval: float = 0.0,
    limits: EdgeLimits | None = None,
) -> MotionGraph:
    """Connect the measures of a library.

    `window`: length of a transition as a share of the measure (T036); `threshold` [m]: largest distance (T034) of an
    edge; `metric`: weights of the joints and along the window. Within a step of several measures, each leads only to
    the next, without cost (T039). Named poses in which steps begin and end must agree (T136), and a step that transfers
    the weight is repeated on the other side (T135). Dead ends are pruned (T037); with `prune` False they stay, for
    searches that fix the end of a dance (T064). `interval`: share of a measure by which steps may end and begin off its
    line (T140); the graph's library has the moved lines. `limits`: how many of each node's edges are kept, the nearest.
    ValueError if no two measures connect, unless nothing is pruned.
    """
    rule = JoinSettings(
        window, threshold, Metric.of() if metric is None else metric, EdgeLimits() if limits is None else limits, prune
    )
    library = retime_library(library, rule, interval)
    boundaries = Boundaries.of(library, rule)
    joins = find_joins(library, boundaries, rule)
    return graph_of(library, boundaries, joins, node_facts(library, window), rule)


def graph_of(
    library: StepLibrary,
    boundaries: Boundaries,
    joins: Joins,
    facts: NodeFacts,
    rule: JoinSettings,
    leaving: Bool | None = None,
) -> MotionGraph:
    """Build the graph of a library from known joins and facts; ValueError if it is pruned and nothing connects.

    `leaving` (N,): measures that must not be begun, see `MotionGraph`.
    """
    alive = ~library.unjoined
    leaving = np.zeros(library.node_count, np.bool_) if leaving is None else leaving
    open_ = joins
    if leaving.any():  # a dancer in a removed clip may finish it, but nobody else gets into it
        same = library.node_clip[joins.target] == library.node_clip[joins.source]
        open_ = joins.select(~leaving[joins.target] | (same & (library.node_measure[joins.target] > 0)))
    if rule.prune:
        alive = largest_component(library.node_count, open_.source, open_.target)
    edges = joins.among(alive)
    if leaving.any():
        alive &= ~leaving
        edges = open_.select((alive | leaving)[open_.source] & (alive | leaving)[open_.target])
    if rule.prune and not len(edges.source):
        raise ValueError(
            f"no step of {', '.join(library.steps)} leads to another within {rule.threshold} m: "
            "raise the threshold or make their beginnings and ends more alike"
            + "".join(f"; {name} {why}" for name, why in unmatched_poses(library).items())
        )
    return MotionGraph(
        library=library,
        edge_start=np.searchsorted(edges.source, np.arange(library.node_count + 1)).astype(np.int32),
        edge_target=edges.target,
        edge_cost=edges.cost,
        edge_transform=edges.transform,
        hops=_hops(library, edges, alive),
        node_end=facts.end,
        node_facing=facts.facing,
        node_facing_start=facts.facing_start,
        node_facing_mean=facts.facing_mean,
        node_start=facts.start,
        node_turns=facts.turns,
        node_peak_turn_rate=facts.peak_turn_rate,
        node_warp_curve=facts.warp_curve,
        node_foot_curve=facts.foot_curve,
        node_reach_margins=facts.reach_margins,
        node_lift_shares=facts.lift_shares,
        moments=facts.moments,
        takes=find_takes(library, leaving),
        alive=alive,
        window=rule.window,
        missing=_missing(library, alive | leaving, rule.threshold),
        joins=joins,
        boundaries=boundaries,
        rule=rule,
        leaving=leaving,
    )


def _missing(library: StepLibrary, alive: Bool, threshold: float) -> tuple[str, ...]:
    poses = unmatched_poses(library)
    lives = np.bincount(library.node_step, weights=alive, minlength=len(library.steps)) > 0
    foot = " on a foot that stands in both" if any(clip.recorded for clip in library.clips) else ""
    only = np.bincount(library.node_step, weights=~library.unjoined, minlength=len(library.steps)) == 0
    poses |= {library.steps[step]: "all its clips are examples of moods" for step in np.flatnonzero(only)}
    return tuple(
        f"{name}: {poses.get(name, f'nothing leads to it and away again within {threshold:g} m{foot}')}"
        for name, lively in zip(library.steps, lives, strict=True)
        if not lively
    )


def _hops(library: StepLibrary, edges: Joins, alive: Bool) -> Int32:
    """Search breadth-first from each step's first measures against the edges, shape (C, N)."""
    count = library.node_count
    begins = alive & (library.node_measure == 0)
    hops = np.empty((len(library.steps), count), np.int32)
    in_start, in_source = np.empty(count + 1, np.int32), np.empty(len(edges.source), np.int32)
    reverse_edges(edges.source, edges.target, in_start, in_source)
    count_hops(library.node_step, begins, in_start, in_source, UNREACHABLE, np.empty(count, np.int32), hops)
    return hops
