"""Kernels of implicit surfaces: the field at points, and where rays leave a body.

A shape is a table of parts (P, COLUMNS), one row each in blending order, and the cross-sections of its lofts (S, 4),
SAMPLES rows each: half-width across, in front and behind, and shift to the front [m].
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

BLEND, HOLLOW, LOW, HIGH, CENTRE, AXES, INVERSE, LENGTH, FIRST = 0, 1, 2, 5, 8, 11, 20, 23, 24
"""Columns of a part: blend width; 1 for a hollow; lowest and highest corner of its box; centre of an ellipsoid, start
of a loft; its three axes, of a loft: along, across, front; inverse radii of an ellipsoid, of a loft in the first of
them: cross-sections per metre; length of a loft, 0 for an ellipsoid; first row of a loft's cross-sections."""
COLUMNS = 25
SAMPLES = 65
"""Cross-sections of a loft, evenly from its start to its end."""
_HOLLOW_REACH = 1e-3  # farther than its blend width and this [m] a hollow changes nothing
_MOST_LEFT_OUT = 8
_TINY = 1e-9


@kernel("f8(f8,f8,f8,f8[:,::1],f8[:,::1])")
def distance_at(x: float, y: float, z: float, parts: Float64, sections: Float64) -> float:
    """Return the approximate distance of a point from the skin [m], negative inside."""
    x = abs(x)
    total = math.inf
    for row in range(parts.shape[0]):
        blend, hollow = parts[row, BLEND], parts[row, HOLLOW] > 0.0
        bx = max(parts[row, LOW] - x, x - parts[row, HIGH], 0.0)
        by = max(parts[row, LOW + 1] - y, y - parts[row, HIGH + 1], 0.0)
        bz = max(parts[row, LOW + 2] - z, z - parts[row, HIGH + 2], 0.0)
        near = _HOLLOW_REACH + blend if hollow else total + blend
        if near <= 0.0 or bx * bx + by * by + bz * bz >= near * near:
            continue  # a part whose box is farther than what is there changes nothing
        dx, dy, dz = x - parts[row, CENTRE], y - parts[row, CENTRE + 1], z - parts[row, CENTRE + 2]
        a = parts[row, AXES] * dx + parts[row, AXES + 1] * dy + parts[row, AXES + 2] * dz
        b = parts[row, AXES + 3] * dx + parts[row, AXES + 4] * dy + parts[row, AXES + 5] * dz
        c = parts[row, AXES + 6] * dx + parts[row, AXES + 7] * dy + parts[row, AXES + 8] * dz
        inverse_a, inverse_b, inverse_c = parts[row, INVERSE], parts[row, INVERSE + 1], parts[row, INVERSE + 2]
        length = parts[row, LENGTH]
        if length > 0.0:
            along = min(max(a, 0.0), length)
            place = along * inverse_a
            low = int(place) if place < SAMPLES - 2 else SAMPLES - 2  # also if it is no number
            share = place - low
            at = int(parts[row, FIRST]) + low
            c -= sections[at, 3] * (1.0 - share) + sections[at + 1, 3] * share
            side = 1 if c > 0.0 else 2
            inverse_b = 1.0 / (sections[at, 0] * (1.0 - share) + sections[at + 1, 0] * share)
            inverse_c = 1.0 / (sections[at, side] * (1.0 - share) + sections[at + 1, side] * share)
            inverse_a = max(inverse_b, inverse_c)
            a -= along
        # first-order distance from an ellipsoid: k0 (k0 - 1) / k1
        a, b, c = a * inverse_a, b * inverse_b, c * inverse_c
        squared = a * a + b * b + c * c
        a, b, c = a * inverse_a, b * inverse_b, c * inverse_c
        own = (squared - math.sqrt(squared)) / max(math.sqrt(a * a + b * b + c * c), _TINY)
        # smooth minimum: the union with a fillet; a hollow is what is left of the rest's outside
        if hollow:
            total = -total
        apart = abs(total - own)
        total = min(total, own)
        if apart < blend:
            overlap = (blend - apart) / blend
            total -= overlap * overlap * blend * 0.25
        if hollow:
            total = -total
    return max(total, -y)  # soles are flat


@kernel("void(f8[:,::1],f8[:,::1],f8[:,::1],f8[::1])")
def distances(points: Float64, parts: Float64, sections: Float64, out: Float64) -> None:
    """Write the approximate distance of each of the points (N, 3) from the skin [m] into `out` (N,)."""
    for i in range(points.shape[0]):
        out[i] = distance_at(points[i, 0], points[i, 1], points[i, 2], parts, sections)


@kernel("void(f8[:,::1],f8[::1],f8[::1],f8[:,::1],f8[:,::1],i8[::1])")
def first_outside(
    origins: Float64, way: Float64, reach: Float64, parts: Float64, sections: Float64, out: Int64
) -> None:
    """Write into `out` (N,) for each ray from `origins` (N, 3) along `way` (3,) the first of the evenly spaced places
    `reach` (K,) [m] along it that is outside, the last one if none is.

    Deep inside, places within half of the depth are left out, but few at a time: near the middle of flat parts the
    field is deeper than the skin is far.
    """
    last = reach.shape[0] - 1
    spacing = reach[last] / last
    for i in range(origins.shape[0]):
        k = 0
        while k < last:
            t = reach[k]
            x, y, z = origins[i, 0] + t * way[0], origins[i, 1] + t * way[1], origins[i, 2] + t * way[2]
            away = distance_at(x, y, z, parts, sections)
            if away > 0.0:
                break
            k += max(min(int(-0.5 * away / spacing), _MOST_LEFT_OUT), 1)
        out[i] = min(k, last)
