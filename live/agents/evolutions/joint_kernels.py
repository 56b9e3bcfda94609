"""Kernels of joint planning: encounters of dancers on their ways, and smooth shifts that keep them apart (T147)."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

HEAD_ON = 1e-3
"""Nearer than this [m] two dancers meet head on: the direction from one to the other says nothing."""


@inline_kernel
def _needed(base: float, slope: float, k: int, last: int, before: float, after: float) -> float:
    """Return the distance [m] that a pair has to keep at the time `k` of 0 to `last`.

    It is `base`, and less near both ends if the two stand nearer there: `before` and `after` [m]; from there it grows
    by `slope` [m] for each time.
    """
    return min(base, before + slope * k, after + slope * (last - k))


@inline_kernel
def _room(x: float, z: float, nx: float, nz: float, half_x: float, half_z: float) -> float:
    """Return how far a dancer at (x, z) [m] can go in the direction (nx, nz) within the half sizes of the stage."""
    room = 1e9
    if abs(nx) > 1e-9:
        room = min(room, (half_x - math.copysign(1.0, nx) * x) / abs(nx))
    if abs(nz) > 1e-9:
        room = min(room, (half_z - math.copysign(1.0, nz) * z) / abs(nz))
    return max(room, 0.0)


@inline_kernel
def _mobility(give: Float64, free: Int64, d: int, k: float) -> float:
    """Return how much of a shift the dancer `d` takes at the time `k`: nothing before the start and after arrival."""
    return float(give[d]) if free[d, 0] < k < free[d, 1] else 0.0


@kernel("i8(f8[:,:,::1], f8[:,::1], f8, f8, f8[::1], f8[::1], i8[:,::1], f8, f8, i8, i8, f8[:,:,::1], f8[:,::1])")
def shift_encounters(  # noqa: C901 - one pass over the times of a pair
    way: Float64, keep: Float64, slope: float, settled: float, stride: Float64, give: Float64, free: Int64,
    half_x: float, half_z: float, first: int, last: int, shift: Float64, count: Float64,
) -> int:  # fmt: skip
    """Find where pairs come too near, and add the shifts that would part them to `shift` (D, K, 2) [m].

    `way` (D, K, 2) are places at even times, straight between. A pair keeps `keep` (D, D) [m], 0: whatever; see
    `_needed` for `slope`. An encounter is a run of times at which a pair is too near. Both are shifted across the
    direction between them at their nearest approach, each by its share of `give` (D,), until the circle around the
    other is cleared; where there is no room on the stage (half sizes [m]) on that side, on the other. Dancers move
    between the times `free` (D, 2), both not included. `stride` (D,) is the longest piece of each way [m]. `count`
    (D, K) tells how many shifts were added. Pairs of rows `first` to `last` (not included) with all later ones are
    looked at. Returns the number of encounters that lack more than `settled` [m].
    """
    dancers, final = way.shape[0], way.shape[1] - 1
    found = 0
    for i in range(first, last):
        for j in range(i + 1, dancers):
            base = keep[i, j]
            if base <= 0.0 or give[i] + give[j] <= 0.0:
                continue
            closing = max(stride[i] + stride[j], 1e-9)
            x, z = way[j, 0, 0] - way[i, 0, 0], way[j, 0, 1] - way[i, 0, 1]
            before = math.sqrt(x * x + z * z)
            x, z = way[j, final, 0] - way[i, final, 0], way[j, final, 1] - way[i, final, 1]
            after = math.sqrt(x * x + z * z)
            k, begin, far = 0, -1, (base + closing) * (base + closing)
            worst, least, nx, nz, at = 0.0, 0.0, 0.0, 0.0, 0.0
            while k < final:
                x0, z0 = way[j, k, 0] - way[i, k, 0], way[j, k, 1] - way[i, k, 1]
                if begin < 0 and x0 * x0 + z0 * z0 > far:
                    k += int(min((math.sqrt(x0 * x0 + z0 * z0) - base) / closing, float(final)))
                    continue
                dx, dz = way[j, k + 1, 0] - way[i, k + 1, 0] - x0, way[j, k + 1, 1] - way[i, k + 1, 1] - z0
                square = dx * dx + dz * dz
                u = 1.0
                if square > 1e-18:
                    u = min(max(-(x0 * dx + z0 * dz) / square, 0.0), 1.0)
                px, pz = x0 + u * dx, z0 + u * dz
                near = px * px + pz * pz < base * base
                if near:
                    gap = math.sqrt(px * px + pz * pz)
                    need = min(
                        _needed(base, slope, k, final, before, after),
                        _needed(base, slope, k + 1, final, before, after),
                    )
                    near = gap < need
                if near:
                    if begin < 0:
                        begin, worst = k, 0.0
                    if need - gap > worst:
                        worst, least, at = need - gap, gap, k + u
                        if gap > HEAD_ON:
                            nx, nz = px / gap, pz / gap
                        else:  # each passes to their right
                            size = max(math.sqrt(square), 1e-12)
                            nx, nz = -dz / size, dx / size
                k += 1
                if begin < 0 or (near and k < final):
                    continue
                found += worst > settled
                end = k if near else k - 1
                m = min(int(at + 0.5), final)
                one, other = _mobility(give, free, i, at), _mobility(give, free, j, at)
                room = _room(way[i, m, 0], way[i, m, 1], -nx, -nz, half_x, half_z) if one > 0.0 else 0.0
                room += _room(way[j, m, 0], way[j, m, 1], nx, nz, half_x, half_z) if other > 0.0 else 0.0
                if room < worst:
                    room = _room(way[i, m, 0], way[i, m, 1], nx, nz, half_x, half_z) if one > 0.0 else 0.0
                    room += _room(way[j, m, 0], way[j, m, 1], -nx, -nz, half_x, half_z) if other > 0.0 else 0.0
                    if room >= worst + 2.0 * least:
                        nx, nz = -nx, -nz
                for m in range(max(begin, 1), min(end + 1, final)):
                    one, other = _mobility(give, free, i, float(m)), _mobility(give, free, j, float(m))
                    if one + other <= 0.0:
                        continue
                    rx, rz = way[j, m, 0] - way[i, m, 0], way[j, m, 1] - way[i, m, 1]
                    side = rx * nx + rz * nz
                    along = max(math.sqrt(max(rx * rx + rz * rz - side * side, 0.0)) - 0.5 * closing, 0.0)
                    need = _needed(base, slope, m, final, before, after)
                    lack = (math.sqrt(max(need * need - along * along, 0.0)) - side) / (one + other)
                    if lack > 0.0:
                        shift[i, m, 0] -= one * lack * nx
                        shift[i, m, 1] -= one * lack * nz
                        shift[j, m, 0] += other * lack * nx
                        shift[j, m, 1] += other * lack * nz
                        count[i, m] += 1.0
                        count[j, m] += 1.0
                begin = -1
    return found


SMOOTHINGS = 2
"""Times that shifts are smoothed: once leaves kinks."""


@kernel("void(f8[:,:,::1], f8[:,::1], i8[:,::1], f8[:,:,::1], f8, f8, f8, f8, f8, f8, f8[:,::1], f8[:,:,::1])")
def apply_shifts(  # noqa: C901 - one pass over a way
    shift: Float64, count: Float64, free: Int64, rest: Float64, reach: float, gain: float, ease: float, lean: float,
    half_x: float, half_z: float, work: Float64, way: Float64,
) -> None:  # fmt: skip
    """Add the means of `shift` over `count`, times `gain`, smoothed over about `reach` times, to `way` (D, K, 2) [m].

    Then the whole displacement from `rest` (D, K, 2) is stiffened: `ease` (at most 1/16) of its fourth difference is
    taken off. It is limited to `lean` n (n - 1) [m] at n times from start and arrival, so that nobody starts or stops
    with a jerk, and to the half sizes of the stage [m]. `shift` and `count` are 0 afterwards; `work` (3, K) is scratch.
    """
    stiff, above = reach * reach, 0.0
    for k in range(way.shape[1]):  # of the elimination, which is the same for all
        work[1, k] = 1.0 / (1.0 + 2.0 * stiff - stiff * above)
        work[2, k] = above = stiff * work[1, k]
    for d in range(way.shape[0]):
        begin, end = free[d, 0], free[d, 1]
        for axis in range(2):
            for k in range(begin + 1, end):
                shift[d, k, axis] *= gain / max(count[d, k], 1.0)
            for _ in range(SMOOTHINGS):  # (1 + 2 stiff) y[k] - stiff (y[k-1] + y[k+1]) = x[k], and 0 at both ends
                before = 0.0
                for k in range(begin + 1, end):
                    before = (shift[d, k, axis] + stiff * before) * work[1, k - begin - 1]
                    shift[d, k, axis] = before
                for k in range(end - 2, begin, -1):
                    shift[d, k, axis] += work[2, k - begin - 1] * shift[d, k + 1, axis]
            for k in range(begin + 1, end):
                way[d, k, axis] += shift[d, k, axis]
                work[0, k] = way[d, k, axis] - rest[d, k, axis]
            for k in range(begin + 1, end):
                far = work[0, k - 2] if k > begin + 2 else 0.0
                near = work[0, k - 1] if k > begin + 1 else 0.0
                next_ = work[0, k + 1] if k < end - 1 else 0.0
                last = work[0, k + 2] if k < end - 2 else 0.0
                way[d, k, axis] -= ease * (far - 4.0 * near + 6.0 * work[0, k] - 4.0 * next_ + last)
        for k in range(begin + 1, end):
            x, z = way[d, k, 0] - rest[d, k, 0], way[d, k, 1] - rest[d, k, 1]
            n = min(k - begin, end - k)
            most, size = lean * n * (n - 1), math.sqrt(x * x + z * z)
            if size > most:
                x, z = x * most / size, z * most / size
            # whoever is planned outside may stay as far outside
            most_x, most_z = max(half_x, abs(rest[d, k, 0])), max(half_z, abs(rest[d, k, 1]))
            way[d, k, 0] = min(max(rest[d, k, 0] + x, -most_x), most_x)
            way[d, k, 1] = min(max(rest[d, k, 1] + z, -most_z), most_z)
        for k in range(way.shape[1]):
            shift[d, k, 0] = shift[d, k, 1] = count[d, k] = 0.0
