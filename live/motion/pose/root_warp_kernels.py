"""Root warp kernels: what a measure's root correction shall be, its limits, and its retargeting within the measure.

`rows` (ROWS, A, 2) [m] holds the per-dancer correction state, see `live.show.dancers.root_correction`.
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.motion.pose.foot_lock_kernels import held_foot_shifts
from live.motion.pose.footstep_kernels import AIM_SHARE, AIM_X, AIM_Z, SETTLED, SETTLED_X, SETTLED_Z, foot_shift
from live.motion.pose.warp_curve_kernels import warp_share, warped_shift
from live.motion.pose.yaw_kernels import yaw_rotate

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

DIRECTIONS = 16
"""Directions about a clip's heading for which the reach margin is stored."""


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], i4[::1], f8[:,:,::1], f8[::1], f8)")
def limit_goals(
    goal: Float64,
    correction: Float64,
    aimed: Float64,
    phase: Float64,
    node: Int32,
    warp_curve: Float64,
    max_shift: Float64,
    least_left: float,
) -> None:
    """Limit the `goal` (A, 2) [m] of dancers at `phase` (A,) to what is reachable at the speed of a full correction.

    In the rest of the measure a dancer moves at most the remaining share of `max_shift` (A,) [m], or as far as already
    planned. With no more than `least_left` of the curve left, the `correction` (A, 3) is kept. Other arrays as in
    `redirect_dancers`.
    """
    for n in range(goal.shape[0]):
        share = warp_share(warp_curve[max(node[n], 0)], phase[n])
        if node[n] < 0 or 1.0 - share <= least_left or share < aimed[n, 2]:
            goal[n, 0], goal[n, 1] = correction[n, 0], correction[n, 1]
            continue
        x = warped_shift(share, aimed[n, 2], aimed[n, 0], correction[n, 0])
        z = warped_shift(share, aimed[n, 2], aimed[n, 1], correction[n, 1])
        going = math.sqrt((correction[n, 0] - x) ** 2 + (correction[n, 1] - z) ** 2)
        wanted = math.sqrt((goal[n, 0] - x) ** 2 + (goal[n, 1] - z) ** 2)
        scale = min(1.0, max(going, (1.0 - share) * max_shift[n]) / max(wanted, 1e-9))
        goal[n, 0], goal[n, 1] = x + scale * (goal[n, 0] - x), z + scale * (goal[n, 1] - z)


@kernel("void(f8[:,::1], f8[:,::1], f8[:,:,::1], f8[:,::1], f8[::1], i4[::1], f8[:,:,::1], f8[:,:,:,::1], f8, i8, i8)")
def redirect_dancers(
    correction: Float64,
    aimed: Float64,
    foot_aim: Float64,
    goal: Float64,
    phase: Float64,
    node: Int32,
    warp_curve: Float64,
    foot_curve: Float64,
    least_left: float,
    begin: int,
    end: int,
) -> None:
    """Redirect the dancers begin..end-1 of A to `goal` (A, 2) [m] from `phase` (A,) on: `correction` (A, 3), `aimed`
    (A, 3) and `foot_aim` (A, 2, 6) are updated.

    `node` (A,) selects the row of `warp_curve` (N, KNOTS, 2) and `foot_curve` (N, 2, KNOTS, 5); below 0 the dancer is
    skipped. With no more than `least_left` of a curve left, nothing changes: a foot keeps its goal.
    """
    for n in range(begin, end):
        if node[n] < 0:
            continue
        share = warp_share(warp_curve[node[n]], phase[n])
        if 1.0 - share <= least_left or share < aimed[n, 2]:
            continue
        for foot in range(2):
            own, aim = foot_curve[node[n], foot], foot_aim[n, foot]
            passed = warp_share(own, phase[n])
            if aim[SETTLED] > 0.0 or passed < aim[AIM_SHARE]:
                continue
            if 1.0 - passed <= least_left:
                aim[SETTLED], aim[SETTLED_X], aim[SETTLED_Z] = 1.0, correction[n, 0], correction[n, 1]
                continue
            x, z, _ = foot_shift(own, phase[n], aim, correction[n, 0], correction[n, 1])
            aim[AIM_X], aim[AIM_Z], aim[AIM_SHARE] = x, z, passed
        for c in range(2):
            aimed[n, c] = warped_shift(share, aimed[n, 2], aimed[n, c], correction[n, c])
            correction[n, c] = goal[n, c]
        aimed[n, 2] = share


@kernel("f8(f8[::1], f8, f8)")
def margin_towards(reach_margin: Float64, x: float, z: float) -> float:
    """Return the reach margin [m] towards (x, z) in the clip's axes; `reach_margin` (DIRECTIONS,), linear between
    directions."""
    count = reach_margin.shape[0]
    place = math.atan2(x, z) / (2.0 * math.pi) * count
    low = math.floor(place)
    share = place - low
    far: float = (1.0 - share) * reach_margin[low % count] + share * reach_margin[(low + 1) % count]
    return far


@kernel("void(f8[:,::1], f8[::1], i4[::1], f8[:,::1], f8[:,::1], f8[:,:,::1], f8[::1], f8, f8)")
def limit_corrections(
    shift: Float64,
    yaw: Float64,
    node: Int32,
    reach_margins: Float64,
    hold_shares: Float64,
    held: Float64,
    share: Float64,
    most: float,
    most_held: float,
) -> None:
    """Limit the `shift` (A, 2) [m] of each dancer's correction to the reach margin, and to `most` [m].

    `yaw` (A,) [rad] of the clip on the stage; `reach_margins` (N, DIRECTIONS) and `hold_shares` (N, 2) of the nodes,
    `node` (A,) of the dancers; `share` (A,): usable part of the reach margin. Feet that are already held away from
    their clip's position, by `held` (A, 2, 2) [m], and are not lifted at once are held against at most `most_held` [m].
    """
    for n in range(shift.shape[0]):
        v = max(node[n], 0)
        size = math.sqrt(shift[n, 0] * shift[n, 0] + shift[n, 1] * shift[n, 1])
        if size < 1e-9:
            continue
        x, z = yaw_rotate(shift[n, 0], shift[n, 1], -yaw[n])
        scale = min(1.0, min(most, share[n] * margin_towards(reach_margins[v], x, z)) / size)
        for foot in range(2):
            # the largest scale with |held - scale * hold * way| <= limit
            hx, hz = hold_shares[v, foot] * shift[n, 0], hold_shares[v, foot] * shift[n, 1]
            a = hx * hx + hz * hz
            if a < 1e-9:
                continue
            b = hx * held[n, foot, 0] + hz * held[n, foot, 1]
            c = held[n, foot, 0] * held[n, foot, 0] + held[n, foot, 1] * held[n, foot, 1]
            limit = max(most_held * most_held, c)
            scale = min(scale, max((b + math.sqrt(b * b + a * (limit - c))) / a, 0.0))
        shift[n, 0] *= scale
        shift[n, 1] *= scale


Int8 = npt.NDArray[np.int8]

(
    BEGIN,
    END,
    PLAN,
    SEPARATION,
    GOAL,
    AIM,
    AIM_SPEED,
    DESIRED,
    AGENT_LEAD,
    AGENT_AT_DECISION,
    TARGET_AT_DECISION,
    PREDICTED,
) = range(12)
"""Rows: where the measure begins and, uncorrected, ends; the planned correction; the part added to avoid contact;
its goal; the smoothed goal and its rate of change; the correction wanted by steering; the agent's lead at the
measure's beginning and its predicted position at the end; the dancer's planned end; and that end moved by the
agent's deviation."""
ROWS = 12


@kernel("void(f8[:,::1], f8[:,::1], i1[::1], i8, f8[:,::1])")
def clamp_ends(way: Float64, end: Float64, state: Int8, on: int, room: Float64) -> None:
    """Limit the `way` (A, 2) [m] of dancers whose `state` (A,) is `on`.

    `end` + `way` is clamped to `room` (A, 2) [m] to each side of the centre.
    """
    for n in range(way.shape[0]):
        if state[n] == on:
            x, z = end[n, 0] + way[n, 0], end[n, 1] + way[n, 1]
            way[n, 0] += min(max(x, -room[n, 0]), room[n, 0]) - x
            way[n, 1] += min(max(z, -room[n, 1]), room[n, 1]) - z


@kernel("void(f8[:,:,::1], f4[:,::1], f8[::1], f8[::1], f4[:,::1], f8, f8, f8, i8, i8)")
def desire_corrections(
    rows: Float64,
    position: Float32,
    obedience: Float64,
    late: Float64,
    shown: Float32,
    fraction: float,
    dead_zone: float,
    max_lead: float,
    begin: int,
    end: int,
) -> None:
    """Set wished corrections of the dancers begin..end-1: the plan plus, by `obedience` (A,), the deviation of agents
    at `position` (A, 2) [m].

    The agents' expected lead over their dancers goes evenly from its value at the measure's beginning to that at its
    end, at `fraction` of it. The measure of a dancer who is `late` (A,) on purpose ends that much later and may not
    have begun. A deviation is measured from even motion through the measure, or for late dancers from where they are
    `shown` (A, 2) [m], with the lead limited to `max_lead` [m]. Deviations below `dead_zone` [m] are ignored.
    """
    for n in range(begin, end):
        rows[DESIRED, n, 0], rows[DESIRED, n, 1] = rows[PLAN, n, 0], rows[PLAN, n, 1]
        passed = fraction / (1.0 + late[n])
        plan_x, plan_z = rows[END, n, 0] + rows[PLAN, n, 0], rows[END, n, 1] + rows[PLAN, n, 1]
        x = rows[AGENT_LEAD, n, 0] * (1.0 - passed) + (rows[AGENT_AT_DECISION, n, 0] - plan_x) * passed
        z = rows[AGENT_LEAD, n, 1] * (1.0 - passed) + (rows[AGENT_AT_DECISION, n, 1] - plan_z) * passed
        even_x = rows[BEGIN, n, 0] + (plan_x - rows[BEGIN, n, 0]) * passed
        even_z = rows[BEGIN, n, 1] + (plan_z - rows[BEGIN, n, 1]) * passed
        if late[n] > 0.0:
            x, z = x + even_x - shown[n, 0], z + even_z - shown[n, 1]
            even_x, even_z = float(shown[n, 0]), float(shown[n, 1])
        bound = min(1.0, max_lead / max(math.hypot(x, z), 1e-9))
        x, z = (position[n, 0] - even_x) - x * bound, (position[n, 1] - even_z) - z * bound
        size = math.hypot(x, z)
        heard = obedience[n] * max(size - dead_zone, 0.0) / max(size, 1e-9)
        rows[DESIRED, n, 0] += x * heard
        rows[DESIRED, n, 1] += z * heard


@kernel(
    "void(f8[:,:,::1], f8[:,::1], f8[:,::1], i4[::1], f8[:,::1], f8[:,::1], f4[:,:,::1], f8[::1], f8, f8,"
    " i1[::1], i8, f8[:,::1])"
)
def limit_desired(
    rows: Float64,
    placement: Float64,
    correction: Float64,
    node: Int32,
    reach_margins: Float64,
    hold_shares: Float64,
    lock: Float32,
    share: Float64,
    most: float,
    most_held: float,
    state: Int8,
    on: int,
    room: Float64,
) -> None:
    """Limit wishes to the reach margin, as `limit_corrections` does, and keep dancers who are `on` the stage on it.

    `placement` and `correction` (A, 3) of the current clips, `lock` (A, 2, 16) of the feet, `share` (A,) and the others
    as there; `state` (A,) and `room` (A, 2) as in `clamp_ends`.
    """
    yaw, held = np.empty(node.shape[0]), np.empty((node.shape[0], 2, 2))
    for n in range(node.shape[0]):
        yaw[n] = placement[n, 2] + 0.5 * correction[n, 2]
    held_foot_shifts(lock, held)
    limit_corrections(rows[DESIRED], yaw, node, reach_margins, hold_shares, held, share, most, most_held)
    clamp_ends(rows[DESIRED], rows[END], state, on, room)


@kernel(
    "void(f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i4[::1], f8[:,::1], f8[:,::1], f4[:,:,::1], f8[::1], f8, f8,"
    " i1[::1], i8, f8, f8)"
)
def compute_corrections(
    correction: Float64,
    target: Float64,
    end: Float64,
    placement: Float64,
    node: Int32,
    reach_margins: Float64,
    hold_shares: Float64,
    lock: Float32,
    share: Float64,
    most: float,
    most_held: float,
    state: Int8,
    on: int,
    edge_x: float,
    edge_z: float,
) -> None:
    """Write each `correction` (A, 3) from `end` to `target` (A, 2) [m], within the reach margin.

    The targets of dancers `on` the stage are clamped to its edges; other arrays as in `limit_desired`.
    """
    count = node.shape[0]
    way, yaw, held = np.empty((count, 2)), np.empty(count), np.empty((count, 2, 2))
    for n in range(count):
        x, z = target[n, 0], target[n, 1]
        if state[n] == on:
            x, z = min(max(x, -edge_x), edge_x), min(max(z, -edge_z), edge_z)
        way[n, 0], way[n, 1] = x - end[n, 0], z - end[n, 1]
        yaw[n] = placement[n, 2] + 0.5 * correction[n, 2]
    held_foot_shifts(lock, held)
    limit_corrections(way, yaw, node, reach_margins, hold_shares, held, share, most, most_held)
    for n in range(count):
        correction[n, 0], correction[n, 1] = way[n, 0], way[n, 1]


@kernel("void(f8[:,:,::1], f8[:,::1], f8[:,::1], f8[::1], i4[::1], f8[:,:,::1], f8[::1], f8)")
def apply_desired(
    rows: Float64,
    correction: Float64,
    aimed: Float64,
    phase: Float64,
    node: Int32,
    warp_curve: Float64,
    most: Float64,
    least_left: float,
) -> None:
    """Limit wishes by `limit_goals`, move predictions of dancers still adjustable, and add the avoidance."""
    limit_goals(rows[DESIRED], correction, aimed, phase, node, warp_curve, most, least_left)
    for n in range(node.shape[0]):
        if rows[DESIRED, n, 0] != correction[n, 0] or rows[DESIRED, n, 1] != correction[n, 1]:
            rows[PREDICTED, n, 0] = rows[TARGET_AT_DECISION, n, 0] + rows[DESIRED, n, 0] - rows[PLAN, n, 0]
            rows[PREDICTED, n, 1] = rows[TARGET_AT_DECISION, n, 1] + rows[DESIRED, n, 1] - rows[PLAN, n, 1]
        rows[GOAL, n, 0] = rows[DESIRED, n, 0] + rows[SEPARATION, n, 0]
        rows[GOAL, n, 1] = rows[DESIRED, n, 1] + rows[SEPARATION, n, 1]


@kernel("void(f8[:,:,::1], f8[:,::1], f8[:,::1], f8[::1], i4[::1], f8[:,:,::1], f8[::1], f8)")
def apply_goals(
    rows: Float64,
    correction: Float64,
    aimed: Float64,
    phase: Float64,
    node: Int32,
    warp_curve: Float64,
    most: Float64,
    least_left: float,
) -> None:
    """Limit goals, changed to avoid contact, by `limit_goals`; store their difference from the wishes as avoidance."""
    limit_goals(rows[GOAL], correction, aimed, phase, node, warp_curve, most, least_left)
    for n in range(node.shape[0]):
        rows[SEPARATION, n, 0] = rows[GOAL, n, 0] - rows[DESIRED, n, 0]
        rows[SEPARATION, n, 1] = rows[GOAL, n, 1] - rows[DESIRED, n, 1]


@kernel(
    "void(f8[:,:,::1], f8[:,::1], f8[:,::1], f8[:,:,::1], f8[::1], i4[::1], f8[:,:,::1], f8[:,:,:,::1], f8, f8, f8,"
    " i8, i8)"
)
def follow_goals(
    rows: Float64,
    correction: Float64,
    aimed: Float64,
    foot_aim: Float64,
    phase: Float64,
    node: Int32,
    warp_curve: Float64,
    foot_curve: Float64,
    rate: float,
    dt: float,
    least_left: float,
    begin: int,
    end: int,
) -> None:
    """Let aims of the dancers begin..end-1 follow goals at `rate` [1/s] through a tick of `dt` [s], critically damped;
    corrections follow the aims.

    Arrays as in `redirect_dancers`.
    """
    fall, slow = math.exp(-rate * dt), rate * dt
    for n in range(begin, end):
        for c in range(2):
            away = rows[AIM, n, c] - rows[GOAL, n, c]
            bend = rows[AIM_SPEED, n, c] + rate * away
            rows[AIM, n, c] = rows[GOAL, n, c] + fall * (away + bend * dt)
            rows[AIM_SPEED, n, c] = fall * (rows[AIM_SPEED, n, c] - slow * bend)
    redirect_dancers(
        correction, aimed, foot_aim, rows[AIM], phase, node, warp_curve, foot_curve, least_left, begin, end
    )


@kernel("void(f4[:,::1], f4[:,::1], f8[:,:,::1], f8[:,::1], f8, f8, f8[::1], f4[:,::1])")
def compute_references(
    reference: Float32,
    reference_velocity: Float32,
    rows: Float64,
    correction: Float64,
    fraction: float,
    rate: float,
    late: Float64,
    shown: Float32,
) -> None:
    """Compute the agents' `reference` positions (A, 2) [m] and their velocity, `reference_velocity` (A, 2) [m/s].

    They move evenly from the measure's beginning to its end, at `rate` measures per second; the reference of a dancer
    who is `late` (A,) is where the dancer is `shown` (A, 2) [m].
    """
    for n in range(reference.shape[0]):
        for c in range(2):
            way = rows[END, n, c] + correction[n, c] - rows[BEGIN, n, c]
            reference[n, c] = rows[BEGIN, n, c] + way * fraction
            reference_velocity[n, c] = way * rate
            if late[n] > 0.0:
                reference[n, c], reference_velocity[n, c] = shown[n, c], 0.0


@kernel("void(f8[:,:,::1], f4[:,:,::1], f8[:,::1], f4[:,::1], f4[:,::1])")
def begin_measure(rows: Float64, path: Float32, correction: Float64, position: Float32, reference: Float32) -> None:
    """Initialize a measure along `path` (A, M, 2) [m]: its `correction` (A, 3) is plan, aim and goal.

    Agents are at `position` (A, 2) [m] and their `reference` (A, 2) [m] is the dancers' position.
    """
    for n in range(path.shape[0]):
        for c in range(2):
            rows[BEGIN, n, c] = reference[n, c] = path[n, 0, c]
            rows[PLAN, n, c] = rows[AIM, n, c] = rows[GOAL, n, c] = correction[n, c]
            rows[SEPARATION, n, c] = rows[AIM_SPEED, n, c] = 0.0
            rows[PREDICTED, n, c] = rows[TARGET_AT_DECISION, n, c]
            rows[AGENT_LEAD, n, c] = position[n, c] - rows[BEGIN, n, c]


@kernel("void(f8[::1], f8[:,:,::1], f8[:,::1])")
def end_distances(distance: Float64, rows: Float64, correction: Float64) -> None:
    """Compute the distance between each dancer's corrected end and the predicted agent, `distance` (A,) [m];
    `correction` (A, 3)."""
    for n in range(distance.shape[0]):
        x = rows[END, n, 0] + correction[n, 0] - rows[PREDICTED, n, 0]
        z = rows[END, n, 1] + correction[n, 1] - rows[PREDICTED, n, 1]
        distance[n] = math.hypot(x, z)
