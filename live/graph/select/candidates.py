"""Candidates for the next measure: clips, their mixtures with other takes, and where each one ends (T069, T070).

The placement functions serve both the show, with A dancers at one moment, and offline rendering, where A is the number
of samples or measures of one dance.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64, Int32
from live.graph.takes import NO_TAKE
from live.motion.editing.turn_insertion import SupportTurns

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph


def turn_vectors(vectors: Float64, yaw: Float64) -> Float64:
    """Rotate stage vectors (A, 2) by yaw (A,) about +Y: (0, 1) becomes (sin yaw, cos yaw)."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, z = vectors[..., 0], vectors[..., 1]
    return np.stack([x * c + z * s, z * c - x * s], axis=-1)


def wrap_angle(angle: Float64) -> Float64:
    """Return the angles [rad] wrapped to -π to π."""
    return np.asarray(np.arctan2(np.sin(angle), np.cos(angle)))


def take_offset(graph: "MotionGraph", node: Int32, take: Int32) -> tuple[Float64, Float64]:
    """Return the transform from a take's clip to the node's own axes: shift (A, 2) [m] after turn (A,) [rad].

    Both have the same hip position and heading at the beginning of the measure (T045).
    """
    own, other = np.maximum(node, 0), np.maximum(take, 0)
    turn = graph.node_facing_start[own] - graph.node_facing_start[other]
    return graph.node_start[own] - turn_vectors(graph.node_start[other], turn), turn


def take_placement(graph: "MotionGraph", node: Int32, take: Int32, placement: Float64) -> Float64:
    """Return placements (A, 4) of the takes' clips for the nodes' `placement` (A, 4): x, z, yaw of path and body."""
    shift, turn = take_offset(graph, node, take)
    out = placement.copy()
    out[:, :2] += turn_vectors(shift, placement[:, 2])
    out[:, 2:] += turn[:, None]
    return out


def own_end(graph: "MotionGraph", node: Int32, take: Int32, share: Float64) -> tuple[Float64, Float64]:
    """Return hips (A, 2) [m] and heading (A,) [rad] at the measure's end in clip axes, with `share` (A,) of a take."""
    own = np.maximum(node, 0)
    end, facing = graph.node_end[own], graph.node_facing[own]
    share = share * (take != NO_TAKE)
    if not share.any():
        return end, facing
    shift, turn = take_offset(graph, node, take)
    other = np.maximum(take, 0)
    other_end = shift + turn_vectors(graph.node_end[other], turn)
    off = wrap_angle(graph.node_facing[other] + turn - facing)
    return end + share[:, None] * (other_end - end), facing + share * off


def next_axes(graph: "MotionGraph", node: Int32, hips: Float64, heading: Float64) -> Float64:
    """Return the axes (A, 3), x, z, yaw, in which the next clip joins after `node` ended at `hips` and `heading`.

    The graph's transforms lead from the node's own end to the next node's start, so in these axes the node's own end
    lies where the dancer actually ended.
    """
    own = np.maximum(node, 0)
    yaw = heading - graph.node_facing[own]
    place = hips - turn_vectors(graph.node_end[own], yaw)
    return np.ascontiguousarray(np.column_stack([place, yaw]))


def following_placement(axes: Float64, transform: Float64) -> Float64:
    """Return placements (A, 3) of clips that follow along edges with `transform` (A, 3), from `axes` (A, 3) (K001)."""
    place = axes[:, :2] + turn_vectors(transform[:, :2], axes[:, 2])
    return np.column_stack([place, axes[:, 2] + transform[:, 2]])


def starting_placement(graph: "MotionGraph", node: Int32, hips: Float64, heading: Float64) -> Float64:
    """Return placements (A, 3) of `node` (A,) begun with hips at `hips` (A, 2) [m] and `heading` (A,) [rad]."""
    yaw = heading - graph.node_facing_start[node]
    return np.column_stack([hips - turn_vectors(graph.node_start[node], yaw), yaw])


def transition_weight(into: npt.ArrayLike) -> Float64:
    """Return the weight of the next clip at the share `into` of the transition: C1, after Kovar (K004)."""
    into = np.clip(np.asarray(into, np.float64), 0.0, 1.0)
    return np.asarray(into * into * (3.0 - 2.0 * into))


WEIGHTS: Final = (0.25, 0.5, 0.75)
"""Shares of the other clip; finer steps are barely noticeable (T069)."""
OPPOSITE: Final = np.radians(135.0)
"""Displacements farther apart than this are opposite: their mixture goes nowhere (T069)."""
MIN_TRAVEL: Final = 0.05
"""A displacement shorter than this [m] has no direction."""
MAX_TAKES: Final = 24
"""Maximum number of takes of one measure that are tried, evenly chosen from all."""
MIN_WIDENING: Final = 0.04
"""A mixture widens a measure's reach if its end is this far [m] (a radian counts as a metre) from existing ends."""
MAX_TURN_RATE: Final = 5.0
"""Maximum turning speed [rad/s]: a measure with only a short one-foot support turns less."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """K candidates as compressed rows of the N nodes; the first of each node is its own clip, unmixed."""

    first: Int32
    """Candidates of node u are first[u] to first[u + 1], shape (N + 1,)."""
    node: Int32
    """Shape (K,)."""
    take: Int32
    """Node of the other take, NO_TAKE for the clip alone, shape (K,)."""
    share: Float64
    """Share of the take, shape (K,)."""
    end: Float64
    """Hips at the measure's end in the axes of the node's own clip, without turn [m], shape (K, 2)."""
    facing: Float64
    """Heading there [rad], shape (K,)."""
    turns: SupportTurns
    """The support turns of the N nodes (T048-T050)."""
    peak_turn_rate: Float64
    """Peak speed of a turn of each node, in whole angles per measure, shape (N,)."""

    def max_turn(self, seconds: float) -> Float64:
        """Return the largest turn [rad] of each node in a measure of `seconds`, shape (N,)."""
        return np.minimum(np.pi, MAX_TURN_RATE * seconds / self.peak_turn_rate)

    def turned_end(self, rows: Int32, placement: Float64, angle: Float64) -> tuple[Float64, Float64]:
        """Return hips (n, 2) and heading (n,) at the end of candidates `rows` (n,), placed at `placement` (n, 3).

        The turn `angle` (n,) [rad] pivots on the supporting foot, so it changes the displacement, too (T070).
        """
        moved = self.turns.select(self.node[rows]).displacement(1.0, angle)
        yaw = placement[:, 2]
        hips = placement[:, :2] + turn_vectors(moved, yaw) + turn_vectors(self.end[rows], yaw + angle)
        return hips, yaw + angle + self.facing[rows]


def find_candidates(graph: "MotionGraph", weights: tuple[float, ...] = WEIGHTS) -> Candidates:
    """Return all candidates of a graph: clips, and mixtures by `weights` with takes that do not go the opposite way."""
    node, take, share, first = [], [], [], [0]
    way, variation = measure_displacements(graph), graph.library.node_variation
    for u in range(graph.library.node_count):
        others = graph.takes.node[graph.takes.start[u] : graph.takes.start[u + 1]]
        others = others[~is_opposite(way[u], way[others]) & ~variation[others]]  # a variation goes the same way
        if len(others) > MAX_TAKES:
            others = others[np.linspace(0, len(others) - 1, MAX_TAKES).astype(np.int64)]
        count = 1 + len(others) * len(weights)
        node.append(np.full(count, u, np.int32))
        take.append(np.concatenate(([NO_TAKE], np.repeat(others, len(weights)))).astype(np.int32))
        share.append(np.concatenate(([0.0], np.tile(weights, len(others)))))
        first.append(first[-1] + count)
    nodes, takes, shares = np.concatenate(node), np.concatenate(take), np.concatenate(share)
    end, facing = own_end(graph, nodes, takes, shares)
    return Candidates(
        first=np.array(first, np.int32),
        node=nodes,
        take=takes,
        share=shares,
        end=end,
        facing=facing,
        turns=turns_of(graph),
        peak_turn_rate=graph.node_peak_turn_rate,
    )


def widening_candidates(graph: "MotionGraph", candidates: Candidates, least: float = MIN_WIDENING) -> Candidates:
    """Keep candidates that widen the reach: clips, and mixtures that end at least `least` from all ends of their node.

    Recordings of one direction are many takes whose mixtures all lead to one place; evaluating them gains nothing.
    """
    ends = np.column_stack([candidates.end, candidates.facing])
    kept: list[Int32] = []
    first = [0]
    for u in range(graph.library.node_count):
        rows = np.arange(candidates.first[u], candidates.first[u + 1], dtype=np.int32)
        own = [int(rows[0])]
        apart = _apart(ends[rows], ends[rows[0]])
        while len(apart) and apart.max() >= least:  # the farthest first, so that few cover all
            chosen = int(apart.argmax())
            own.append(int(rows[chosen]))
            apart = np.minimum(apart, _apart(ends[rows], ends[rows[chosen]]))
        kept.append(np.sort(np.array(own, np.int32)))
        first.append(first[-1] + len(own))
    row = np.concatenate(kept)
    return replace(
        candidates, first=np.array(first, np.int32), node=candidates.node[row], take=candidates.take[row],
        share=candidates.share[row], end=candidates.end[row], facing=candidates.facing[row],
    )  # fmt: skip


def _apart(ends: Float64, end: Float64) -> Float64:
    off = ends - end
    return np.asarray(np.sqrt(off[:, 0] ** 2 + off[:, 1] ** 2 + wrap_angle(off[:, 2]) ** 2))


def turns_of(graph: "MotionGraph") -> SupportTurns:
    """Return the graph's rows of turns (N, 8, 8) as SupportTurns of N measures."""
    start, stop, weight, x, z, stop_x, stop_z, softness = np.moveaxis(graph.node_turns, -1, 0)
    return SupportTurns(
        start, stop, weight, np.stack([x, z], axis=-1), np.stack([stop_x, stop_z], axis=-1), softness
    )  # fmt: skip


def measure_displacements(graph: "MotionGraph") -> Float64:
    """Return the displacement of each measure relative to the dancer at its beginning: x left, z ahead [m], (N, 2)."""
    return turn_vectors(graph.node_end - graph.node_start, -graph.node_facing_start)


def is_opposite(way: Float64, others: Float64) -> Bool:
    """Whether each of the displacements `others` (n, 2) is opposite to `way` (2,); a standing one never is, (n,)."""
    apart = wrap_angle(np.arctan2(others[:, 0], others[:, 1]) - np.arctan2(way[0], way[1]))
    moves = (np.hypot(*others.T) > MIN_TRAVEL) & (np.hypot(*way) > MIN_TRAVEL)
    return np.asarray(moves & (np.abs(apart) > OPPOSITE), np.bool_)
