"""Graph kernels: the choice of the next measure, all edges weighed in one call (T068, T070); how far steps are."""

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.kernels import angle_wrap
from live.motion.kernels import yaw_rotate

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]


@kernel(
    "void(i4[::1],f8[:,::1],f8[:,::1],f8[::1],i4[::1],f8[:,::1],i4[::1],i4[::1],f8[::1],f8[:,::1],"
    "f8[:,::1],f8[::1],i4[::1],i4[::1],f8[::1],i4[::1],f8[:,::1])"
)
def choose_edges(
    node: Int32,
    placement: Float64,
    target: Float64,
    heading: Float64,
    row: Int32,
    ahead: Float64,
    edge_start: Int32,
    edge_target: Int32,
    edge_cost: Float64,
    edge_transform: Float64,
    node_end: Float64,
    node_facing: Float64,
    side: Int32,
    node_side: Int32,
    weights: Float64,
    out_edge: Int32,
    out_placement: Float64,
) -> None:
    """For every dancer the edge whose measure ends best: fewest wrong measures from there on, then place and heading.

    node (A,) where each dancer is; placement (A, 3) x, z, yaw of her clip's axes when that node ends; target (A, 2)
    where she should stand one measure later [m]; heading (A,) [rad]; ahead (R, N) how many measures go wrong if a node
    is danced next, row (A,) which of its rows counts; edges as CSR with the rigid transform (E, 3) x, z, yaw that
    places the next clip in the axes of the last (K001); node_end (N, 2) hips at the node's end in its clip's axes;
    node_facing (N,) heading there; side (A,) and node_side (N,): -1 as made, 1 mirrored, 0 no matter; weights: metre²
    of place, rad² of heading, unit of edge cost, wrong measure, wrong side. Results: out_edge (A,) or -1 at a dead
    end, out_placement (A, 3).
    """
    for n in range(node.shape[0]):
        best, lowest = -1, 1e300
        for e in range(edge_start[node[n]], edge_start[node[n] + 1]):
            v = edge_target[e]
            cost = weights[2] * edge_cost[e] + weights[3] * ahead[row[n], v]
            if side[n] * node_side[v] < 0:
                cost += weights[4]
            dx, dz = yaw_rotate(edge_transform[e, 0], edge_transform[e, 1], placement[n, 2])
            x, z = placement[n, 0] + dx, placement[n, 1] + dz
            yaw = placement[n, 2] + edge_transform[e, 2]
            ex, ez = yaw_rotate(node_end[v, 0], node_end[v, 1], yaw)
            cost += weights[0] * ((x + ex - target[n, 0]) ** 2 + (z + ez - target[n, 1]) ** 2)
            cost += weights[1] * angle_wrap(yaw + node_facing[v] - heading[n]) ** 2
            if cost < lowest:
                best, lowest = e, cost
                out_placement[n, 0] = x
                out_placement[n, 1] = z
                out_placement[n, 2] = yaw
        out_edge[n] = best


@kernel("void(i4[::1],i4[::1],i4[::1],i4[::1])")
def reverse_edges(edge_source: Int32, edge_target: Int32, in_start: Int32, in_source: Int32) -> None:
    """Sort the sources of E edges by target into in_source (E,); those of node v begin at in_start[v] (N + 1,)."""
    in_start[:] = 0
    for e in range(edge_target.shape[0]):
        in_start[edge_target[e]] += 1
    total = 0
    for v in range(in_start.shape[0]):
        total += in_start[v]
        in_start[v] = total
    for e in range(edge_target.shape[0] - 1, -1, -1):
        v = edge_target[e]
        in_start[v] -= 1
        in_source[in_start[v]] = edge_source[e]


@kernel("void(i4[::1],b1[::1],i4[::1],i4[::1],i4,i4[::1],i4[:,::1])")
def count_hops(
    node_step: Int32, begins: Bool, in_start: Int32, in_source: Int32, never: int, queue: Int32, out: Int32
) -> None:
    """Measures from each node to the first measure of each step, `never` if there is no way, into out (C, N).

    begins (N,): nodes that begin a step and live; the edges into node v come from in_source[in_start[v]] to
    in_source[in_start[v + 1]]; queue (N,) is room. Breadth-first against the arrows.
    """
    for step in range(out.shape[0]):
        last = 0
        for v in range(out.shape[1]):
            out[step, v] = never
            if begins[v] and node_step[v] == step:
                out[step, v] = 0
                queue[last] = v
                last += 1
        first = 0
        while first < last:
            v = queue[first]
            first += 1
            for e in range(in_start[v], in_start[v + 1]):
                u = in_source[e]
                if out[step, u] == never:
                    out[step, u] = out[step, v] + 1
                    queue[last] = u
                    last += 1
