"""Placement of each dancer's clip within a measure: corrected, and turned about the supporting feet.

This is the closed form of `support_turns` in `live.motion.editing.turn_insertion` (T048-T050) as a kernel over dancers.
It also computes the measures' ends, where the next clips join.
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.scalar_kernels import ease
from live.motion.pose.warp_curve_kernels import warp_share, warped_shift
from live.motion.pose.yaw_kernels import yaw_rotate

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]


@kernel("f8(f8,f8)")
def eased_share(passed: float, softness: float) -> float:
    """Return the eased share of `passed`, 0 to 1, accelerating and decelerating over `softness` (0 to 0.5) each."""
    if softness < 1e-9:
        return passed
    edge = min(min(passed, 1.0 - passed), softness)
    ramp = 0.5 * edge * edge / softness
    inner = min(max(passed, softness), 1.0 - softness)
    return (inner - softness + (ramp if passed < 0.5 else softness - ramp)) / (1.0 - softness)


@kernel("UniTuple(f8,4)(f8[::1], f8[::1], f8[::1], f8, f8[:,::1], f8[:,::1], f8)")
def place_clip(
    placement: Float64,
    correction: Float64,
    aimed: Float64,
    fraction: float,
    turns: Float64,
    warp_curve: Float64,
    on_support: float,
) -> tuple[float, float, float, float]:
    """Return x, z [m], yaw of path and body [rad] of one dancer's clip as in `place_dancers`; `turns`, `warp_curve` of
    the node."""
    share = warp_share(warp_curve, fraction)
    x = placement[0] + warped_shift(share, aimed[2], aimed[0], correction[0])
    z = placement[1] + warped_shift(share, aimed[2], aimed[1], correction[1])
    yaw, angle = placement[2], correction[2]
    if on_support == 0.0 or angle == 0.0:
        return x, z, yaw, yaw + ease(fraction) * angle
    before, shift_x, shift_z = 0.0, 0.0, 0.0
    sine, cosine = 0.0, 1.0  # of `before`; those of all angles come from half of each turn's
    for k in range(turns.shape[0]):
        row = turns[k]
        if row[2] == 0.0 or fraction <= row[0]:
            continue
        passed = min((fraction - row[0]) / max(row[1] - row[0], 1e-12), 1.0)
        progress = eased_share(passed, row[7])
        half = 0.5 * angle * row[2] * progress
        s, c = math.sin(half), math.cos(half)
        turn_s, turn_c = 2.0 * s * c, 1.0 - 2.0 * s * s
        even = 1.0 if abs(half) < 1e-6 else s / half
        way_x, way_z = (row[5] - row[3]) * progress, (row[6] - row[4]) * progress
        # foot - turned(foot + way) + way turned on average, all rotated by the preceding turns
        foot_x, foot_z = row[3] + way_x, row[4] + way_z
        x_off = row[3] - (turn_c * foot_x + turn_s * foot_z) + even * (c * way_x + s * way_z)
        z_off = row[4] - (turn_c * foot_z - turn_s * foot_x) + even * (c * way_z - s * way_x)
        shift_x, shift_z = shift_x + cosine * x_off + sine * z_off, shift_z + cosine * z_off - sine * x_off
        sine, cosine = sine * turn_c + cosine * turn_s, cosine * turn_c - sine * turn_s
        before += 2.0 * half
    dx, dz = yaw_rotate(shift_x, shift_z, yaw)
    return x + dx, z + dz, yaw + before, yaw + before


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], i4[::1], f8[:,:,::1], f8[:,:,::1], f8[::1])")
def place_dancers(
    out: Float64,
    placement: Float64,
    correction: Float64,
    aimed: Float64,
    fraction: Float64,
    node: Int32,
    turns: Float64,
    warp_curve: Float64,
    on_support: Float64,
) -> None:
    """Compute placements (A, 4), x, z [m], yaw of path and body [rad], at `fraction` (A,) of the measure.

    `placement` and `correction` (A, 3): the clip's placement at the measure's start, and the change until its end. The
    translation is applied while a foot is in the air, by the `warp_curve` (N, KNOTS, 2) of each node
    (`footstep_plan`); `aimed` (A, 3) x, z [m] was applied when the share was its last column, and the rest continues
    from there. If `on_support` (A,) is not 0, the turn happens during single support about the supporting foot: `turns`
    (N, 8, 8) holds per node and segment start, stop, weight, x, z [m] at both ends and softness, `node` (A,) the row of
    each dancer. Otherwise body and path are turned separately: the body by an ease about the hips.
    """
    for n in range(out.shape[0]):
        v = node[n]
        x, z, path, body = place_clip(
            placement[n], correction[n], aimed[n], fraction[n], turns[v], warp_curve[v], on_support[n]
        )
        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = x, z, path, body


@kernel(
    "void(f4[:,:,::1], f4[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i4[::1], f8[:,:,::1], f8[:,:,::1],"
    " f8[::1], f4[:,::1], f8[::1], f8[::1], i4[::1], f8[:,::1], f4[::1], b1)"
)
def trace_hips(
    path: Float32,
    share: Float32,
    phase: Float64,
    placement: Float64,
    correction: Float64,
    aimed: Float64,
    node: Int32,
    turns: Float64,
    warp_curve: Float64,
    on_support: Float64,
    clip_root: Float32,
    node_first: Float64,
    node_last: Float64,
    take: Int32,
    take_offset: Float64,
    take_share: Float32,
    settled: bool,
) -> None:
    """Compute the hips of A dancers at M moments [m], `path` (A, M, 2), and the share of the correction applied by
    then.

    `phase` (A, M): phase in each dancer's measure; below 0 nothing is written. For an open measure the path excludes
    the correction's translation, and its `share` (A, M) is the warp curve; for a `settled` one the path includes it and
    the share is 0. `clip_root` (S, 3) and `node_first`, `node_last` (N,) as in the library; another take's hips are
    mixed in by `take_share` (A,), its clip placed at `take_offset` (A, 3) x, z [m], yaw in the own clip's axes. Other
    arrays as in `place_dancers`.
    """
    nothing = np.zeros(3)
    turn = np.zeros(3)
    for n in range(node.shape[0]):
        v = max(node[n], 0)
        turn[2] = correction[n, 2]
        for m in range(phase.shape[1]):
            f = min(phase[n, m], 1.0)
            if f < 0.0:
                continue
            way, start = (correction[n], aimed[n]) if settled else (turn, nothing)
            x, z, yaw, _ = place_clip(placement[n], way, start, f, turns[v], warp_curve[v], on_support[n])
            k = min(int(node_first[v] + f * (node_last[v] - node_first[v]) + 0.5), clip_root.shape[0] - 1)
            hx, hz = clip_root[k, 0], clip_root[k, 2]
            if take_share[n] > 0.0 and take[n] >= 0:
                u = take[n]
                k = min(int(node_first[u] + f * (node_last[u] - node_first[u]) + 0.5), clip_root.shape[0] - 1)
                ox, oz = yaw_rotate(clip_root[k, 0], clip_root[k, 2], take_offset[n, 2])
                hx += take_share[n] * (take_offset[n, 0] + ox - hx)
                hz += take_share[n] * (take_offset[n, 1] + oz - hz)
            dx, dz = yaw_rotate(hx, hz, yaw)
            path[n, m, 0], path[n, m, 1] = x + dx, z + dz
            share[n, m] = 0.0 if settled else warp_share(warp_curve[v], f)


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
    warp_curve: Float64,
    on_support: Float64,
    end: Float64,
    facing: Float64,
    node_end: Float64,
    node_facing: Float64,
) -> None:
    """Compute hips (A, 2) [m], heading (A,) [rad] and the next clips' `axes` (A, 3) x, z, yaw at the measures' ends.

    `placement` to `on_support` as in `place_dancers`; `end` (A, 2) and `facing` (A,): final hips and facing in the
    clips' axes, takes mixed in; `node_end` (N, 2) and `node_facing` (N,): the same of the nodes alone, to which the
    graph's transforms refer.
    """
    for n in range(node.shape[0]):
        v = max(node[n], 0)
        x, z, path, body = place_clip(
            placement[n], correction[n], aimed[n], 1.0, turns[v], warp_curve[v], on_support[n]
        )
        dx, dz = yaw_rotate(end[n, 0], end[n, 1], path)
        hips[n, 0], hips[n, 1], heading[n] = x + dx, z + dz, body + facing[n]
        yaw = heading[n] - node_facing[v]
        dx, dz = yaw_rotate(node_end[v, 0], node_end[v, 1], yaw)
        axes[n, 0], axes[n, 1], axes[n, 2] = hips[n, 0] - dx, hips[n, 1] - dz, yaw
