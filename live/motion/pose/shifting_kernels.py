"""How much of a measure's correction is in when part of the measure has passed, for kernels that place dancers."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.motion.yaw_kernels import yaw_rotate

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

KNOTS = 65
"""Knots of a rise over a measure, the first at its beginning, the last at its end."""
SHARE, RATE = 0, 1
"""Columns of a rise: the share that is in at a knot, and how fast it grows there [1 per measure]."""
DIRECTIONS = 16
"""Ways of a step, about its clip's own heading, for which it is known how far legs give."""


@kernel("f8(f8[:,::1], f8)")
def risen(rise: Float64, fraction: float) -> float:
    """Share of the correction that is in at `fraction` of the measure, 0 to 1, C1; `rise` (KNOTS, 2).

    Between knots the rate is a straight line, so the share is a parabola.
    """
    place = min(max(fraction, 0.0), 1.0) * (rise.shape[0] - 1)
    k = min(math.floor(place), rise.shape[0] - 2)
    u = place - k
    slope = rise[k, RATE] + 0.5 * u * (rise[k + 1, RATE] - rise[k, RATE])
    share: float = rise[k, SHARE] + u * slope / (rise.shape[0] - 1)
    return share


@kernel("f8(f8, f8, f8, f8)")
def shifted(risen_now: float, risen_then: float, shift: float, goal: float) -> float:
    """How far a dancer is carried [m] who was by `shift` when `risen_then` was in and shall be by `goal` at the end."""
    if risen_then >= 1.0:
        return goal
    return shift + (risen_now - risen_then) / (1.0 - risen_then) * (goal - shift)


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], i4[::1], f8[:,:,::1], f8[::1], f8)")
def bound_aims(
    goal: Float64,
    correction: Float64,
    aimed: Float64,
    phase: Float64,
    node: Int32,
    rise: Float64,
    most: Float64,
    least_left: float,
) -> None:
    """Change the `goal` (A, 2) [m] of dancers at `phase` (A,) to what can still be reached as slowly as a whole way.

    In the rest of the rise nobody goes farther than that share of `most` (A,) [m], or of what she goes already. Who
    has no more than `least_left` of her rise before her keeps her `correction` (A, 3). Else as in `re_aim_dancers`.
    """
    for n in range(goal.shape[0]):
        share = risen(rise[max(node[n], 0)], phase[n])
        if node[n] < 0 or 1.0 - share <= least_left or share < aimed[n, 2]:
            goal[n, 0], goal[n, 1] = correction[n, 0], correction[n, 1]
            continue
        x = shifted(share, aimed[n, 2], aimed[n, 0], correction[n, 0])
        z = shifted(share, aimed[n, 2], aimed[n, 1], correction[n, 1])
        going = math.sqrt((correction[n, 0] - x) ** 2 + (correction[n, 1] - z) ** 2)
        wanted = math.sqrt((goal[n, 0] - x) ** 2 + (goal[n, 1] - z) ** 2)
        scale = min(1.0, max(going, (1.0 - share) * most[n]) / max(wanted, 1e-9))
        goal[n, 0], goal[n, 1] = x + scale * (goal[n, 0] - x), z + scale * (goal[n, 1] - z)


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], i4[::1], f8[:,:,::1], f8)")
def re_aim_dancers(
    correction: Float64,
    aimed: Float64,
    goal: Float64,
    phase: Float64,
    node: Int32,
    rise: Float64,
    least_left: float,
) -> None:
    """Lead A dancers to `goal` (A, 2) [m] from `phase` (A,) on: `correction` (A, 3) and `aimed` (A, 3) are rewritten.

    `node` (A,) says whose row of `rise` (N, KNOTS, 2) counts; below 0: she is not led. Who has no more than
    `least_left` of her rise before her keeps what she has.
    """
    for n in range(correction.shape[0]):
        if node[n] < 0:
            continue
        share = risen(rise[node[n]], phase[n])
        if 1.0 - share <= least_left or share < aimed[n, 2]:
            continue
        for c in range(2):
            aimed[n, c] = shifted(share, aimed[n, 2], aimed[n, c], correction[n, c])
            correction[n, c] = goal[n, c]
        aimed[n, 2] = share


@kernel("f8(f8[::1], f8, f8)")
def given_towards(give: Float64, x: float, z: float) -> float:
    """How far legs give [m] towards (x, z) in the clip's own axes; `give` (DIRECTIONS,), straight between two."""
    count = give.shape[0]
    place = math.atan2(x, z) / (2.0 * math.pi) * count
    low = math.floor(place)
    share = place - low
    far: float = (1.0 - share) * give[low % count] + share * give[(low + 1) % count]
    return far


@kernel("void(f8[:,::1], f8[::1], i4[::1], f8[:,::1], f8[:,::1], f8[:,:,::1], f8[::1], f8, f8)")
def bound_ways(
    way: Float64,
    yaw: Float64,
    node: Int32,
    gives: Float64,
    holds: Float64,
    held: Float64,
    share: Float64,
    most: float,
    most_held: float,
) -> None:
    """Shorten the `way` (A, 2) [m] of each dancer's correction to what her legs give, and to `most` [m].

    `yaw` (A,) [rad] of her clip on the stage; `gives` (N, DIRECTIONS) and `holds` (N, 2) of the nodes, `node` (A,) of
    the dancers; `share` (A,): how much of what legs give she may use. Feet that are held beside their clip's places
    already, by `held` (A, 2, 2) [m], and are not lifted at once are held against no more than `most_held` [m].
    """
    for n in range(way.shape[0]):
        v = max(node[n], 0)
        size = math.sqrt(way[n, 0] * way[n, 0] + way[n, 1] * way[n, 1])
        if size < 1e-9:
            continue
        x, z = yaw_rotate(way[n, 0], way[n, 1], -yaw[n])
        scale = min(1.0, min(most, share[n] * given_towards(gives[v], x, z)) / size)
        for foot in range(2):
            # |held - scale * hold * way| <= limit, for the largest scale
            hx, hz = holds[v, foot] * way[n, 0], holds[v, foot] * way[n, 1]
            a = hx * hx + hz * hz
            if a < 1e-9:
                continue
            b = hx * held[n, foot, 0] + hz * held[n, foot, 1]
            c = held[n, foot, 0] * held[n, foot, 0] + held[n, foot, 1] * held[n, foot, 1]
            limit = max(most_held * most_held, c)
            scale = min(scale, max((b + math.sqrt(b * b + a * (limit - c))) / a, 0.0))
        way[n, 0] *= scale
        way[n, 1] *= scale


@kernel("void(f8[:,::1], f8[::1], i8)")
def share_out(costs: Float64, weights: Float64, rounds: int) -> None:
    """Change `weights` (K,), which add up to 1, so that the largest of `costs` (M, K) @ weights is nearly least.

    In each round every weight falls by a factor with its part of the cost that is dearest then; the mean over all
    rounds comes near the value of the game (Freund & Schapire 1999).
    """
    total, dearest = np.zeros(weights.shape[0]), 0.0
    for m in range(costs.shape[0]):
        for k in range(weights.shape[0]):
            dearest = max(dearest, costs[m, k])
    for n in range(rounds):
        worst, highest = 0, -1.0
        for m in range(costs.shape[0]):
            cost = 0.0
            for k in range(weights.shape[0]):
                cost += costs[m, k] * weights[k]
            if cost > highest:
                worst, highest = m, cost
        whole = 0.0
        for k in range(weights.shape[0]):
            total[k] += weights[k]
            weights[k] *= math.exp(-costs[worst, k] / (dearest * math.sqrt(1.0 + 0.1 * n)))
            whole += weights[k]
        for k in range(weights.shape[0]):
            weights[k] /= whole
    for k in range(weights.shape[0]):
        weights[k] = total[k] / rounds
