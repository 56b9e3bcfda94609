"""Graph kernels: how many measures steps are away."""

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]


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
