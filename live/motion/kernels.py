"""Pose kernels: sample two clips, blend, place on the stage, forward kinematics; all dancers in one call."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.kernels import quat_mul, quat_rotate, quat_slerp

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]


@kernel("UniTuple(f8,2)(f8,f8,f8)")
def yaw_rotate(x: float, z: float, yaw: float) -> tuple[float, float]:
    """Rotate the stage vector (x, z) by `yaw` about +Y: (0, 1), the public, becomes (sin yaw, cos yaw) (as in K001)."""
    c, s = math.cos(yaw), math.sin(yaw)
    return (x * c + z * s, z * c - x * s)


@kernel("void(f4[:,::1], f4[:,:,::1], i8, f4[:,::1], f4[:,:,::1], f8, f8, f8, f8, f8)")
def _place_sample(
    out_root: Float32,
    out_rotation: Float32,
    row: int,
    clip_root: Float32,
    clip_rotation: Float32,
    sample: float,
    x: float,
    z: float,
    path_yaw: float,
    body_yaw: float,
) -> None:
    """Pose of one dancer at a fractional sample, root in the world, other rotations local, into row `row`."""
    last = clip_root.shape[0] - 1
    i = min(max(math.floor(sample), 0), last)
    k = min(i + 1, last)
    t = min(max(sample - i, 0.0), 1.0)
    rx = (1.0 - t) * clip_root[i, 0] + t * clip_root[k, 0]
    rz = (1.0 - t) * clip_root[i, 2] + t * clip_root[k, 2]
    wx, wz = yaw_rotate(rx, rz, path_yaw)
    out_root[row, 0] = x + wx
    out_root[row, 1] = (1.0 - t) * clip_root[i, 1] + t * clip_root[k, 1]
    out_root[row, 2] = z + wz
    for j in range(clip_rotation.shape[1]):
        a, b = clip_rotation[i, j], clip_rotation[k, j]
        w, qx, qy, qz = quat_slerp(a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3], t)
        if j == 0:
            w, qx, qy, qz = quat_mul(math.cos(0.5 * body_yaw), 0.0, math.sin(0.5 * body_yaw), 0.0, w, qx, qy, qz)
        out_rotation[row, j, 0] = w
        out_rotation[row, j, 1] = qx
        out_rotation[row, j, 2] = qy
        out_rotation[row, j, 3] = qz


@kernel(
    "void(f4[:,::1], f4[:,:,::1], f4[:,::1], f4[:,:,::1], f8[::1], f8[::1], f8[::1], f8[:,::1], f8[:,::1],"
    " f4[:,::1], f4[:,:,::1])"
)
def pose_sample(
    out_root: Float32,
    out_rotation: Float32,
    clip_root: Float32,
    clip_rotation: Float32,
    sample_a: Float64,
    sample_b: Float64,
    weight: Float64,
    placement_a: Float64,
    placement_b: Float64,
    scratch_root: Float32,
    scratch_rotation: Float32,
) -> None:
    """Blend clip a into clip b with `weight` of b: rotations by SLERP, the root linearly (T035 as corrected, T045).

    out_root (A, 3) world [m]; out_rotation (A, J, 4), the root's in the world, the others local; clip_root (S, 3) and
    clip_rotation (S, J, 4) are all clips one after another; sample_a, sample_b (A,) fractional samples into them;
    weight (A,) in [0, 1]; placements (A, 4): x, z [m], yaw of the path, yaw of the body [rad]; scratch (1, 3) and
    (1, J, 4).
    """
    for n in range(out_root.shape[0]):
        p = placement_a[n]
        _place_sample(out_root, out_rotation, n, clip_root, clip_rotation, sample_a[n], p[0], p[1], p[2], p[3])
        t = weight[n]
        if t <= 0.0:
            continue
        p = placement_b[n]
        _place_sample(scratch_root, scratch_rotation, 0, clip_root, clip_rotation, sample_b[n], p[0], p[1], p[2], p[3])
        for c in range(3):
            out_root[n, c] = (1.0 - t) * out_root[n, c] + t * scratch_root[0, c]
        for j in range(out_rotation.shape[1]):
            a, b = out_rotation[n, j], scratch_rotation[0, j]
            w, x, y, z = quat_slerp(a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3], t)
            a[0], a[1], a[2], a[3] = w, x, y, z


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[:,::1], f4[:,:,::1], f4[:,::1], i4[::1])")
def pose_forward(
    out_position: Float32,
    out_rotation: Float32,
    root: Float32,
    rotation: Float32,
    offsets: Float32,
    parents: Int32,
) -> None:
    """Forward kinematics: world positions (A, J, 3) [m] and world rotations (A, J, 4) from root and local rotations."""
    for n in range(root.shape[0]):
        for j in range(rotation.shape[1]):
            q = rotation[n, j]
            parent = parents[j]
            if parent < 0:
                for c in range(3):
                    out_position[n, j, c] = root[n, c]
                for c in range(4):
                    out_rotation[n, j, c] = q[c]
                continue
            p = out_rotation[n, parent]
            w, x, y, z = quat_mul(p[0], p[1], p[2], p[3], q[0], q[1], q[2], q[3])
            out_rotation[n, j, 0] = w
            out_rotation[n, j, 1] = x
            out_rotation[n, j, 2] = y
            out_rotation[n, j, 3] = z
            o = offsets[j]
            dx, dy, dz = quat_rotate(p[0], p[1], p[2], p[3], o[0], o[1], o[2])
            out_position[n, j, 0] = out_position[n, parent, 0] + dx
            out_position[n, j, 1] = out_position[n, parent, 1] + dy
            out_position[n, j, 2] = out_position[n, parent, 2] + dz
