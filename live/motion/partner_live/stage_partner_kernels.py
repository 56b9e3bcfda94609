"""Kernels that blend a live partner's poses into the dancers on the stage."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]


@inline_kernel
def _nlerp(out: Float32, a: Float32, b: Float32, share: float) -> None:
    """Write the normalized blend of rotations `a` to `b` (nearest signs) at `share` to `out`; slight extrapolation is
    fine."""
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
    left, right = 1.0 - share, -share if dot < 0.0 else share
    size = 0.0
    for k in range(4):
        out[k] = np.float32(left * a[k] + right * b[k])
        size += float(out[k]) * float(out[k])
    size = 1.0 / math.sqrt(max(size, 1e-20))
    for k in range(4):
        out[k] = np.float32(out[k] * size)


@inline_kernel
def _heading(q: Float32) -> float:
    """Return the heading of hips with the rotation `q` [rad]."""
    return math.atan2(2.0 * (q[1] * q[3] + q[0] * q[2]), 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]))


@inline_kernel
def _nearest_angle(angle: float, other: float) -> float:
    """Return the angle [rad] equivalent to `angle` that is nearest to `other`."""
    return other + (angle - other + math.pi) % (2.0 * math.pi) - math.pi


@inline_kernel
def _rotate_yaw(out: Float32, q: Float32, yaw: float) -> None:
    """Write the rotation `q` turned about the vertical by `yaw` [rad] to `out`."""
    c, s = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    w, x, y, z = q[0], q[1], q[2], q[3]
    out[0] = np.float32(c * w - s * y)
    out[1] = np.float32(c * x + s * z)
    out[2] = np.float32(c * y + s * w)
    out[3] = np.float32(c * z - s * x)


@kernel("f8(f4[::1], f4[::1], f8)")
def heading_difference(own: Float32, answer: Float32, previous: float) -> float:
    """Return the turn from the heading of hips `own` to that of `answer` [rad], the one nearest to `previous`.

    A dancer who has to turn about therefore does not change direction midway.
    """
    turn: float = _nearest_angle(_heading(answer) - _heading(own), previous)
    return turn


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], i4[::1], i4[::1], f8[::1], f8[::1], f8[::1], f8[:,::1], f8[:,::1], f4[:,:,::1],"
    " f4[:,:,:,::1], f4[:,::1], i4[::1])"
)
def blend_answers(
    position: Float32,
    rotation: Float32,
    dancers: Int32,
    answer_rows: Int32,
    frames: Float64,
    share: Float64,
    turn: Float64,
    place: Float64,
    answered: Float64,
    root: Float32,
    answer_rotation: Float32,
    offsets: Float32,
    parents: Int32,
) -> None:
    """Blend the answers into the world poses `position` (A, J, 3) and `rotation` (A, J, 4) of the `dancers` (F,).

    `answer_rows` (F,): which of the L answers belongs to each; `root` (L, 3, 3) [m] and `answer_rotation` (L, 3, J, 4),
    world, are poses of the answers now, half a frame and a frame later, `frames` (F,) how many frames have passed.
    `share` (F,) is the weight of the answer; `turn` (F,) [rad] was the turn from the dancer's own heading to the
    answer's at the last tick, when the dancer was at `place` (F, 2) [m] and the answer at `answered` (F, 2). Since then
    the position moves with both.
    """
    now, own = np.empty(4, np.float32), np.empty(4, np.float32)
    for f in range(dancers.shape[0]):
        if not share[f] > 0.0:
            continue
        a, k, w = dancers[f], answer_rows[f], share[f]
        begin, t = 0, 2.0 * frames[f]
        if t >= 1.0:
            begin, t = 1, t - 1.0
        goes = np.empty(3)
        for n in range(3):
            goes[n] = (1.0 - t) * root[k, begin, n] + t * root[k, begin + 1, n]
        x = place[f, 0] + w * (goes[0] - answered[f, 0]) + (1.0 - w) * (position[a, 0, 0] - place[f, 0])
        z = place[f, 1] + w * (goes[2] - answered[f, 1]) + (1.0 - w) * (position[a, 0, 2] - place[f, 1])
        position[a, 0, 0] = np.float32(x)
        position[a, 0, 1] = np.float32((1.0 - w) * position[a, 0, 1] + w * goes[1])
        position[a, 0, 2] = np.float32(z)
        _nlerp(now, answer_rotation[k, begin, 0], answer_rotation[k, begin + 1, 0], t)
        yaw = _nearest_angle(_heading(now) - _heading(rotation[a, 0]), turn[f])
        for j in range(parents.shape[0]):
            _nlerp(now, answer_rotation[k, begin, j], answer_rotation[k, begin + 1, j], t)
            if w < 1.0:
                _rotate_yaw(own, rotation[a, j], w * yaw)
                _rotate_yaw(now, now, (w - 1.0) * yaw)
                _nlerp(rotation[a, j], own, now, w)
            else:
                rotation[a, j] = now
            parent = parents[j]
            if parent < 0:
                continue
            qw, qx, qy, qz = (
                rotation[a, parent, 0],
                rotation[a, parent, 1],
                rotation[a, parent, 2],
                rotation[a, parent, 3],
            )
            vx, vy, vz = offsets[j, 0], offsets[j, 1], offsets[j, 2]
            tx = 2.0 * (qy * vz - qz * vy)
            ty = 2.0 * (qz * vx - qx * vz)
            tz = 2.0 * (qx * vy - qy * vx)
            position[a, j, 0] = np.float32(position[a, parent, 0] + vx + qw * tx + qy * tz - qz * ty)
            position[a, j, 1] = np.float32(position[a, parent, 1] + vy + qw * ty + qz * tx - qx * tz)
            position[a, j, 2] = np.float32(position[a, parent, 2] + vz + qw * tz + qx * ty - qy * tx)


@kernel("void(f8[:,:,::1], i4[::1], f4[:,:,::1])")
def local_to_world(rotation: Float64, parents: Int32, out: Float32) -> None:
    """Convert local rotations (T, J, 4) to world, into `out` (T, J, 4); parents come before their joints."""
    for t in range(rotation.shape[0]):
        for j in range(parents.shape[0]):
            qw, qx, qy, qz = rotation[t, j, 0], rotation[t, j, 1], rotation[t, j, 2], rotation[t, j, 3]
            parent = parents[j]
            if parent >= 0:
                pw, px, py, pz = (
                    float(out[t, parent, 0]),
                    float(out[t, parent, 1]),
                    float(out[t, parent, 2]),
                    float(out[t, parent, 3]),
                )
                qw, qx, qy, qz = (
                    pw * qw - px * qx - py * qy - pz * qz,
                    pw * qx + px * qw + py * qz - pz * qy,
                    pw * qy - px * qz + py * qw + pz * qx,
                    pw * qz + px * qy - py * qx + pz * qw,
                )
            out[t, j, 0], out[t, j, 1] = np.float32(qw), np.float32(qx)
            out[t, j, 2], out[t, j, 3] = np.float32(qy), np.float32(qz)


@kernel("void(f4[:,:,::1], i4[::1], f4[:,:,::1])")
def world_to_local(rotation: Float32, parents: Int32, out: Float32) -> None:
    """Convert world rotations (T, J, 4) to local ones, into `out` (T, J, 4): the inverse of `local_to_world`."""
    for t in range(rotation.shape[0]):
        for j in range(parents.shape[0]):
            parent = parents[j]
            if parent < 0:
                out[t, j] = rotation[t, j]
                continue
            pw, px, py, pz = (
                rotation[t, parent, 0],
                -rotation[t, parent, 1],
                -rotation[t, parent, 2],
                -rotation[t, parent, 3],
            )
            qw, qx, qy, qz = rotation[t, j, 0], rotation[t, j, 1], rotation[t, j, 2], rotation[t, j, 3]
            out[t, j, 0] = pw * qw - px * qx - py * qy - pz * qz
            out[t, j, 1] = pw * qx + px * qw + py * qz - pz * qy
            out[t, j, 2] = pw * qy - px * qz + py * qw + pz * qx
            out[t, j, 3] = pw * qz + px * qy - py * qx + pz * qw
