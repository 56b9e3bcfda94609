"""Graph kernels: distances to steps in measures, and one layer of the layered search."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]


@kernel("void(i4[::1],i4[::1],i4[::1],i4[::1])")
def reverse_edges(edge_source: Int32, edge_target: Int32, in_start: Int32, in_source: Int32) -> None:
    """Sort the sources of E edges by target into in_source (E,); those of node v begin at in_start[v] (N + 1,)."""
    for v in range(in_start.shape[0]):
        in_start[v] = 0
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
    node_step: Int32, begins: Bool, in_start: Int32, in_source: Int32, unreachable: int, queue: Int32, out: Int32
) -> None:
    """Write the measures from each node to the first measure of each step into out (C, N), or `unreachable`.

    begins (N,): alive nodes that begin a step; the edges into node v come from in_source[in_start[v]] to
    in_source[in_start[v + 1]]; queue (N,) is scratch. Breadth-first search against the edge direction.
    """
    for step in range(out.shape[0]):
        last = 0
        for v in range(out.shape[1]):
            out[step, v] = unreachable
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
                if out[step, u] == unreachable:
                    out[step, u] = out[step, v] + 1
                    queue[last] = u
                    last += 1


Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]


@kernel("void(f8[::1], i8[::1], i8[::1], i4[::1], f8[::1], f8[::1])")
def cheapest_successors(out: Float64, node: Int64, first: Int64, target: Int32, cost: Float64, value: Float64) -> None:
    """Write the least cost of an edge plus the cost after it into `out` (N,); infinite where no edge leaves.

    The edges of `node` (R,) begin at `first` (R,) and lead to `target` (E,) for `cost` (E,); the remaining dance from
    each node costs `value` (N,).
    """
    for n in range(out.shape[0]):
        out[n] = math.inf
    for row in range(node.shape[0]):
        stop = first[row + 1] if row + 1 < node.shape[0] else target.shape[0]
        least = math.inf
        for edge in range(first[row], stop):
            least = min(least, cost[edge] + value[target[edge]])
        out[node[row]] = least
