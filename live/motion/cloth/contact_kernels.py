"""Kernels of contact: rows of particles, and middles between neighbours, keep out of the limbs of a body.

Positions of a block are (3, P, LANES), see `limb_kernels`. A limb is an ellipse across and round at its ends.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.cloth.limb_kernels import (
    AXES,
    BACKS,
    BOUND,
    CAPS,
    FRONTS,
    LANES,
    LENGTH,
    LIMB_ROWS,
    MIDDLE,
    PER_LENGTH,
    SIDES,
)

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

COLUMNS = 32
"""Most particles in a row of a garment."""
WIDTH = COLUMNS * LANES
CONTACT_FIRST, CONTACT_COUNT, CONTACT_LIMB, CONTACT_MIDDLES = range(4)
"""Columns of `contacts`: the particles of a row, their number, the limb, and what keeps out of it: …"""
PARTICLES, OPEN, CLOSED = range(3)
"""… the particles, the middles between neighbours, or these and the one between the last and the first."""
_ZERO: Any = np.float32(0.0)
_HALF: Any = np.float32(0.5)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_TINY: Any = np.float32(1e-12)
_NEAR_ROWS = (MIDDLE, MIDDLE + 1, MIDDLE + 2, AXES + 3, AXES + 4, AXES + 5, LENGTH, BOUND)
"""Rows of a limb that tell whether anything is near."""
_OTHER_ROWS = tuple(row for row in range(LIMB_ROWS) if row not in _NEAR_ROWS)


@inline_kernel
def _tile(tile: Float32, limbs: Float32, k: int, columns: int, rows: Any) -> None:
    """Repeat `rows` of limb k of (LIMB_ROWS, K, LANES) along `tile` (LIMB_ROWS, WIDTH), so many times."""
    for row in rows:
        own = limbs[row, k]
        for column in range(columns):
            for i in range(LANES):
                tile[row, column * LANES + i] = own[i]


@kernel("void(f4[::1], f4[::1], i8, i8, i8)")
def _middles(row: Float32, out: Float32, half: int, n: int, closed: int) -> None:
    """Compute the middles between neighbours of a row of n numbers, whose even columns are the first `half`: those from
    an even column to the next odd one, then those from an odd one to the next even one; out (n,)."""
    even, odd = row[:half], row[half:n]
    for i in range(n - half):
        out[i] = _HALF * (even[i] + odd[i])
    later, after = even[LANES:], out[n - half :]
    for i in range(half - LANES):
        after[i] = _HALF * (odd[i] + later[i])
    for i in range(closed):
        out[n - closed + i] = _HALF * (odd[half - LANES + i] + even[i])


@kernel("void(f4[::1], f4[::1], i8, i8, i8)")
def _push_both(row: Float32, push: Float32, half: int, n: int, closed: int) -> None:
    """Add the pushes of middles, in the order of `_middles`, to both their particles."""
    even, odd = row[:half], row[half:n]
    for i in range(n - half):
        even[i] += push[i]
        odd[i] += push[i]
    later, after = even[LANES:], push[n - half :]
    for i in range(half - LANES):
        odd[i] += after[i]
        later[i] += after[i]
    for i in range(closed):
        odd[half - LANES + i] += push[n - closed + i]
        even[i] += push[n - closed + i]


@inline_kernel
def _take(row: Float32, to: Float32, half: int, n: int, closed: int, middles: int) -> None:
    """Copy a row, or the middles between its neighbours, to the first n numbers of `to`."""
    if middles:
        _middles(row, to, half, row.shape[0], closed)
    else:
        for i in range(n):
            to[i] = row[i]


@inline_kernel
def _any_near(limb: Float32, at: Float32, n: int) -> Any:
    """Return whether any of the first n places `at` (3, WIDTH) may touch its limb, (LIMB_ROWS, WIDTH)."""
    near = np.int32(0)
    for i in range(n):
        dx, dy, dz = at[0, i] - limb[MIDDLE, i], at[1, i] - limb[MIDDLE + 1, i], at[2, i] - limb[MIDDLE + 2, i]
        along = limb[AXES + 3, i] * dx + limb[AXES + 4, i] * dy + limb[AXES + 5, i] * dz
        s = min(max(along, _ZERO), limb[LENGTH, i])
        near |= np.int32(dx * dx + dy * dy + dz * dz - s * (_TWO * along - s) < limb[BOUND, i])
    return near != 0


@inline_kernel
def _push_out(limb: Float32, at: Float32, push: Float32, n: int, thickness: Any) -> None:
    """Compute how far the first n places `at` (3, WIDTH) have to move out of their limbs, `push` likewise."""
    for i in range(n):
        dx, dy, dz = at[0, i] - limb[MIDDLE, i], at[1, i] - limb[MIDDLE + 1, i], at[2, i] - limb[MIDDLE + 2, i]
        side = limb[AXES, i] * dx + limb[AXES + 1, i] * dy + limb[AXES + 2, i] * dz
        along = limb[AXES + 3, i] * dx + limb[AXES + 4, i] * dy + limb[AXES + 5, i] * dz
        front = limb[AXES + 6, i] * dx + limb[AXES + 7, i] * dy + limb[AXES + 8, i] * dz
        s = min(max(along * limb[PER_LENGTH, i], _ZERO), _ONE)
        along -= s * limb[LENGTH, i]
        rs = limb[SIDES, i] + s * (limb[SIDES + 1, i] + s * (limb[SIDES + 2, i] + s * limb[SIDES + 3, i]))
        rf = limb[FRONTS, i] + s * (limb[FRONTS + 1, i] + s * (limb[FRONTS + 2, i] + s * limb[FRONTS + 3, i]))
        rb = limb[BACKS, i] + s * (limb[BACKS + 1, i] + s * (limb[BACKS + 2, i] + s * limb[BACKS + 3, i]))
        rf = rf if front > _ZERO else rb
        ra = limb[CAPS + 1, i] if along > _ZERO else limb[CAPS, i]
        us, ua, uf = side * rs, along * ra, front * rf
        k0 = math.sqrt(us * us + ua * ua + uf * uf)
        gs, ga, gf = us * rs, ua * ra, uf * rf
        k1 = _ONE / math.sqrt(gs * gs + ga * ga + gf * gf + _TINY)
        far = max(thickness - k0 * (k0 - _ONE) * k1, _ZERO) * k1
        gs, ga, gf = gs * far, ga * far, gf * far
        push[0, i] = limb[AXES, i] * gs + limb[AXES + 3, i] * ga + limb[AXES + 6, i] * gf
        push[1, i] = limb[AXES + 1, i] * gs + limb[AXES + 4, i] * ga + limb[AXES + 7, i] * gf
        push[2, i] = limb[AXES + 2, i] * gs + limb[AXES + 5, i] * ga + limb[AXES + 8, i] * gf


@kernel("void(f4[:,::1], i4[:,::1], f4[:,:,::1], f4)")
def keep_out(places: Float32, contacts: Int32, limbs: Float32, thickness: float) -> None:
    """Push rows of particles, and middles between neighbours, to `thickness` [m] outside the limbs.

    places (3, P LANES); contacts (C, 4), sorted by limb, all of as many particles; limbs (LIMB_ROWS, K, LANES). The
    distance from a limb is of first order, k0 (k0 - 1) / k1.
    """
    limb, at = np.empty((LIMB_ROWS, WIDTH), np.float32), np.empty((3, WIDTH), np.float32)
    push = np.empty((3, WIDTH), np.float32)
    tiled, whole = -1, -1
    for c in range(contacts.shape[0]):
        first, middles = contacts[c, CONTACT_FIRST] * LANES, contacts[c, CONTACT_MIDDLES]
        columns = min(int(contacts[c, CONTACT_COUNT]), COLUMNS)
        if contacts[c, CONTACT_LIMB] != tiled:
            tiled = contacts[c, CONTACT_LIMB]
            _tile(limb, limbs, tiled, columns, _NEAR_ROWS)
        width, half = columns * LANES, (columns + 1) // 2 * LANES
        closed = LANES if middles == CLOSED else 0
        n = width - LANES + closed if middles else width
        for axis in range(3):
            _take(places[axis, first : first + width], at[axis], half, n, closed, middles)
        if not _any_near(limb, at, n):
            continue
        if whole != tiled:  # most limbs are near to nothing
            whole = tiled
            _tile(limb, limbs, tiled, columns, _OTHER_ROWS)
        _push_out(limb, at, push, n, thickness)
        for axis in range(3):
            row, out = places[axis, first : first + width], push[axis]
            if middles:
                _push_both(row, out, half, width, closed)
            else:
                for i in range(n):
                    row[i] += out[i]
