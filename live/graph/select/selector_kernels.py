"""Kernels that choose the next measures of many dancers from all candidates, turned and corrected (T068-T070)."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.base.scalar_kernels import angle_wrap

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

PLACE = 0
CORRECTED = 1
HEADING = 2
TURN = 3
POSE = 4
WRONG = 5
SIDE = 6
MIXED = 7
"""Indices in the array of weights."""
EXPENSIVE_EDGE = 10.0
"""Edges that cost this much more than the cheapest, wherever they lead, are examined last."""
UNEXAMINED_DISTANCE = 1e9
"""Distance assumed for candidates that were not examined [m]."""


@kernel("UniTuple(f8,5)(f8[:,::1], i8, f8[:,::1], i8)")
def clip_placement(at: Float64, n: int, edge: Float64, e: int) -> tuple[float, float, float, float, float]:
    """Return x, z, yaw, its cosine and sine of a clip that joins the axes at[n] (5,) along edge[e] (6,) (K001)."""
    c, s = at[n, 3], at[n, 4]
    x, z = at[n, 0] + edge[e, 0] * c + edge[e, 1] * s, at[n, 1] + edge[e, 1] * c - edge[e, 0] * s
    return x, z, at[n, 2] + edge[e, 2], c * edge[e, 3] - s * edge[e, 4], s * edge[e, 3] + c * edge[e, 4]


@kernel("UniTuple(f8,4)(UniTuple(f8,5), i8, i8, i8, f8[:,::1], f8[:,::1], f8[:,::1], f8[:,:,::1], f8[:,::1])")
def candidate_end(
    placement: tuple[float, float, float, float, float],
    n: int,
    v: int,
    k: int,
    target: Float64,
    options: Float64,
    clip: Float64,
    turn_offsets: Float64,
    max_turns: Float64,
) -> tuple[float, float, float, float]:
    """Return the end of dancer n with candidate k of node v, placed at `placement`: hips x, z, turn, heading error.

    Arrays as in `choose_measures`; the wanted turn is inserted on the supporting foot as far as allowed.
    """
    x, z, yaw, c, s = placement
    want = angle_wrap(target[n, 2] - yaw - clip[k, 2] - options[n, 1] * clip[k, 5])
    turn = min(max(want, -max_turns[v, 0]), max_turns[v, 0])
    tc, ts = c, s
    ax, az = 0.0, 0.0
    if options[n, 0] != 0.0:
        if turn != want:
            side = max_turns[v, 2] if turn > 0.0 else -max_turns[v, 2]
            tc, ts = c * max_turns[v, 1] - s * side, s * max_turns[v, 1] + c * side
        elif options[n, 1] == 0.0:
            tc = target[n, 3] * clip[k, 3] + target[n, 4] * clip[k, 4]
            ts = target[n, 4] * clip[k, 3] - target[n, 3] * clip[k, 4]
        else:
            tc, ts = math.cos(yaw + turn), math.sin(yaw + turn)
        steps = turn_offsets.shape[1] - 1
        at = (turn + math.pi) * (steps / (2.0 * math.pi))
        row = min(max(int(at), 0), steps - 1)
        mx = turn_offsets[v, row, 0] + (at - row) * (turn_offsets[v, row + 1, 0] - turn_offsets[v, row, 0])
        mz = turn_offsets[v, row, 1] + (at - row) * (turn_offsets[v, row + 1, 1] - turn_offsets[v, row, 1])
        ax, az = mx * c + mz * s, mz * c - mx * s
    return x + ax + clip[k, 0] * tc + clip[k, 1] * ts, z + az + clip[k, 1] * tc - clip[k, 0] * ts, turn, want - turn


@kernel("f8(f8, f8, f8[::1])")
def place_cost(distance: float, reach_margin: float, weights: Float64) -> float:
    """Return the cost of ending `distance` [m] off, of which `reach_margin` [m] can be corrected at a lower cost."""
    within = min(distance, reach_margin)
    cost: float = weights[CORRECTED] * within * within + weights[PLACE] * (distance * distance - within * within)
    return cost


@kernel("f8(UniTuple(f8,4), f8[:,::1], i8)")
def place_error(end: tuple[float, float, float, float], target: Float64, n: int) -> float:
    """Return the distance of that end from dancer n's target [m]."""
    x, z = end[0] - target[n, 0], end[1] - target[n, 1]
    return math.sqrt(x * x + z * z)


@kernel("f8(UniTuple(f8,4), f8, f8[:,::1], i8, f8[:,::1], i8, f8)")
def correctable(
    end: tuple[float, float, float, float], yaw: float, target: Float64, n: int, margins: Float64, v: int, most: float
) -> float:
    """Return how far the end of dancer n with node v placed at `yaw` [rad] can be corrected towards the target [m]."""
    count = margins.shape[1]
    way = math.atan2(target[n, 0] - end[0], target[n, 1] - end[1]) - yaw - 0.5 * end[2]
    place = (way * (1.0 / (2.0 * math.pi)) + 4.0) * count
    low = int(place)
    share = place - low
    far: float = (1.0 - share) * margins[v, low % count] + share * margins[v, (low + 1) % count]
    return min(most, far)


@kernel("f8(UniTuple(f8,4), f8[::1])")
def turn_cost(end: tuple[float, float, float, float], weights: Float64) -> float:
    """Return the cost of the remaining heading error and of the turn."""
    cost: float = weights[HEADING] * end[3] * end[3] + weights[TURN] * end[2] * end[2]
    return cost


@inline_kernel
def insert_best(cost: float, e: int, k: int, n: int, edge: Int32, candidate: Int32, best_costs: Float64) -> None:
    """Insert candidate k of edge e into dancer n's best two if good enough; the last row of `best_costs`: their costs.

    The runner-up is another measure than the best, not another mixture of it.
    """
    last = best_costs.shape[0] - 1
    if cost < best_costs[last, 0]:
        if edge[n, 0] != e:
            best_costs[last, 1] = best_costs[last, 0]
            edge[n, 1], candidate[n, 1] = edge[n, 0], candidate[n, 0]
        best_costs[last, 0] = cost
        edge[n, 0], candidate[n, 0] = e, k
    elif cost < best_costs[last, 1] and edge[n, 0] != e:
        best_costs[last, 1] = cost
        edge[n, 1], candidate[n, 1] = e, k


@inline_kernel
def edge_costs(
    n: int, low: int, high: int, row: int, side: int, edge_target: Int32, edge: Float64, ahead: Float64,
    node_side: Int32, facts: Float64, weights: Float64, scratch: Float64,
) -> float:  # fmt: skip
    """Write the cost of edges `low` to `high`, wherever they lead, to `scratch`; return the least."""
    lowest = 1e300
    for e in range(low, high):
        v = edge_target[e]
        base = weights[POSE] * edge[e, 5] + weights[WRONG] * ahead[row, v] + facts[v, 2]
        if side * node_side[v] < 0:
            base += weights[SIDE]
        scratch[e - low, 0] = base
        scratch[e - low, 1] = UNEXAMINED_DISTANCE
        lowest = min(lowest, base)
    return lowest


@kernel(
    "void(i8,i8,i4[::1],f8[:,::1],f8[:,::1],i4[::1],f8[:,::1],i4[::1],f8[:,::1],"
    "i4[::1],i4[::1],f8[:,::1],i4[::1],f8[:,::1],f8[:,:,::1],f8[:,::1],f8[:,::1],f8[:,::1],i4[::1],"
    "f8[::1],f8[:,::1],i4[:,::1],i4[:,::1],f8[:,:,::1],f8[:,::1])"
)
def choose_measures(  # noqa: C901 - one search, best measures first
    begin: int,
    stop: int,
    node: Int32,
    placement: Float64,
    target: Float64,
    row: Int32,
    ahead: Float64,
    side: Int32,
    options: Float64,
    edge_start: Int32,
    edge_target: Int32,
    edge: Float64,
    first: Int32,
    clip: Float64,
    turn_offsets: Float64,
    max_turns: Float64,
    facts: Float64,
    margins: Float64,
    node_side: Int32,
    weights: Float64,
    scratch: Float64,
    out_edge: Int32,
    out_candidate: Int32,
    out_terms: Float64,
    out_end: Float64,
) -> None:
    """Choose for dancers `begin` to `stop` of A the edge and candidate with the best end, and the best other measure.

    node (A,): current node; placement (A, 5) x, z, yaw, its cosine and sine: the axes in which the next clip joins;
    wish (A, 5) wanted x, z [m] and heading [rad] at its end, cosine and sine; ahead (R, N) wrong measures if a node is
    danced next, row (A,) the row of it to use; side (A,) and node_side (N,) -1 original, 1 mirrored, 0 any; manner (A,
    3): 0 if the body is turned separately, the share of the mean heading that counts (T122), the share of a measure's
    possible correction that is used. Edges as CSR with edge (E, 6): x, z, yaw, cosine, sine, distance of the poses;
    candidates of node v from first[v] to first[v + 1], its own clip first, with clip (K, 7): hips at its end in its own
    axes x, z, heading there, its cosine and sine, difference of the mean heading to that, largest distance of its end
    from that of the own clip [m]; moved (N, T, 2): displacement
    [m] added by a turn on the supporting foot, at T angles from -π to π; most (N, 3): the largest turn, its cosine and
    sine; facts (N, 4): maximum correction of a measure in any direction [m], largest distance of its mixtures' ends
    from its own [m], its own cost, the largest correction at all [m]; margins (N, DIRECTIONS): how far it can be
    corrected in each direction about its clip's axes [m]. room (R', 2) is scratch for the edges of one node, its last
    row for two costs.

    Results: out_edge and out_candidate (A, 2), best and runner-up, -1 for none; out_terms (A, 2, 5), cost of place,
    heading, pose, wrong step and all else; out_end (A, 4): hips x, z, turn, and remaining heading error.
    """
    last = scratch.shape[0] - 1
    for n in range(begin, stop):
        low, high = edge_start[node[n]], edge_start[node[n] + 1]
        for rank in range(2):
            out_edge[n, rank], out_candidate[n, rank] = -1, -1
            scratch[last, rank] = 1e300
        lowest = edge_costs(
            n, low, high, row[n], side[n], edge_target, edge, ahead, node_side, facts, weights, scratch
        )  # fmt: skip
        # the unmixed clips, likely ones first: their costs bound which others have to be examined
        for sweep in range(2):
            for e in range(low, high):
                base = scratch[e - low, 0]
                if (base < lowest + EXPENSIVE_EDGE) != (sweep == 0) or base >= scratch[last, 1]:
                    continue
                v = edge_target[e]
                k = first[v]
                laid = clip_placement(placement, n, edge, e)
                end = candidate_end(laid, n, v, k, target, options, clip, turn_offsets, max_turns)
                off = place_error(end, target, n)
                scratch[e - low, 1] = off
                cost = base + place_cost(off, options[n, 2] * facts[v, 0], weights) + turn_cost(end, weights)
                if cost >= scratch[last, 1]:
                    continue
                give = options[n, 2] * correctable(end, laid[2], target, n, margins, v, facts[v, 3])
                cost = base + place_cost(off, give, weights) + turn_cost(end, weights)
                insert_best(cost, e, k, n, out_edge, out_candidate, scratch)
        for e in range(low, high):
            v = edge_target[e]
            base, give = scratch[e - low, 0] + weights[MIXED], options[n, 2] * facts[v, 0]
            if base + place_cost(max(scratch[e - low, 1] - facts[v, 1], 0.0), give, weights) >= scratch[last, 1]:
                continue
            laid = clip_placement(placement, n, edge, e)
            for k in range(first[v] + 1, first[v + 1]):
                if base + place_cost(max(scratch[e - low, 1] - clip[k, 6], 0.0), give, weights) >= scratch[last, 1]:
                    continue
                end = candidate_end(laid, n, v, k, target, options, clip, turn_offsets, max_turns)
                off = place_error(end, target, n)
                cost = base + place_cost(off, give, weights) + turn_cost(end, weights)
                if cost >= scratch[last, 1]:
                    continue
                gives = options[n, 2] * correctable(end, laid[2], target, n, margins, v, facts[v, 3])
                cost = base + place_cost(off, gives, weights) + turn_cost(end, weights)
                insert_best(cost, e, k, n, out_edge, out_candidate, scratch)
        for rank in range(1, -1, -1):  # the best comes last, so its end is kept
            e, k = out_edge[n, rank], out_candidate[n, rank]
            out_terms[n, rank] = 0.0
            if e >= 0:
                v = edge_target[e]
                laid = clip_placement(placement, n, edge, e)
                end = candidate_end(laid, n, v, k, target, options, clip, turn_offsets, max_turns)
                give = options[n, 2] * correctable(end, laid[2], target, n, margins, v, facts[v, 3])
                pose, wrong = weights[POSE] * edge[e, 5], weights[WRONG] * ahead[row[n], v]
                out_terms[n, rank, 0] = place_cost(place_error(end, target, n), give, weights)
                out_terms[n, rank, 1] = turn_cost(end, weights)
                out_terms[n, rank, 2], out_terms[n, rank, 3] = pose, wrong
                out_terms[n, rank, 4] = scratch[e - low, 0] - pose - wrong + weights[MIXED] * (k > first[v])
                out_end[n, 0], out_end[n, 1], out_end[n, 2], out_end[n, 3] = end
