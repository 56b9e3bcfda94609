"""Placing: where a measure's clip lies, and where its dancer ends, with takes mixed in and turns inserted.

One implementation for the show, which asks about A dancers at one moment, and for what is put together offline, which
asks about all samples of one dance: A is then the number of samples, or of measures.
"""

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.takes import NO_TAKE

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
