"""Kernels that blend captured poses into the dancers' own poses, and move their agents and planned paths
accordingly."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.scalar_kernels import angle_wrap
from live.motion.capture.capture_kernels import (
    CAUGHT,
    KEY,
    SHARE,
    TURNED,
    WANTED,
    YAW,
    about_vertical,
    find_stamps,
    heading,
    inverse,
    rotation_between,
    row_of,
    stood,
    through_rest,
    times,
    turn_vector,
)

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]


@kernel(
    "void(f8[:,::1], f8[:,::1], f8[::1], i8[::1], b1[::1], f8[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], i8, f8, b1,"
    " f4[:,::1], f4[:,:,::1])"
)
def find_places(
    there: Float64, way: Float64, away: Float64, rows: Int64, live: Bool, asked: Float64,
    root: Float32, turned: Float32, stamp: Float64, count: int, scale: float, mirrored: bool,
    shown: Float32, legs: Float32,
) -> None:  # fmt: skip
    """Find where the dancers `rows` (n,), captured `live` (n,), are in a tick: `there` (n, 2) [m].

    `way` (n, 2) [m] is the offset of fully captured dancers from the position of their own dance; `away` (n,) [rad] is
    the turn from their own heading to the captured one. While both are mixed, `away` continues from the last tick's
    value, so that the heading never jumps by a whole turn. `shown` (A, 2): position of their own hips; `legs` (A, 9,
    4): rotations. The other parameters are as in `wear`.
    """
    held = stamp.shape[0]
    for n in range(rows.shape[0]):
        a, share, caught = rows[n], asked[n, SHARE], asked[n, CAUGHT]
        i, j, t = find_stamps(stamp, count, int(asked[n, KEY]), asked[n, WANTED])
        x, _, z = stood(root, held, i, j, t, asked, n, scale, mirrored)
        way[n, 0], way[n, 1] = x - shown[a, 0], z - shown[a, 1]
        for c in range(2):
            there[n, c] = shown[a, c] + share * way[n, c]
            if not live[n] or share < 1.0:
                way[n, c] = 0.0
        turn = (
            asked[n, YAW]
            + heading(rotation_between(turned, held, i, j, t, caught, 0, mirrored))
            - heading(row_of(legs[a], 0))
        )
        near = away[n] if 0.0 < share < 1.0 else 0.0
        away[n] = near + angle_wrap(turn - near)


@kernel("void(i8[::1], b1[::1], f8[:,::1], f8[:,::1], f8[:,::1], b1[::1], f4[::1], f8, f8, f8)")
def put_agents(
    rows: Int64, live: Bool, there: Float64, place: Float64, speed: Float64, led: Bool, flat: Float32,
    dt: float, fastest: float, believed: float,
) -> None:  # fmt: skip
    """Move the agents `rows` (n,) that are `live` (n,) to `there` (n, 2) [m]: their columns of `flat` (AgentState)
    change.

    `place` (A, 2) [m] is their position a tick of `dt` [s] ago if they were `led` (A,). `speed` (A, 2) [m/s] is
    smoothed by the share `believed` towards the measured speed, at most `fastest`. Both are updated.
    """
    count = led.shape[0]
    for n in range(rows.shape[0]):
        a = rows[n]
        x, z = 0.0, 0.0
        if led[a]:
            x, z = (there[n, 0] - place[a, 0]) / dt, (there[n, 1] - place[a, 1]) / dt
        fast = max(math.sqrt(x * x + z * z) / fastest, 1.0)
        speed[a, 0] += believed * (x / fast - speed[a, 0])
        speed[a, 1] += believed * (z / fast - speed[a, 1])
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
def take_dance_along(
    rows: Int64, way: Float64, past: Float64, present: Float64, coming: Float64,
    begin: Float64, end: Float64, coming_end: Float64, path: Float32, coming_path: Float32,
    shown: Float32, lock: Float32,
) -> None:  # fmt: skip
    """Move all plans of the dancers `rows` (n,) by `way` (n, 2) [m].

    These are placements (A, 3), ends (A, 2), paths (A, P, 2) and the `shown` (A, 2) positions. Their feet are unlocked:
    `lock` (A, 2, columns).
    """
    for n in range(rows.shape[0]):
        a = rows[n]
        for c in range(2):
            past[a, c] += way[n, c]
            present[a, c] += way[n, c]
            coming[a, c] += way[n, c]
            begin[a, c] += way[n, c]
            end[a, c] += way[n, c]
            coming_end[a, c] += way[n, c]
            shown[a, c] += way[n, c]
            for k in range(path.shape[1]):
                path[a, k, c] += way[n, c]
                coming_path[a, k, c] += way[n, c]
        lock[a, :, :] = 0.0


Int32 = npt.NDArray[np.int32]


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], i8[::1], f8[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], i8, f8, b1,"
    " f4[:,::1], i4[::1], i4[::1])"
)
def wear(
    position: Float32, rotation: Float32, rows: Int64, asked: Float64,
    root: Float32, turned: Float32, stamp: Float64, count: int, scale: float, mirrored: bool,
    offsets: Float32, parents: Int32, other: Int32,
) -> None:  # fmt: skip
    """Blend captured poses into the dancers `rows` (n,) of `position` (A, J, 3) and `rotation` (A, J, 4), world.

    `asked` (n, 8): columns KEY … as in `capture_kernels`. `root` (M + 1, 3) and `turned` (M + 1, J, 4) are the buffered
    poses, the newest at `count` - 1 modulo M, and at M the one held before a gap; `stamp` (M, 2) are their times. Poses
    are interpolated between stamps. Distances are scaled by `scale`; `mirrored` exchanges the sides, `other` (J,) is
    the opposite joint.
    """
    joints, held = parents.shape[0], stamp.shape[0]
    own = np.empty((joints, 4))
    for n in range(rows.shape[0]):
        a, share, caught = rows[n], asked[n, SHARE], asked[n, CAUGHT]
        i, j, t = find_stamps(stamp, count, int(asked[n, KEY]), asked[n, WANTED])
        there = stood(root, held, i, j, t, asked, n, scale, mirrored)
        for c in range(3):
            position[a, 0, c] += share * (there[c] - position[a, 0, c])
        for k in range(joints):
            own[k, 0], own[k, 1], own[k, 2], own[k, 3] = row_of(rotation[a], k)
        for k in range(joints):
            q = rotation_between(turned, held, i, j, t, caught, other[k] if mirrored else k, mirrored)
            if k == 0:
                mine, hers = heading(row_of(own, 0)), heading(q)
                turn = asked[n, TURNED] + angle_wrap(asked[n, YAW] + hers - mine - asked[n, TURNED])
                tilt, tilted = times(about_vertical(-mine), row_of(own, 0)), times(about_vertical(-hers), q)
                q = times(about_vertical(mine + share * turn), through_rest(tilt, tilted, share))
            else:
                p = parents[k]
                q = through_rest(times(inverse(row_of(own, p)), row_of(own, k)), q, share)
                above = row_of(rotation[a], p)
                d = turn_vector(above, offsets[k, 0], offsets[k, 1], offsets[k, 2])
                for c in range(3):
                    position[a, k, c] = position[a, p, c] + d[c]
                q = times(above, q)
            rotation[a, k, 0], rotation[a, k, 1], rotation[a, k, 2], rotation[a, k, 3] = q
