"""Where each dancer's clip lies when part of a measure has passed: corrected, and turned on the feet that carry.

The closed form of `editing/support_turns.py` (T048-T050) as a kernel over dancers.
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.kernels import ease
from live.motion.kernels import yaw_rotate
from live.motion.shifting.kernels import risen, shifted

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]


@kernel("f8(f8,f8)")
def soft_share(passed: float, softness: float) -> float:
    """From 0 to 1 as `passed` does, speeding up and slowing down over the share `softness` (0 to 0.5) each."""
    if softness < 1e-9:
        return passed
    edge = min(min(passed, 1.0 - passed), softness)
    ramp = 0.5 * edge * edge / softness
    inner = min(max(passed, softness), 1.0 - softness)
    return (inner - softness + (ramp if passed < 0.5 else softness - ramp)) / (1.0 - softness)


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], i4[::1], f8[:,:,::1], f8[:,:,::1], f8[::1])")
def place_dancers(
    out: Float64,
    placement: Float64,
    correction: Float64,
    aimed: Float64,
    fraction: Float64,
    node: Int32,
    turns: Float64,
    rise: Float64,
    on_support: Float64,
) -> None:
    """Placement (A, 4), x, z [m], yaw of path and body [rad], when `fraction` (A,) of the measure has passed.

    `placement` and `correction` (A, 3): where the clip lies at the measure's start, and what is added until its end.
    The way is added while a foot is in the air, as `rise` (N, KNOTS, 2) says for each node (`shifting/`); `aimed`
    (A, 3) x, z [m] was in already when the share in its last column was, and the rest leads from there. The turn,
    where `on_support` (A,) is not 0, happens while one foot carries and about that foot: `turns` (N, 8, 8) holds per
    node and segment start, stop, weight, x, z [m] at both ends and softness, `node` (A,) the row of each dancer.
    Elsewhere body and path are turned apart: the body by an ease about the hips.
    """
    for n in range(out.shape[0]):
        share = risen(rise[node[n]], fraction[n])
        x = placement[n, 0] + shifted(share, aimed[n, 2], aimed[n, 0], correction[n, 0])
        z = placement[n, 1] + shifted(share, aimed[n, 2], aimed[n, 1], correction[n, 1])
        yaw, angle = placement[n, 2], correction[n, 2]
        if on_support[n] == 0.0:
            out[n, 0], out[n, 1], out[n, 2], out[n, 3] = x, z, yaw, yaw + ease(fraction[n]) * angle
            continue
        before, shift_x, shift_z = 0.0, 0.0, 0.0
        for k in range(turns.shape[1]):
            row = turns[node[n], k]
            if row[2] == 0.0 or angle == 0.0 or fraction[n] <= row[0]:
                continue
            passed = min((fraction[n] - row[0]) / max(row[1] - row[0], 1e-12), 1.0)
            progress = soft_share(passed, row[7])
            turn = angle * row[2] * progress
            way_x, way_z = (row[5] - row[3]) * progress, (row[6] - row[4]) * progress
            # foot - turned(foot + way) + way turned on the average, all carried along by what was turned before
            tx, tz = yaw_rotate(row[3] + way_x, row[4] + way_z, turn)
            half = 0.5 * turn
            even = 1.0 if abs(half) < 1e-6 else math.sin(half) / half
            mx, mz = yaw_rotate(way_x, way_z, half)
            dx, dz = yaw_rotate(row[3] - tx + even * mx, row[4] - tz + even * mz, before)
            shift_x, shift_z = shift_x + dx, shift_z + dz
            before += turn
        dx, dz = yaw_rotate(shift_x, shift_z, yaw)
        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = x + dx, z + dz, yaw + before, yaw + before
