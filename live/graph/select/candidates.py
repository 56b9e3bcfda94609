"""Candidates: for every measure its clip and its mixtures with other takes, and where each one leads (T069, T070).

Placing: where a measure's clip lies, and where its dancer ends, with takes mixed in and turns inserted.

One implementation for the show, which asks about A dancers at one moment, and for what is put together offline, which
asks about all samples of one dance: A is then the number of samples, or of measures.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.takes import NO_TAKE
from live.motion.editing.turn_insertion import SupportTurns

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]


def turn_vectors(vectors: Float64, yaw: Float64) -> Float64:
    """Rotate stage vectors (A, 2) by yaw (A,) about +Y: (0, 1) becomes (sin yaw, cos yaw)."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, z = vectors[..., 0], vectors[..., 1]
    return np.stack([x * c + z * s, z * c - x * s], axis=-1)


def wrapped(angle: Float64) -> Float64:
    """The same angles [rad] within -π to π."""
    return np.asarray(np.arctan2(np.sin(angle), np.cos(angle)))


def take_offset(graph: MotionGraph, node: Int32, take: Int32) -> tuple[Float64, Float64]:
    """What brings the take's clip into the axes of the node's own: shift (A, 2) [m] and turn (A,) [rad] before it.

    Both have their hips at one place and face the same way when the measure begins (T045).
    """
    own, other = np.maximum(node, 0), np.maximum(take, 0)
    turn = graph.node_facing_start[own] - graph.node_facing_start[other]
    return graph.node_start[own] - turn_vectors(graph.node_start[other], turn), turn


def take_placement(graph: MotionGraph, node: Int32, take: Int32, placement: Float64) -> Float64:
    """Where the takes' clips lie, (A, 4), when the nodes' own lie at `placement` (A, 4): x, z, yaw of path and body."""
    shift, turn = take_offset(graph, node, take)
    out = placement.copy()
    out[:, :2] += turn_vectors(shift, placement[:, 2])
    out[:, 2:] += turn[:, None]
    return out


def own_end(graph: MotionGraph, node: Int32, take: Int32, share: Float64) -> tuple[Float64, Float64]:
    """Hips (A, 2) [m] and heading (A,) [rad] at the measure's end in the clip's own axes, `share` (A,) of a take in."""
    own = np.maximum(node, 0)
    end, facing = graph.node_end[own], graph.node_facing[own]
    share = share * (take != NO_TAKE)
    if not share.any():
        return end, facing
    shift, turn = take_offset(graph, node, take)
    other = np.maximum(take, 0)
    other_end = shift + turn_vectors(graph.node_end[other], turn)
    off = wrapped(graph.node_facing[other] + turn - facing)
    return end + share[:, None] * (other_end - end), facing + share * off


def next_axes(graph: MotionGraph, node: Int32, hips: Float64, heading: Float64) -> Float64:
    """The axes (A, 3), x, z, yaw, in which the next clip joins a dancer who ended `node` at `hips`, facing `heading`.

    The graph's transforms go from the node's own end to the next node's start, so the axes are such that the node's
    own end lies where the dancer really ended.
    """
    own = np.maximum(node, 0)
    yaw = heading - graph.node_facing[own]
    place = hips - turn_vectors(graph.node_end[own], yaw)
    return np.ascontiguousarray(np.column_stack([place, yaw]))


def joined(axes: Float64, transform: Float64) -> Float64:
    """Placements (A, 3) of the clips that follow along edges with `transform` (A, 3), from the `axes` (A, 3) (K001)."""
    place = axes[:, :2] + turn_vectors(transform[:, :2], axes[:, 2])
    return np.column_stack([place, axes[:, 2] + transform[:, 2]])


def begun(graph: MotionGraph, node: Int32, hips: Float64, heading: Float64) -> Float64:
    """Placements (A, 3) of `node` (A,) begun with the hips at `hips` (A, 2) [m], facing `heading` (A,) [rad]."""
    yaw = heading - graph.node_facing_start[node]
    return np.column_stack([hips - turn_vectors(graph.node_start[node], yaw), yaw])


def transition_weight(into: npt.ArrayLike) -> Float64:
    """Weight of the next clip when the share `into` of the transition has passed: C1, after Kovar (K004)."""
    into = np.clip(np.asarray(into, np.float64), 0.0, 1.0)
    return np.asarray(into * into * (3.0 - 2.0 * into))


Bool = npt.NDArray[np.bool_]

WEIGHTS: Final = (0.25, 0.5, 0.75)
"""Shares of the other clip; finer steps are barely noticeable (T069)."""
OPPOSITE: Final = np.radians(135.0)
"""Ways that are farther apart than this are opposite: what is mixed of them goes nowhere (T069)."""
STANDING: Final = 0.05
"""A way shorter than this [m] has no direction."""
MOST_TAKES: Final = 24
"""Of more takes of one measure so many are tried, evenly chosen from all."""
WIDENS: Final = 0.04
"""A mixture widens a measure's reach if it ends so far [m] (a radian of heading is a metre) from what there is."""
QUICKEST_TURN: Final = 5.0
"""Dancers turn at most this fast [rad/s]: a measure that carries them on one foot for a moment only turns less."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """K candidates as compressed rows of the N nodes; the first one of each node is its own clip, unmixed."""

    first: Int32
    """Candidates of node u are first[u] to first[u + 1], shape (N + 1,)."""
    node: Int32
    """Shape (K,)."""
    take: Int32
    """Node of the other take, NO_TAKE for the clip alone, shape (K,)."""
    share: Float64
    """How much of it is mixed in, shape (K,)."""
    end: Float64
    """Hips at the measure's end, in the axes of the node's own clip, not turned [m], shape (K, 2)."""
    facing: Float64
    """Heading there [rad], shape (K,)."""
    turns: SupportTurns
    """Where each of the N nodes turns (T048-T050)."""
    quickest: Float64
    """How fast a turn of each node is at its fastest, in whole angles per measure, shape (N,)."""

    def most_turn(self, seconds: float) -> Float64:
        """The largest angle [rad] that each node can be turned by if a measure takes `seconds`, shape (N,)."""
        return np.minimum(np.pi, QUICKEST_TURN * seconds / self.quickest)

    def turned_end(self, rows: Int32, placement: Float64, angle: Float64) -> tuple[Float64, Float64]:
        """Hips (n, 2) and heading (n,) at the end of candidates `rows` (n,), laid down at `placement` (n, 3).

        `angle` (n,) [rad] is turned on the carrying foot, which holds its place, so the way changes, too (T070).
        """
        moved = self.turns.take(self.node[rows]).displacement(1.0, angle)
        yaw = placement[:, 2]
        hips = placement[:, :2] + turn_vectors(moved, yaw) + turn_vectors(self.end[rows], yaw + angle)
        return hips, yaw + angle + self.facing[rows]


def find_candidates(graph: MotionGraph, weights: tuple[float, ...] = WEIGHTS) -> Candidates:
    """All candidates of a graph: clips and, by `weights`, their mixtures with takes that do not go the opposite way."""
    node, take, share, first = [], [], [], [0]
    way = measure_ways(graph)
    for u in range(graph.library.node_count):
        others = graph.takes.node[graph.takes.start[u] : graph.takes.start[u + 1]]
        others = others[~opposite(way[u], way[others])]
        if len(others) > MOST_TAKES:
            others = others[np.linspace(0, len(others) - 1, MOST_TAKES).astype(np.int64)]
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
        quickest=graph.node_quickest,
    )


def widening(graph: MotionGraph, candidates: Candidates, least: float = WIDENS) -> Candidates:
    """Those that widen the reach: clips, and mixtures that end at least `least` from all that their node has already.

    Recordings of one way are many takes whose mixtures all lead to one place; to weigh them would be in vain.
    """
    ends = np.column_stack([candidates.end, candidates.facing])
    kept: list[Int32] = []
    first = [0]
    for u in range(graph.library.node_count):
        rows = np.arange(candidates.first[u], candidates.first[u + 1], dtype=np.int32)
        own = [int(rows[0])]
        apart = _apart(ends[rows], ends[rows[0]])
        while len(apart) and apart.max() >= least:  # the farthest first: few cover all
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
    return np.asarray(np.sqrt(off[:, 0] ** 2 + off[:, 1] ** 2 + wrapped(off[:, 2]) ** 2))


def turns_of(graph: MotionGraph) -> SupportTurns:
    """The graph's rows of turns (N, 8, 8) as SupportTurns of N measures."""
    start, stop, weight, x, z, stop_x, stop_z, softness = np.moveaxis(graph.node_turns, -1, 0)
    return SupportTurns(
        start, stop, weight, np.stack([x, z], axis=-1), np.stack([stop_x, stop_z], axis=-1), softness
    )  # fmt: skip


def measure_ways(graph: MotionGraph) -> Float64:
    """Way of each measure as the dancer sees it who begins it: x to her left, z ahead [m], shape (N, 2)."""
    return turn_vectors(graph.node_end - graph.node_start, -graph.node_facing_start)


def opposite(way: Float64, others: Float64) -> Bool:
    """Whether each of the ways `others` (n, 2) goes against `way` (2,); what stands goes against nothing, (n,)."""
    apart = wrapped(np.arctan2(others[:, 0], others[:, 1]) - np.arctan2(way[0], way[1]))
    moves = (np.hypot(*others.T) > STANDING) & (np.hypot(*way) > STANDING)
    return np.asarray(moves & (np.abs(apart) > OPPOSITE), np.bool_)
