"""Kernel that keeps tubes of cloth, as skirts and sleeves, from passing through themselves.

Contact of cloth with cloth costs more than all the rest. A tube has a simpler law: seen from the middle of a row, its
particles stay in their order around it, so no fold passes another one and none is wound up when a turn ends. Each
sector, between the middle and two neighbours, keeps a signed area not below a small limit: a constraint as of volumes
in Müller et al., *Position Based Dynamics* (2007), one dimension lower. Seen from the line of a limb instead, the same
law keeps a sleeve around its arm, which contact alone does not when an arm is faster than its own width in a tick.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.cloth.limb_kernels import AXES, LANES, LENGTH, MIDDLE

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

RING_FIRST, RING_EVEN, RING_ODD, RING_LIMB = range(4)
"""Columns of `rings`: the first particle of a row, the numbers of its even and odd columns, and the limb that it stays
around, or -1."""
PER_AREA, LEAST_AREA = range(2)
"""Columns of `areas`: inverse of twice the area within a row that is a circle [1/m2], and the least of twice the area
of a sector [m2]."""
_ZERO: Any = np.float32(0.0)
_ONE: Any = np.float32(1.0)
_TINY: Any = np.float32(1e-12)


@inline_kernel
def _open_sectors(
    x: Float32, y: Float32, z: Float32, first: int, second: int, count: int, middle: Float32, axis: Float32, least: Any
) -> None:
    """Project the areas of `count` sectors, from the particles `first` on to those from `second` on."""
    for c in range(count):
        a, b = (first + c) * LANES, (second + c) * LANES
        ax, ay, az = x[a : a + LANES], y[a : a + LANES], z[a : a + LANES]
        bx, by, bz = x[b : b + LANES], y[b : b + LANES], z[b : b + LANES]
        for i in range(LANES):
            px, py, pz = ax[i] - middle[0, i], ay[i] - middle[1, i], az[i] - middle[2, i]
            qx, qy, qz = bx[i] - middle[0, i], by[i] - middle[1, i], bz[i] - middle[2, i]
            nx, ny, nz = axis[0, i], axis[1, i], axis[2, i]
            # gradients of the area: q × n for the first particle, n × p for the second
            gx, gy, gz = qy * nz - qz * ny, qz * nx - qx * nz, qx * ny - qy * nx
            hx, hy, hz = ny * pz - nz * py, nz * px - nx * pz, nx * py - ny * px
            lacks = max(least - (px * gx + py * gy + pz * gz), _ZERO)
            lacks /= gx * gx + gy * gy + gz * gz + (hx * hx + hy * hy + hz * hz) + _TINY
            ax[i] += lacks * gx
            ay[i] += lacks * gy
            az[i] += lacks * gz
            bx[i] += lacks * hx
            by[i] += lacks * hy
            bz[i] += lacks * hz


@inline_kernel
def _look_along(limbs: Float32, k: int, middle: Float32, axis: Float32) -> None:
    """Move the middle of a row to the next place on the line of limb k, and make this line its axis."""
    for i in range(LANES):
        ax, ay, az = limbs[AXES + 3, k, i], limbs[AXES + 4, k, i], limbs[AXES + 5, k, i]
        sx, sy, sz = limbs[MIDDLE, k, i], limbs[MIDDLE + 1, k, i], limbs[MIDDLE + 2, k, i]
        s = (middle[0, i] - sx) * ax + (middle[1, i] - sy) * ay + (middle[2, i] - sz) * az
        s = min(max(s, _ZERO), limbs[LENGTH, k, i])
        middle[0, i], middle[1, i], middle[2, i] = sx + s * ax, sy + s * ay, sz + s * az
        axis[0, i], axis[1, i], axis[2, i] = ax, ay, az


@kernel("void(f4[:,::1], i4[:,::1], f4[:,::1], f4[:,:,::1], i8)")
def keep_order(places: Float32, rings: Int32, areas: Float32, limbs: Float32, fixed: int) -> None:
    """Keep the particles of rows in their order around the rows' middles; places (3, P LANES).

    rings (N, 4) and areas (N, 2), from the body on; the first `fixed` rows do not move. The axis of a row is that of
    the row before it and its own, as far as it has one: a row that is crumpled has none. limbs (LIMB_ROWS, K, LANES).
    """
    x, y, z = places[0], places[1], places[2]
    middle, axis = np.empty((3, LANES), np.float32), np.zeros((3, LANES), np.float32)
    for r in range(rings.shape[0]):
        first, even, odd = int(rings[r, RING_FIRST]), int(rings[r, RING_EVEN]), int(rings[r, RING_ODD])
        per, least = areas[r, PER_AREA], areas[r, LEAST_AREA]
        share = _ONE / np.float32(even + odd)
        for k in range(3):
            row, to = places[k], middle[k]
            for i in range(LANES):
                to[i] = _ZERO
            for c in range(first, first + even + odd):
                for i in range(LANES):
                    to[i] += row[c * LANES + i]
            for i in range(LANES):
                to[i] *= share
        for c in range(even):
            a, b = (first + c) * LANES, (first + even + c) * LANES
            n = (first + (c + 1) % even) * LANES  # the next even one
            ax, ay, az = x[a : a + LANES], y[a : a + LANES], z[a : a + LANES]
            bx, by, bz = x[b : b + LANES], y[b : b + LANES], z[b : b + LANES]
            cx, cy, cz = x[n : n + LANES], y[n : n + LANES], z[n : n + LANES]
            for i in range(LANES):  # a × b + b × c = (a - c) × b, twice the area of two sectors
                px, py, pz = ax[i] - cx[i], ay[i] - cy[i], az[i] - cz[i]
                qx, qy, qz = bx[i] - middle[0, i], by[i] - middle[1, i], bz[i] - middle[2, i]
                axis[0, i] += per * (py * qz - pz * qy)
                axis[1, i] += per * (pz * qx - px * qz)
                axis[2, i] += per * (px * qy - py * qx)
        for i in range(LANES):
            size = axis[0, i] * axis[0, i] + axis[1, i] * axis[1, i] + axis[2, i] * axis[2, i]
            size = _ONE / math.sqrt(size + _TINY)
            axis[0, i], axis[1, i], axis[2, i] = axis[0, i] * size, axis[1, i] * size, axis[2, i] * size
        if r < fixed:
            continue
        if rings[r, RING_LIMB] >= 0:
            _look_along(limbs, int(rings[r, RING_LIMB]), middle, axis)
        _open_sectors(x, y, z, first, first + even, odd, middle, axis, least)
        _open_sectors(x, y, z, first + even, first + 1, odd - 1, middle, axis, least)
        _open_sectors(x, y, z, first + even + odd - 1, first, 1, middle, axis, least)
