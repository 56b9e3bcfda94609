"""Kernels that blend captured poses into the dancers' own poses, and move their agents and planned paths
accordingly."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.scalar_kernels import angle_wrap
from live.motion.capture.capture_kernels import (
    BLEND,
    GAP_BLEND,
    LAST_TURN,
    STAMP,
    STAMP_COLUMN,
    YAW,
    find_stamps,
    heading,
    hips_on_stage,
    interpolate_from_rest,
    interpolate_rotation,
    inverse,
    rotate_vector,
    rotation_row,
    yaw_rotation,
)
from live.motion.pose.hand_hold_kernels import multiply

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]


@kernel(
    "void(f8[:,::1], f8[:,::1], f8[::1], i8[::1], b1[::1], f8[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], i8, f8, b1,"
    " f4[:,::1], f4[:,:,::1])"
)
def find_positions(
    position: Float64, offset: Float64, turn_offset: Float64, rows: Int64, live: Bool, request: Float64,
    root: Float32, turned: Float32, stamp: Float64, count: int, scale: float, mirrored: bool,
    shown: Float32, legs: Float32,
) -> None:  # fmt: skip
    """Find where the dancers `rows` (n,), captured `live` (n,), are in a tick: `position` (n, 2) [m].

    `offset` (n, 2) [m] is that of fully captured dancers from the position of their own dance; `turn_offset` (n,)
    [rad] is the turn from their own heading to the captured one. While both are mixed, `turn_offset` continues from the
    last tick's value, so that the heading never jumps by a whole turn. `shown` (A, 2): position of their own hips;
    `legs` (A, 9, 4): rotations. The other parameters are as in `blend_captured`.
    """
    held = stamp.shape[0]
    for n in range(rows.shape[0]):
        a, share, caught = rows[n], request[n, BLEND], request[n, GAP_BLEND]
        i, j, t = find_stamps(stamp, count, int(request[n, STAMP_COLUMN]), request[n, STAMP])
        x, _, z = hips_on_stage(root, held, i, j, t, request, n, scale, mirrored)
        offset[n, 0], offset[n, 1] = x - shown[a, 0], z - shown[a, 1]
        for c in range(2):
            position[n, c] = shown[a, c] + share * offset[n, c]
            if not live[n] or share < 1.0:
                offset[n, c] = 0.0
        turn = (
            request[n, YAW]
            + heading(interpolate_rotation(turned, held, i, j, t, caught, 0, mirrored))
            - heading(rotation_row(legs[a], 0))
        )
        near = turn_offset[n] if 0.0 < share < 1.0 else 0.0
        turn_offset[n] = near + angle_wrap(turn - near)


@kernel("void(i8[::1], b1[::1], f8[:,::1], f8[:,::1], f8[:,::1], b1[::1], f4[::1], f8, f8, f8)")
def move_agents(
    rows: Int64, live: Bool, there: Float64, place: Float64, speed: Float64, led: Bool, flat: Float32,
    dt: float, max_speed: float, smoothing: float,
) -> None:  # fmt: skip
    """Move the agents `rows` (n,) that are `live` (n,) to `there` (n, 2) [m]: their columns of `flat` (AgentState)
    change.

    `place` (A, 2) [m] is their position a tick of `dt` [s] ago if they were `led` (A,). `speed` (A, 2) [m/s] is
    smoothed by the share `smoothing` towards the measured speed, at most `max_speed`. Both are updated.
    """
    count = led.shape[0]
    for n in range(rows.shape[0]):
        a = rows[n]
        x, z = 0.0, 0.0
        if led[a]:
            x, z = (there[n, 0] - place[a, 0]) / dt, (there[n, 1] - place[a, 1]) / dt
        fast = max(math.sqrt(x * x + z * z) / max_speed, 1.0)
        speed[a, 0] += smoothing * (x / fast - speed[a, 0])
        speed[a, 1] += smoothing * (z / fast - speed[a, 1])
        place[a, 0], place[a, 1] = there[n, 0], there[n, 1]
        if live[n]:
            for c in range(2):
                flat[2 * a + c] = there[n, c]
                flat[2 * count + 2 * a + c] = speed[a, c]
                flat[4 * count + 2 * a + c] = 0.0
            flat[6 * count + a] = 0.0


@kernel(
    "void(i8[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f4[:,:,::1],"
    " f4[:,:,::1], f4[:,::1], f4[:,:,::1])"
)
def translate_plans(
    rows: Int64, offset: Float64, past: Float64, present: Float64, coming: Float64,
    begin: Float64, end: Float64, coming_end: Float64, path: Float32, coming_path: Float32,
    shown: Float32, lock: Float32,
) -> None:  # fmt: skip
    """Move all plans of the dancers `rows` (n,) by `offset` (n, 2) [m].

    These are placements (A, 3), ends (A, 2), paths (A, P, 2) and the `shown` (A, 2) positions. Their feet are unlocked:
    `lock` (A, 2, columns).
    """
    for n in range(rows.shape[0]):
        a = rows[n]
        for c in range(2):
            past[a, c] += offset[n, c]
            present[a, c] += offset[n, c]
            coming[a, c] += offset[n, c]
            begin[a, c] += offset[n, c]
            end[a, c] += offset[n, c]
            coming_end[a, c] += offset[n, c]
            shown[a, c] += offset[n, c]
            for k in range(path.shape[1]):
                path[a, k, c] += offset[n, c]
                coming_path[a, k, c] += offset[n, c]
        lock[a, :, :] = 0.0


Int32 = npt.NDArray[np.int32]


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], i8[::1], f8[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], i8, f8, b1,"
    " f4[:,::1], i4[::1], i4[::1])"
)
def blend_captured(
    position: Float32, rotation: Float32, rows: Int64, request: Float64,
    root: Float32, turned: Float32, stamp: Float64, count: int, scale: float, mirrored: bool,
    offsets: Float32, parents: Int32, other: Int32,
) -> None:  # fmt: skip
    """Blend captured poses into the dancers `rows` (n,) of `position` (A, J, 3) and `rotation` (A, J, 4), world.

    `request` (n, 8): columns KEY … as in `capture_kernels`. `root` (M + 1, 3) and `turned` (M + 1, J, 4) are the
    buffered poses, the newest at `count` - 1 modulo M, and at M the one held before a gap; `stamp` (M, 2) are their
    times. Poses are interpolated between stamps. Distances are scaled by `scale`; `mirrored` exchanges the sides,
    `other` (J,) is the opposite joint.
    """
    joints, held = parents.shape[0], stamp.shape[0]
    own = np.empty((joints, 4))
    for n in range(rows.shape[0]):
        a, share, caught = rows[n], request[n, BLEND], request[n, GAP_BLEND]
        i, j, t = find_stamps(stamp, count, int(request[n, STAMP_COLUMN]), request[n, STAMP])
        there = hips_on_stage(root, held, i, j, t, request, n, scale, mirrored)
        for c in range(3):
            position[a, 0, c] += share * (there[c] - position[a, 0, c])
        for k in range(joints):
            own[k, 0], own[k, 1], own[k, 2], own[k, 3] = rotation_row(rotation[a], k)
        for k in range(joints):
            q = interpolate_rotation(turned, held, i, j, t, caught, other[k] if mirrored else k, mirrored)
            if k == 0:
                mine, hers = heading(rotation_row(own, 0)), heading(q)
                turn = request[n, LAST_TURN] + angle_wrap(request[n, YAW] + hers - mine - request[n, LAST_TURN])
                tilt, tilted = multiply(yaw_rotation(-mine), rotation_row(own, 0)), multiply(yaw_rotation(-hers), q)
                q = multiply(yaw_rotation(mine + share * turn), interpolate_from_rest(tilt, tilted, share))
            else:
                p = parents[k]
                q = interpolate_from_rest(multiply(inverse(rotation_row(own, p)), rotation_row(own, k)), q, share)
                above = rotation_row(rotation[a], p)
                d = rotate_vector(above, offsets[k, 0], offsets[k, 1], offsets[k, 2])
                for c in range(3):
                    position[a, k, c] = position[a, p, c] + d[c]
                q = multiply(above, q)
            rotation[a, k, 0], rotation[a, k, 1], rotation[a, k, 2], rotation[a, k, 3] = q
