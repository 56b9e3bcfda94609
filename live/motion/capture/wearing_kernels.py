"""Captured poses worn by dancers: as far as each wears one, the rest being her own."""

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.scalar_kernels import angle_wrap
from live.motion.capture.remembered_kernels import (
    CAUGHT,
    KEY,
    SHARE,
    TURNED,
    WANTED,
    YAW,
    find_stamps,
    rotation_between,
    stood,
)
from live.motion.capture.rotations_kernels import (
    about_vertical,
    heading,
    inverse,
    row_of,
    through_rest,
    times,
    turn_vector,
)

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], i8[::1], f8[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], i8, f8, b1,"
    " f4[:,::1], i4[::1], i4[::1])"
)
def wear(
    position: Float32, rotation: Float32, rows: Int64, asked: Float64,
    root: Float32, turned: Float32, stamp: Float64, count: int, scale: float, mirrored: bool,
    offsets: Float32, parents: Int32, other: Int32,
) -> None:  # fmt: skip
    """Let the dancers `rows` (n,) of `position` (A, J, 3) and `rotation` (A, J, 4), world, wear captured poses.

    `asked` (n, 8): columns as in `live.motion.captured.remembered`. `root` (M + 1, 3) and `turned` (M + 1, J, 4) are
    the poses remembered, the newest at `count` - 1 modulo M, and the one held before a gap at M; `stamp` (M, 2) when
    they came. Between two of them poses are interpolated. Ways are `scale` times as long; `mirrored` exchanges the
    sides, `other` (J,) says the other side.
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
