"""Kernels of the air around garments, and of bodies that fall faster than anything does.

Air resists a sheet that moves across its own surface, and hardly one that moves along it (Bridson, Marino and Fedkiw,
*Simulation of Clothing with Folds and Wrinkles*, 2003). So a skirt that falls with its wearer hangs, and does not open
as an umbrella.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.cloth.limb_kernels import LANES
from live.motion.cloth.order_kernels import RING_EVEN, RING_FIRST, RING_ODD

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]
Uint8 = npt.NDArray[np.uint8]

_ZERO: Any = np.float32(0.0)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_TINY: Any = np.float32(1e-12)
_STEEPEST: Any = np.float32(60.0)  # no more than a body does without a jump in its path [m/s2]


@inline_kernel
def _brake(
    x: Float32, v: Float32, own: int, left: int, right: int, above: int, below: int, wind: Float32, facing: Any
) -> None:
    """Brake the particles at `own` across the surface that the four particles around them span."""
    for i in range(LANES):
        ax, ay, az = (
            x[0, right + i] - x[0, left + i],
            x[1, right + i] - x[1, left + i],
            x[2, right + i] - x[2, left + i],
        )
        bx, by, bz = (
            x[0, below + i] - x[0, above + i],
            x[1, below + i] - x[1, above + i],
            x[2, below + i] - x[2, above + i],
        )
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        size = _ONE / (nx * nx + ny * ny + nz * nz + _TINY)
        vx, vy, vz = v[0, own + i] - wind[0], v[1, own + i] - wind[1], v[2, own + i] - wind[2]
        through = (vx * nx + vy * ny + vz * nz) * size  # times the length of the normal: the speed across the surface
        lost = facing * abs(through) * math.sqrt(nx * nx + ny * ny + nz * nz)
        lost = through * lost / (_ONE + lost)
        v[0, own + i] -= lost * nx
        v[1, own + i] -= lost * ny
        v[2, own + i] -= lost * nz


@kernel("void(f4[:,::1], f4[:,::1], i4[:,::1], f4[::1], f4)")
def face_air(x: Float32, v: Float32, rings: Int32, wind: Float32, facing: float) -> None:
    """Brake the rows of a tube of cloth but the first one by the air that they face; x, v (3, P LANES).

    rings (N, 3) as in `order_kernels.keep_order`; wind (3,) [m/s]. `facing`: share of the speed across its surface that
    cloth loses in this time at 1 m/s; it grows with the speed. Implicit, so that any share is stable.
    """
    last = rings.shape[0] - 1
    for r in range(1, last + 1):
        first, even, odd = int(rings[r, RING_FIRST]), int(rings[r, RING_EVEN]), int(rings[r, RING_ODD])
        up, down = int(rings[r - 1, RING_FIRST]) - first, int(rings[min(r + 1, last), RING_FIRST]) - first
        for c in range(even):
            own = first + c
            left, right = first + even + (c + odd - 1) % odd, first + even + c
            _brake(
                x, v, own * LANES, left * LANES, right * LANES, (own + up) * LANES, (own + down) * LANES, wind, facing
            )
        for c in range(odd):
            own = first + even + c
            left, right = first + c, first + (c + 1) % even
            _brake(
                x, v, own * LANES, left * LANES, right * LANES, (own + up) * LANES, (own + down) * LANES, wind, facing
            )


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], f4[:,::1], u1[::1], f4, f4, f4)")
def follow_falls(
    v: Float32, now: Float32, last: Float32, before: Float32, fresh: Uint8, gravity: float, share: float, tick: float
) -> None:
    """Take garments along with a body that falls faster than free fall, as in steps that music makes faster.

    v (3, P, LANES); now and last (7, J, LANES): the joints now and at the last tick, the first of which carries them;
    before (7, LANES): this one a tick earlier; fresh (LANES,): not 0 where there is no such past. `share`: of what its
    acceleration exceeds gravity by.
    """
    more = np.empty(LANES, np.float32)
    for i in range(LANES):
        rise = (now[1, 0, i] - _TWO * last[1, 0, i] + before[1, i]) / (tick * tick)
        more[i] = share * tick * max(min(rise + gravity, _ZERO), -_STEEPEST) if fresh[i] == 0 else _ZERO
    for p in range(v.shape[1]):
        for i in range(LANES):
            v[1, p, i] += more[i]
