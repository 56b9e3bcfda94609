"""Where captured poses lead those who wear them: places in a tick, their agents, and what is planned of them."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.scalar_kernels import angle_wrap
from live.motion.capture.remembered_kernels import (
    CAUGHT,
    KEY,
    SHARE,
    WANTED,
    YAW,
    find_stamps,
    rotation_between,
    stood,
)
from live.motion.capture.rotations_kernels import heading, row_of

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
    """Where the dancers `rows` (n,), who are `live` (n,), are seen in a tick: `there` (n, 2) [m]; how far those who are
    wholly captured have gone from where their own dance has them, `way` (n, 2) [m]; and the turn from their own heading
    to the captured one, `away` (n,) [rad]: where both are mixed it goes on from the last tick's, so that nobody swings
    round. `shown` (A, 2): where their own hips are, `legs` (A, 9, 4) how turned; the rest as in
    `live.motion.captured.wearing`.
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
    """The agents `rows` (n,) who are `live` (n,) stand `there` (n, 2) [m]: their columns of `flat` (AgentState) change.

    `place` (A, 2) [m] is where they were a tick of `dt` [s] ago if they were `led` (A,), `speed` (A, 2) [m/s] is
    smoothed by the share `believed` of what that makes, `fastest` at most; both are brought up to date.
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
    """All that is planned of the dancers `rows` (n,) lies elsewhere by `way` (n, 2) [m]: placements (A, 3), ends
    (A, 2), paths (A, P, 2), where they are `shown` (A, 2); and no foot of theirs is held, `lock` (A, 2, columns)."""
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
