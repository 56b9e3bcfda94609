"""Kernel for the own joints of characters: dual quaternions of fingers, eyes, jaw and bones that swing."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.motion.cloth.spring_kernels import times, turn_vector

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

MAX_OWN = 256


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], b1[::1], f4[:,::1], f4[:,::1], f4[:,:,::1], i4[::1], i4[::1], i4[::1], i4[::1], "
    "i4[::1], f4[:,::1], i4[:,::1], f4[:,:,::1], i4[::1], i4[::1], f4[::1], f4[:,:,::1])"
)
def own_poses(
    position: Float32,
    rotation: Float32,
    present: Bool,
    rest: Float32,
    expression: Float32,
    spring: Float32,
    slot: Int32,
    character: Int32,
    first: Int32,
    parent: Int32,
    joint: Int32,
    place: Float32,
    column: Int32,
    turn: Float32,
    bone: Int32,
    channel: Int32,
    factor: Float32,
    out: Float32,
) -> None:
    """Compute the texels of all dancers who are characters.

    position (A, J, 3), rotation (A, J, 4), present (A,): as in a `StageView`; rest (J, 3); expression (A, X); spring
    (S, B, 4): rotations of swinging bones relative to their joint; slot (A,): row of each dancer, -1: none; character
    (A or more,): -1: none; first (C + 1,): first own joint of each character in parent, joint (N,), place (N, 3),
    column (N, 2), turn (N, 2, 3), bone (N,), see `OwnJoints`; channel, factor (K,): columns and factors of the blend
    shapes' weights; out (A or more, W, 4): two texels (real and dual part, x y z w) for each own joint, and at the end
    K / 4 texels of weights.
    """
    world = np.empty((MAX_OWN, 7), np.float64)
    weights = out.shape[1] - (channel.shape[0] + 3) // 4
    for a in range(position.shape[0]):
        c = character[a]
        if c < 0 or not present[a]:
            continue
        for k in range(channel.shape[0]):
            share = min(max(expression[a, channel[k]] * factor[k], np.float32(0.0)), np.float32(1.0))
            out[a, weights + k // 4, k % 4] = share
        for m in range(first[c], first[c + 1]):
            own = m - first[c]
            j, p = joint[m], parent[m]
            jw, jx, jy, jz = (
                np.float64(rotation[a, j, 0]), np.float64(rotation[a, j, 1]), np.float64(rotation[a, j, 2]),
                np.float64(rotation[a, j, 3]),
            )  # fmt: skip
            if p < 0:
                pw, px, py, pz = jw, jx, jy, jz
                ox, oy, oz = np.float64(position[a, j, 0]), np.float64(position[a, j, 1]), np.float64(position[a, j, 2])
                fx, fy, fz = np.float64(rest[j, 0]), np.float64(rest[j, 1]), np.float64(rest[j, 2])
            else:
                pw, px, py, pz = world[p, 0], world[p, 1], world[p, 2], world[p, 3]
                ox, oy, oz = world[p, 4], world[p, 5], world[p, 6]
                q = first[c] + p
                fx, fy, fz = np.float64(place[q, 0]), np.float64(place[q, 1]), np.float64(place[q, 2])
            rx, ry, rz = np.float64(place[m, 0]), np.float64(place[m, 1]), np.float64(place[m, 2])
            mx, my, mz = turn_vector(pw, px, py, pz, rx - fx, ry - fy, rz - fz)
            ox, oy, oz = ox + mx, oy + my, oz + mz
            b = bone[m]
            row = slot[a]
            if b >= 0 and row >= 0 and row < spring.shape[0] and b < spring.shape[1]:
                w, x, y, z = times(
                    jw, jx, jy, jz, np.float64(spring[row, b, 0]), np.float64(spring[row, b, 1]),
                    np.float64(spring[row, b, 2]), np.float64(spring[row, b, 3]),
                )  # fmt: skip
            else:
                one, two = expression[a, column[m, 0]], expression[a, column[m, 1]]
                vx: Any = np.float64(turn[m, 0, 0] * one + turn[m, 1, 0] * two)
                vy: Any = np.float64(turn[m, 0, 1] * one + turn[m, 1, 1] * two)
                vz: Any = np.float64(turn[m, 0, 2] * one + turn[m, 1, 2] * two)
                angle = math.sqrt(vx * vx + vy * vy + vz * vz)
                by = math.sin(0.5 * angle) / angle if angle > 1e-6 else 0.5
                w, x, y, z = times(pw, px, py, pz, math.cos(0.5 * angle), vx * by, vy * by, vz * by)
            world[own, 0], world[own, 1], world[own, 2], world[own, 3] = w, x, y, z
            world[own, 4], world[own, 5], world[own, 6] = ox, oy, oz
            mx, my, mz = turn_vector(w, x, y, z, rx, ry, rz)
            tx, ty, tz = ox - mx, oy - my, oz - mz
            at = 2 * own
            out[a, at, 0], out[a, at, 1], out[a, at, 2], out[a, at, 3] = x, y, z, w
            out[a, at + 1, 0] = 0.5 * (tx * w + ty * z - tz * y)
            out[a, at + 1, 1] = 0.5 * (ty * w + tz * x - tx * z)
            out[a, at + 1, 2] = 0.5 * (tz * w + tx * y - ty * x)
            out[a, at + 1, 3] = -0.5 * (tx * x + ty * y + tz * z)
