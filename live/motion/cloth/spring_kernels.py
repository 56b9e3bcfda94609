"""Kernel for the springs of characters: Verlet integration as in VRM's specification (VRMC_springBone-1.0).

In each tick the tip of a bone keeps its motion less the drag, is pulled towards its rest direction and by gravity, set
back to the bone's length, and pushed out of colliders. The bone then turns from its rest direction towards its tip. The
order of operations is that of the specification; colliders are capsules that the body carries.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.cloth.spring_rig import (
    DRAG,
    GRAVITY_X,
    GRAVITY_Y,
    GRAVITY_Z,
    HIT_RADIUS,
    MAX_COLLIDERS,
    MAX_SPRINGS,
    STIFFNESS,
)

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]


@inline_kernel
def turn_vector(w: Any, x: Any, y: Any, z: Any, vx: Any, vy: Any, vz: Any) -> Any:
    """Return a vector turned by a unit quaternion."""
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx


@inline_kernel
def times(aw: Any, ax: Any, ay: Any, az: Any, bw: Any, bx: Any, by: Any, bz: Any) -> Any:
    """Return the product of two quaternions: first b, then a."""
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


@inline_kernel
def _quaternion(rotation: Any, n: Any, j: Any) -> Any:
    return (
        np.float64(rotation[n, j, 0]), np.float64(rotation[n, j, 1]), np.float64(rotation[n, j, 2]),
        np.float64(rotation[n, j, 3]),
    )  # fmt: skip


@inline_kernel
def _carry_colliders(
    position: Any, rotation: Any, rest: Any, n: Any, collider_joint: Any, collider: Any, axis: Any
) -> None:
    """Write both ends of the colliders of dancer n in the world into `axis` (C, 6)."""
    for c in range(collider_joint.shape[0]):
        j = collider_joint[c]
        w, x, y, z = _quaternion(rotation, n, j)
        for end in range(2):
            px, py, pz = turn_vector(
                w, x, y, z, np.float64(collider[c, 3 * end]) - rest[j, 0],
                np.float64(collider[c, 3 * end + 1]) - rest[j, 1], np.float64(collider[c, 3 * end + 2]) - rest[j, 2],
            )  # fmt: skip
            axis[c, 3 * end] = position[n, j, 0] + px
            axis[c, 3 * end + 1] = position[n, j, 1] + py
            axis[c, 3 * end + 2] = position[n, j, 2] + pz


@inline_kernel
def _at_length(ux: Any, uy: Any, uz: Any, rx: Any, ry: Any, rz: Any, length: Any) -> Any:
    """Return a vector at another length; `length` along (rx, ry, rz) if it has none, or is not finite."""
    size = math.sqrt(ux * ux + uy * uy + uz * uz)
    if not (1e-9 < size < 1e9):
        return rx * length, ry * length, rz * length
    return ux / size * length, uy / size * length, uz / size * length


@inline_kernel
def _way_out(ux: Any, uy: Any, uz: Any, axis: Any, c: Any) -> Any:
    """Return the vector from the nearest point of a collider's axis to a tip, and its squared length."""
    ex, ey, ez = axis[c, 3] - axis[c, 0], axis[c, 4] - axis[c, 1], axis[c, 5] - axis[c, 2]
    dx, dy, dz = ux - axis[c, 0], uy - axis[c, 1], uz - axis[c, 2]
    along = ex * ex + ey * ey + ez * ez
    if along > 1e-12:
        part = min(max((dx * ex + dy * ey + dz * ez) / along, 0.0), 1.0)
        dx, dy, dz = dx - part * ex, dy - part * ey, dz - part * ez
    return dx, dy, dz, dx * dx + dy * dy + dz * dz


@inline_kernel
def _shortest(rx: Any, ry: Any, rz: Any, ux: Any, uy: Any, uz: Any) -> Any:
    """Return the shortest rotation from one direction to another."""
    w = 1.0 + rx * ux + ry * uy + rz * uz
    x, y, z = ry * uz - rz * uy, rz * ux - rx * uz, rx * uy - ry * ux
    if w < 1e-6:  # opposite: about any axis across
        w = 0.0
        x, y, z = (0.0, -rz, ry) if abs(rx) < 0.9 else (rz, 0.0, -rx)
    size = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return w * size, x * size, y * size, z * size


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], f4[:,::1], i4[::1], i4[::1], i4[::1], f4[:,::1], f4[:,::1], f4[:,::1], i8[::1], "
    "i4[::1], f4[:,::1], u1[::1], f8, f4[:,:,::1], f4[:,:,::1], f4[:,:,::1])"
)
def swing(
    position: Float32,
    rotation: Float32,
    rest: Float32,
    parent: Int32,
    joint: Int32,
    centre: Int32,
    head: Float32,
    tail: Float32,
    setting: Float32,
    hits: Int64,
    collider_joint: Int32,
    collider: Float32,
    start: Any,
    dt: float,
    now: Float32,
    before: Float32,
    out: Float32,
) -> None:
    """Advance the springs of n dancers by a tick of `dt` [s].

    position (n, J, 3), rotation (n, J, 4): joints in the world; rest (J, 3): joints in the rest pose; parent to
    collider: see `SpringRig`; start (n,): 1 where the springs begin at rest; now, before (n, B, 3): tips in the world,
    or in the space of the bone's centre, at the last tick and the one before [m], updated; out (n, B, 4): rotations of
    the bones from their rest pose, relative to `joint`.
    """
    turn = np.empty((MAX_SPRINGS, 4), np.float64)
    place = np.empty((MAX_SPRINGS, 3), np.float64)
    axis = np.empty((MAX_COLLIDERS, 6), np.float64)
    for n in range(position.shape[0]):
        _carry_colliders(position, rotation, rest, n, collider_joint, collider, axis)
        for b in range(parent.shape[0]):
            # the bone above: its rotation and origin, in the world and at rest
            j, p = joint[b], parent[b]
            jw, jx, jy, jz = _quaternion(rotation, n, j)
            if p < 0:
                pw, px, py, pz = jw, jx, jy, jz
                ox, oy, oz = np.float64(position[n, j, 0]), np.float64(position[n, j, 1]), np.float64(position[n, j, 2])
                fx, fy, fz = np.float64(rest[j, 0]), np.float64(rest[j, 1]), np.float64(rest[j, 2])
            else:
                pw, px, py, pz = turn[p, 0], turn[p, 1], turn[p, 2], turn[p, 3]
                ox, oy, oz = place[p, 0], place[p, 1], place[p, 2]
                fx, fy, fz = np.float64(head[p, 0]), np.float64(head[p, 1]), np.float64(head[p, 2])
            mx, my, mz = turn_vector(pw, px, py, pz, head[b, 0] - fx, head[b, 1] - fy, head[b, 2] - fz)
            hx, hy, hz = ox + mx, oy + my, oz + mz
            ax, ay, az = np.float64(tail[b, 0]), np.float64(tail[b, 1]), np.float64(tail[b, 2])
            ax, ay, az = ax - head[b, 0], ay - head[b, 1], az - head[b, 2]
            length = math.sqrt(ax * ax + ay * ay + az * az)
            rx, ry, rz = turn_vector(pw, px, py, pz, ax / length, ay / length, az / length)
            # the last two tips, in the world
            k = centre[b]
            kw, kx, ky, kz, cx, cy, cz = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            if k >= 0:
                kw, kx, ky, kz = _quaternion(rotation, n, k)
                cx, cy, cz = np.float64(position[n, k, 0]), np.float64(position[n, k, 1]), np.float64(position[n, k, 2])
            if start[n]:
                tx, ty, tz = hx + rx * length, hy + ry * length, hz + rz * length
                qx, qy, qz = tx, ty, tz
            else:
                tx, ty, tz = turn_vector(
                    kw, kx, ky, kz, np.float64(now[n, b, 0]), np.float64(now[n, b, 1]), np.float64(now[n, b, 2])
                )
                qx, qy, qz = turn_vector(
                    kw,
                    kx,
                    ky,
                    kz,
                    np.float64(before[n, b, 0]),
                    np.float64(before[n, b, 1]),
                    np.float64(before[n, b, 2]),
                )
                tx, ty, tz, qx, qy, qz = tx + cx, ty + cy, tz + cz, qx + cx, qy + cy, qz + cz
            # inertia, stiffness and gravity, at the bone's length
            left = 1.0 - setting[b, DRAG]
            pull = dt * setting[b, STIFFNESS]
            ux = tx + (tx - qx) * left + pull * rx + dt * setting[b, GRAVITY_X] - hx
            uy = ty + (ty - qy) * left + pull * ry + dt * setting[b, GRAVITY_Y] - hy
            uz = tz + (tz - qz) * left + pull * rz + dt * setting[b, GRAVITY_Z] - hz
            ux, uy, uz = _at_length(ux, uy, uz, rx, ry, rz, length)
            for c in range(collider_joint.shape[0]):
                if not (hits[b] >> c) & 1:
                    continue
                gap = np.float64(collider[c, 6]) + setting[b, HIT_RADIUS]
                dx, dy, dz, squared = _way_out(hx + ux, hy + uy, hz + uz, axis, c)
                if 1e-18 < squared < gap * gap:
                    push = gap / math.sqrt(squared) - 1.0
                    ux, uy, uz = _at_length(ux + dx * push, uy + dy * push, uz + dz * push, rx, ry, rz, length)
            # the tips of this tick, in the space of the centre
            vx, vy, vz = turn_vector(kw, -kx, -ky, -kz, tx - cx, ty - cy, tz - cz)
            before[n, b, 0], before[n, b, 1], before[n, b, 2] = vx, vy, vz
            vx, vy, vz = turn_vector(kw, -kx, -ky, -kz, hx + ux - cx, hy + uy - cy, hz + uz - cz)
            now[n, b, 0], now[n, b, 1], now[n, b, 2] = vx, vy, vz
            w, x, y, z = _shortest(rx, ry, rz, ux / length, uy / length, uz / length)
            w, x, y, z = times(w, x, y, z, pw, px, py, pz)
            turn[b, 0], turn[b, 1], turn[b, 2], turn[b, 3] = w, x, y, z
            place[b, 0], place[b, 1], place[b, 2] = hx, hy, hz
            w, x, y, z = times(jw, -jx, -jy, -jz, w, x, y, z)
            out[n, b, 0], out[n, b, 1], out[n, b, 2], out[n, b, 3] = w, x, y, z


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[::1], f8, f4[:,:,::1])")
def mix_springs(before: Float32, now: Float32, level: Float32, share: float, out: Float32) -> None:
    """Compute rotations between two ticks: before, now (A, B, 4); level (A,): 0 at rest, 1 as they are; share of the
    second tick, 0 to 1; out (A, B, 4), normalized linear interpolation."""
    for a in range(now.shape[0]):
        for b in range(now.shape[1]):
            near = 0.0
            for c in range(4):
                near += before[a, b, c] * now[a, b, c]
            other = share if near >= 0.0 else -share
            w = before[a, b, 0] * (1.0 - share) + now[a, b, 0] * other
            x = before[a, b, 1] * (1.0 - share) + now[a, b, 1] * other
            y = before[a, b, 2] * (1.0 - share) + now[a, b, 2] * other
            z = before[a, b, 3] * (1.0 - share) + now[a, b, 3] * other
            sign = level[a] if w >= 0.0 else -level[a]
            w, x, y, z = w * sign + (1.0 - level[a]), x * sign, y * sign, z * sign
            size = 1.0 / math.sqrt(max(w * w + x * x + y * y + z * z, 1e-12))
            out[a, b, 0], out[a, b, 1], out[a, b, 2], out[a, b, 3] = w * size, x * size, y * size, z * size
