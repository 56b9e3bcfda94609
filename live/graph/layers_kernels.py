"""One layer of a layered search: the cheapest way on from every node, in one pass over the edges."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]
Int32 = npt.NDArray[np.int32]


@kernel("void(f8[::1], i8[::1], i8[::1], i4[::1], f8[::1], f8[::1])")
def cheapest_on(out: Float64, node: Int64, first: Int64, target: Int32, cost: Float64, value: Float64) -> None:
    """What the cheapest edge costs with what comes after it, into `out` (N,); infinite where no edge leaves.

    The edges of `node` (R,) begin at `first` (R,) and lead to `target` (E,) for `cost` (E,); from each node on the
    dance costs `value` (N,).
    """
    for n in range(out.shape[0]):
        out[n] = math.inf
    for row in range(node.shape[0]):
        stop = first[row + 1] if row + 1 < node.shape[0] else target.shape[0]
        least = math.inf
        for edge in range(first[row], stop):
            least = min(least, cost[edge] + value[target[edge]])
        out[node[row]] = least
