"""Where the measures of all dancers end, and where the clips that follow join, in one pass."""

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.motion.pose.turning_kernels import placed
from live.motion.yaw_kernels import yaw_rotate

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]


@kernel(
    "void(f8[:,::1], f8[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i4[::1], f8[:,:,::1], f8[:,:,::1], f8[::1],"
    " f8[:,::1], f8[::1], f8[:,::1], f8[::1])"
)
def end_dancers(
    hips: Float64,
    heading: Float64,
    axes: Float64,
    placement: Float64,
    correction: Float64,
    aimed: Float64,
    node: Int32,
    turns: Float64,
    rise: Float64,
    on_support: Float64,
    end: Float64,
    facing: Float64,
    node_end: Float64,
    node_facing: Float64,
) -> None:
    """Hips (A, 2) [m], heading (A,) [rad] and the `axes` (A, 3) x, z, yaw of the clips that follow, at measures' ends.

    `placement` to `on_support` as in `place_dancers`; `end` (A, 2) and `facing` (A,): where hips and bodies end in the
    clips' own axes, takes mixed in; `node_end` (N, 2) and `node_facing` (N,): the same of the nodes alone, from which
    the graph's transforms go on (`next_axes`).
    """
    for n in range(node.shape[0]):
        v = max(node[n], 0)
        x, z, path, body = placed(placement[n], correction[n], aimed[n], 1.0, turns[v], rise[v], on_support[n])
        dx, dz = yaw_rotate(end[n, 0], end[n, 1], path)
        hips[n, 0], hips[n, 1], heading[n] = x + dx, z + dz, body + facing[n]
        yaw = heading[n] - node_facing[v]
        dx, dz = yaw_rotate(node_end[v, 0], node_end[v, 1], yaw)
        axes[n, 0], axes[n, 1], axes[n, 2] = hips[n, 0] - dx, hips[n, 1] - dz, yaw
