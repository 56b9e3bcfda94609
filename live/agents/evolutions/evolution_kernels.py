"""Kernels of evolutions: places at a beat, tracking, clearance, pair swaps, divide and conquer (T088, T097-T101)."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.steering_kernels import hash_unit
from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bytes = npt.NDArray[np.uint8]

_VX, _FIRM = 0, 6  # columns of Wants.rows


@inline_kernel
def _share(t: float, soft: float) -> float:
    """Return the share of the path covered after the share `t` of the time."""
    if soft <= 0.0:
        return t
    top = 1.0 / (1.0 - soft)
    u = min(t, 1.0 - t) / soft
    if u >= 1.0:
        return top * (t - 0.5 * soft)
    ramp = top * soft * u * u * u * (1.0 - 0.5 * u)  # the integral of smoothstep
    return ramp if t < 0.5 else 1.0 - ramp


@inline_kernel
def _rate(t: float, soft: float) -> float:
    """Return the derivative of `_share`: speed as a multiple of the average speed."""
    if soft <= 0.0:
        return 1.0
    u = min(min(t, 1.0 - t) / soft, 1.0)
    return u * u * (3.0 - 2.0 * u) / (1.0 - soft)


@kernel("f8(f8,f8)")
def profile(t: float, soft: float) -> float:
    """Return the share of the path covered after the share `t` in [0, 1] of the time.

    `soft` in [0, 0.5] is the share of the time in which the speed rises, and falls again, as a smoothstep: speed and
    acceleration are continuous; 0 is constant speed. The top speed is 1 / (1 - soft) of the average.
    """
    return _share(min(max(t, 0.0), 1.0), min(max(soft, 0.0), 0.5))


@inline_kernel
def _turn_at(turns: Float64, d: int, beat: float) -> float:
    """Return the heading [rad] of the knots turns[d] (H, 2: beat, heading) at `beat`: linear, held beyond the ends."""
    low, high = 0, turns.shape[1] - 1
    if beat <= turns[d, 0, 0]:
        return float(turns[d, 0, 1])
    if beat >= turns[d, high, 0]:
        return float(turns[d, high, 1])
    while high - low > 1:
        middle = (low + high) // 2
        if turns[d, middle, 0] <= beat:
            low = middle
        else:
            high = middle
    length = float(turns[d, high, 0] - turns[d, low, 0])
    part_ = (beat - float(turns[d, low, 0])) / length if length > 0.0 else 1.0
    before = float(turns[d, low, 1])
    return before + part_ * (float(turns[d, high, 1]) - before)


@kernel("void(f8, f4[:,:,::1], f8[:,::1], f8, f8[:,:,::1], i4[::1], u1[::1], f4[:,::1], f4[:,::1], f4[::1], u1[::1])")
def evaluate_paths(
    beat: float,
    ways: Float32,
    times: Float64,
    soft: float,
    turns: Float64,
    who: Int32,
    keep: Bytes,
    position: Float32,
    velocity: Float32,
    heading: Float32,
    under: Bytes,
) -> None:
    """Write the places of D dancers on their paths at `beat` into the rows `who` (D,) of arrays of A dancers.

    `ways` (D, K, 2) [m] are knots at even shares of the path, joined by a Catmull-Rom spline, which is a straight line
    where the knots lie evenly on one. `times` (D, 2) are the beats at which each dancer begins and ends; before and
    after they stand. `turns` (D, H, 2) are knots (beat, heading). `velocity` is in metres per beat. Rows with
    keep[d] == 0 are left alone; `under` becomes 1 where a row is written.
    """
    last = ways.shape[1] - 1
    for d in range(ways.shape[0]):
        if keep[d] == 0:
            continue
        a = who[d]
        under[a] = 1
        heading[a] = _turn_at(turns, d, beat)
        begin, length = times[d, 0], times[d, 1] - times[d, 0]
        if beat <= begin or beat >= times[d, 1]:
            k = 0 if beat <= begin and length > 0.0 else last
            position[a, 0] = ways[d, k, 0]
            position[a, 1] = ways[d, k, 1]
            velocity[a, 0] = 0.0
            velocity[a, 1] = 0.0
            continue
        t = (beat - begin) / length
        along = _share(t, soft) * last
        k = min(int(along), last - 1)
        u = along - k
        rate = _rate(t, soft) * last / length
        for axis in range(2):
            p1 = float(ways[d, k, axis])
            p2 = float(ways[d, k + 1, axis])
            p0 = float(ways[d, k - 1, axis]) if k > 0 else 2.0 * p1 - p2
            p3 = float(ways[d, k + 2, axis]) if k + 2 <= last else 2.0 * p2 - p1
            c1 = 0.5 * (p2 - p0)
            c2 = p0 - 2.5 * p1 + 2.0 * p2 - 0.5 * p3
            c3 = 1.5 * (p1 - p2) + 0.5 * (p3 - p0)
            position[a, axis] = p1 + u * (c1 + u * (c2 + u * c3))
            velocity[a, axis] = (c1 + u * (2.0 * c2 + 3.0 * u * c3)) * rate


@kernel("void(f8[::1], f4[:,:,::1], f8[:,::1], f8, i8, i8, f4[:,:,::1])")
def sample_paths(
    beats: Float64, ways: Float32, times: Float64, soft: float, first: int, last: int, sample: Float32
) -> None:
    """Write places of the dancers `first` to `last` (not included) at T `beats` into `sample` (T, D, 2) [m].

    Arguments as in `evaluate_paths`, but knots are joined by straight lines: within millimetres where they lie dense.
    """
    final = ways.shape[1] - 1
    for d in range(first, last):
        begin, length = times[d, 0], times[d, 1] - times[d, 0]
        for row in range(beats.shape[0]):
            t = (beats[row] - begin) / length if length > 0.0 else (0.0 if beats[row] < begin else 1.0)
            along = _share(min(max(t, 0.0), 1.0), soft) * final
            k = min(int(along), final - 1)
            u = along - k
            for axis in range(2):
                before = float(ways[d, k, axis])
                sample[row, d, axis] = before + u * (float(ways[d, k + 1, axis]) - before)


@kernel("void(f4[:,::1], f4[:,::1], f4[:,::1], u1[::1], f8, f8, f4[:,::1])")
def track(
    now: Float32,
    position: Float32,
    velocity: Float32,
    under: Bytes,
    beats_per_second: float,
    within: float,
    rows: Float32,
) -> None:
    """Command dancers with under[a] to follow their paths: write velocity [m/s] and firmness into Wants.rows (A, 8).

    `now` (A, 2) are the actual places, `position` (A, 2) the planned ones, `velocity` (A, 2) [m/beat] the planned one;
    the position error is corrected within about `within` seconds.
    """
    for a in range(now.shape[0]):
        if under[a] == 0:
            continue
        for axis in range(2):
            rows[a, _VX + axis] = velocity[a, axis] * beats_per_second + (position[a, axis] - now[a, axis]) / within
        rows[a, _FIRM] = 1.0


ROUNDING_MARGIN = 0.01
"""Safety margin [m] against rounding: a pair farther apart than the clearance plus this has not met."""


@kernel("void(f4[:,:,::1], i8, i8, f8[::1])")
def longest_moves(sample: Float32, first: int, last: int, step: Float64) -> None:
    """Write the longest way from one time to the next of the dancers `first` to `last` (not included) on `sample`
    (T, D, 2) [m] into `step` (D,) [m].
    """
    for d in range(first, last):
        longest = 0.0
        for k in range(1, sample.shape[0]):
            x, z = float(sample[k, d, 0]) - sample[k - 1, d, 0], float(sample[k, d, 1]) - sample[k - 1, d, 1]
            longest = max(longest, x * x + z * z)
        step[d] = math.sqrt(longest)


@kernel("void(f4[:,:,::1], f8[::1], f8, i8, i8, f4[:,::1], f4[:,::1])")
def nearest_approach(
    sample: Float32, step: Float64, reach: float, first: int, last: int, distance: Float32, when: Float32
) -> None:
    """Compute how near pairs of dancers come: `sample` (T, D, 2) [m] at even times, linear between them.

    `step` (D,) [m] by `longest_moves`. Fills rows `first` to `last` (not included) of `distance` (D, D) [m] and `when`
    (D, D) (in samples) for all partners j, so a long job can be done in pieces; the diagonal becomes infinite. Times at
    which two cannot be nearer than before, or than `reach` [m], because they do not move so fast, are skipped: above
    `reach`, the distance is that at some time.
    """
    times, count = sample.shape[0], sample.shape[1]
    for i in range(first, last):
        for j in range(count):
            distance[i, j] = np.inf
            when[i, j] = 0.0
            if j == i:
                continue
            x0 = float(sample[0, j, 0]) - sample[0, i, 0]
            z0 = float(sample[0, j, 1]) - sample[0, i, 1]
            least, at, k = x0 * x0 + z0 * z0, 0.0, 1
            closing = max(step[i] + step[j], 1e-9)
            nearest = min(math.sqrt(least), reach)
            while k < times:
                away = math.sqrt(x0 * x0 + z0 * z0) - nearest - ROUNDING_MARGIN
                if away > closing:
                    k += int(min(away / closing, float(times)))
                    if k >= times:
                        break
                    x0 = float(sample[k - 1, j, 0]) - sample[k - 1, i, 0]
                    z0 = float(sample[k - 1, j, 1]) - sample[k - 1, i, 1]
                x1 = float(sample[k, j, 0]) - sample[k, i, 0]
                z1 = float(sample[k, j, 1]) - sample[k, i, 1]
                dx, dz = x1 - x0, z1 - z0
                square = dx * dx + dz * dz
                u = 1.0
                if square > 1e-18:
                    u = min(max(-(x0 * dx + z0 * dz) / square, 0.0), 1.0)
                px, pz = x0 + u * dx, z0 + u * dz
                gap = px * px + pz * pz
                if gap < least:
                    least, at = gap, k - 1 + u
                    nearest = min(math.sqrt(least), reach)
                x0, z0 = x1, z1
                k += 1
            distance[i, j] = math.sqrt(least)
            when[i, j] = at


@kernel("i8(f8[:,::1], f8[:,::1], i4[::1], i4[::1], i8, i8)")
def swap_pairs(start: Float64, slots: Float64, slot: Int32, section: Int32, first: int, last: int) -> int:
    """Swap the slots of any two dancers of one section where that reduces the sum of squared path lengths.

    Rows `first` to `last` (not included) are compared with all later ones; `slot` (D,) is changed in place, dancers
    with slot -1 are left out. Returns the number of swaps. When a sweep over all rows returns 0, no two dancers on
    synchronous straight paths come nearer than 1/√2 of the spacing (the argument of CAPT considers pairs only).
    """
    swapped = 0
    for i in range(first, last):
        if slot[i] < 0:
            continue
        for j in range(i + 1, start.shape[0]):
            if slot[j] < 0 or section[j] != section[i]:
                continue
            a, b = slot[i], slot[j]
            gain = (start[j, 0] - start[i, 0]) * (slots[b, 0] - slots[a, 0])
            gain += (start[j, 1] - start[i, 1]) * (slots[b, 1] - slots[a, 1])
            if gain < -1e-9:
                slot[i], slot[j] = b, a
                swapped += 1
    return swapped


@kernel("void(f8[:,::1], f4[:,:,::1], f4[:,:,::1], i8, i8)")
def _locate(place: Float64, sample: Float32, offset: Float32, d: int, k: int) -> None:
    """Write the shifted place of dancer `d` at time `k`, x and z [m], into `place` (2, D)."""
    place[0, d] = sample[d, k, 0] + offset[d, k, 0]
    place[1, d] = sample[d, k, 1] + offset[d, k, 1]


@kernel("i8(f4[:,:,::1], f4[:,:,::1], i8, i8, f8, f8, f8, i8)")
def separate_paths_at(
    sample: Float32, offset: Float32, k: int, half: int, clear: float, excess: float, randomness: float, seed: int
) -> int:
    """Compute offsets (D, K, 2) that separate colliding paths at time `k` (T101, Schulz 2011, 4.3.2).

    `sample` (D, K, 2) are places at even times. The offsets begin as the means of those `half` before and after. Where
    two dancers would be nearer than `clear` [m], both are shifted in opposite directions along one random line (drawn
    from `seed`, the pair and the time) until they are `excess` times that apart. With `randomness` 1 every direction
    may be drawn, as in the thesis; smaller values allow only directions near the perpendicular of the relative motion:
    dancers shifted along it still meet, a little later. Returns how many pairs were separated.
    """
    count, parted = sample.shape[0], 0
    place, surely = np.empty((2, count)), clear * clear + 1e-3  # quick rejection of pairs that are far apart
    for d in range(count):
        for axis in range(2):
            offset[d, k, axis] = 0.5 * (offset[d, k - half, axis] + offset[d, k + half, axis])
        _locate(place, sample, offset, d, k)
    for i in range(count):
        for j in range(i + 1, count):
            x, z = place[0, j] - place[0, i], place[1, j] - place[1, i]
            if x * x + z * z > surely:
                continue
            x = float(sample[j, k, 0]) + offset[j, k, 0] - sample[i, k, 0] - offset[i, k, 0]
            z = float(sample[j, k, 1]) + offset[j, k, 1] - sample[i, k, 1] - offset[i, k, 1]
            square = x * x + z * z
            if square >= clear * clear:
                continue
            parted += 1
            dx = float(sample[j, k + 1, 0]) - sample[i, k + 1, 0] - sample[j, k - 1, 0] + sample[i, k - 1, 0]
            dz = float(sample[j, k + 1, 1]) - sample[i, k + 1, 1] - sample[j, k - 1, 1] + sample[i, k - 1, 1]
            square_to = 2.0 * hash_unit(seed, i * 65537 + j, k) - 1.0  # its sign is the side
            angle = math.atan2(dx, dz) + 0.5 * math.pi * (math.copysign(1.0 - randomness, square_to))
            angle += math.pi * randomness * square_to
            ux, uz = math.sin(angle), math.cos(angle)
            along = x * ux + z * uz
            if along < 0.0:  # choose the direction that separates them
                ux, uz, along = -ux, -uz, -along
            goal = (clear * excess) * (clear * excess)
            shift = 0.5 * (math.sqrt(max(along * along + goal - square, 0.0)) - along)
            offset[j, k, 0] += shift * ux
            offset[j, k, 1] += shift * uz
            offset[i, k, 0] -= shift * ux
            offset[i, k, 1] -= shift * uz
            _locate(place, sample, offset, i, k)
            _locate(place, sample, offset, j, k)
    return parted


@kernel("void(f4[:,:,::1])")
def smooth_paths(offset: Float32) -> None:
    """Do one pass of the filter 1/4, 1/2, 1/4 along axis 1 of (D, K, 2); the ends stay."""
    for d in range(offset.shape[0]):
        for axis in range(2):
            before = float(offset[d, 0, axis])
            for k in range(1, offset.shape[1] - 1):
                here = float(offset[d, k, axis])
                offset[d, k, axis] = 0.25 * before + 0.5 * here + 0.25 * offset[d, k + 1, axis]
                before = here


@kernel("void(f4[:,:,::1], f8[::1])")
def longest_steps(ways: Float32, step: Float64) -> None:
    """Compute the longest step of each dancer on `ways` (D, T, 2) [m] between two times, `step` (D,) [m]."""
    for d in range(ways.shape[0]):
        longest = 0.0
        for k in range(1, ways.shape[1]):
            x, z = float(ways[d, k, 0]) - ways[d, k - 1, 0], float(ways[d, k, 1]) - ways[d, k - 1, 1]
            longest = max(longest, x * x + z * z)
        step[d] = math.sqrt(longest)


@kernel("b1(f4[:,:,::1], i8, i8, f4, f8)")
def pair_collides(ways: Float32, i: int, j: int, clear: float, step: float) -> bool:
    """Whether two of the dancers on `ways` (D, T, 2) [m], at even times and linear between, come nearer than `clear`.

    The measure is that of `nearest_approach`, but the search stops at the first time found. The two approach each other
    by at most `step` [m] from one time to the next, so times at which they cannot have met are skipped.
    """
    x0, z0 = float(ways[j, 0, 0]) - ways[i, 0, 0], float(ways[j, 0, 1]) - ways[i, 0, 1]
    if np.float32(math.sqrt(x0 * x0 + z0 * z0)) < clear:
        return True
    surely = (float(clear) + ROUNDING_MARGIN) ** 2  # skips the square root except near the bound
    k = 1
    while k < ways.shape[1]:
        away = math.sqrt(x0 * x0 + z0 * z0) - clear - ROUNDING_MARGIN
        if away > step:
            k += int(min(away / max(step, 1e-9), float(ways.shape[1])))
            if k >= ways.shape[1]:
                return False
            x0, z0 = float(ways[j, k - 1, 0]) - ways[i, k - 1, 0], float(ways[j, k - 1, 1]) - ways[i, k - 1, 1]
        x1, z1 = float(ways[j, k, 0]) - ways[i, k, 0], float(ways[j, k, 1]) - ways[i, k, 1]
        dx, dz = x1 - x0, z1 - z0
        square = dx * dx + dz * dz
        u = 1.0
        if square > 1e-18:
            u = min(max(-(x0 * dx + z0 * dz) / square, 0.0), 1.0)
        px, pz = x0 + u * dx, z0 + u * dz
        gap = px * px + pz * pz
        if gap < surely and np.float32(math.sqrt(gap)) < clear:
            return True
        x0, z0 = x1, z1
        k += 1
    return False


@kernel("i8(f4[:,:,::1], f8[::1], i8, i8, f4)")
def count_collisions(ways: Float32, step: Float64, first: int, last: int, clear: float) -> int:
    """Count the pairs of a dancer `first` to `last` (not included) and a later one that come nearer than `clear` [m].

    `ways` as in `pair_collides`, `step` (D,) [m] by `longest_steps`.
    """
    meeting = 0
    for i in range(first, last):
        for j in range(i + 1, ways.shape[0]):
            meeting += pair_collides(ways, i, j, clear, step[i] + step[j])
    return meeting
