"""Kernels that fill the pose pipeline's inputs: samples, placements and shares of all dancers' clips in one pass."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.scalar_kernels import ease
from live.motion.pose.foot_lock_kernels import (
    CLEARANCE,
    CLEARANCE_SOFTNESS,
    OFFSET_X,
    OFFSET_Z,
    RAISE,
    RAISE_SPEED,
)
from live.motion.pose.footstep_kernels import shift_between
from live.motion.pose.turn_kernels import place_clip
from live.motion.pose.warp_curve_kernels import curve_place, share_between, warped_shift
from live.motion.pose.yaw_kernels import yaw_rotate

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]

PRESENT, PRESENT_TAKE, NEXT, NEXT_TAKE = range(4)
LOWER, UPPER, INTO_NEXT, NEXT_LOWER, NEXT_UPPER = range(5)
"""Rows of `sample`, `placement` and `share` as in `pipeline_kernels`."""
MAX_CLEARANCE = 0.08
"""Maximum clearance requested for a foot [m], compressed from half of it on."""
MINOR_SHARE = 0.25
"""A clip with a smaller share than this in a pose counts less for foot clearance."""
CLEARANCE_SOFTNESS_SHARE = 0.3
"""Part of the height over which the clearance sets in."""
MAX_SPEED_CHANGE = 0.9
"""Largest change of a clip's speed by a time warp, as a share (T054: from 1 on it would run backwards)."""
MAX_HOLD = 0.55
"""In the most sudden mood movements are slower at beats, and faster between them, by this share."""
STEPPING = 0.004
"""A foot that its plan lifts higher than this [m] does not stand."""


@kernel("b1(i4[::1], i4[::1], i4[::1], i4[::1], f4[::1], f4[::1])")
def same_measures(
    node: Int32, other_node: Int32, take: Int32, other_take: Int32, share: Float32, other_share: Float32
) -> bool:
    """Whether A dancers dance the same nodes with the same takes mixed in, all (A,)."""
    different = False
    for n in range(node.shape[0]):
        different |= node[n] != other_node[n] or take[n] != other_take[n] or share[n] != other_share[n]
    return not different


@kernel("void(f8[::1], f8, f8[:,::1], f8)")
def warp_phases(out: Float64, fraction: float, warp: Float64, window: float) -> None:
    """Compute phases (A,) of measures warped by `warp` (4, A) at `fraction` (T055)."""
    room = 1.0 - window
    for n in range(out.shape[0]):
        out[n] = fraction
        if warp[0, n] == 0.0:
            continue
        f = max(warp[1, n], 0.5 / room)
        begin = min(max(warp[2, n], 0.0), max(room - 0.5 / f, 0.0))
        if begin < fraction < begin + 0.5 / f:
            out[n] += warp[3, n] * warp[0, n] * math.sin(2.0 * math.pi * f * (fraction - begin))


@kernel("UniTuple(f8,2)(f8[::1], f8, f8[:,::1], f8, f8[::1], f8[::1], f8[::1], f8[::1], f8)")
def delay_phases(
    out: Float64, fraction: float, warp: Float64, window: float, ahead: Float64, delay_before: Float64, delay: Float64,
    sudden: Float64, turns: float,
) -> tuple[float, float]:  # fmt: skip
    """Compute phases (A,) as `warp_phases`, plus `ahead` (A,), minus deliberate delay; return the lowest and highest.

    The delay goes from `delay_before` (A,) to `delay` (A,) through the measure; no dancer is more than a measure
    behind. By moods of time `sudden` (A,), -1 to 1, movements are fast between beats and slow at them, or the other
    way; all are on the beat. `turns`: the angle of the beats in a measure [rad]; 0: no such moods.
    """
    warp_phases(out, fraction, warp, window)
    share, lowest, highest = ease(fraction), np.inf, -np.inf
    sine = math.sin(turns * fraction)
    for n in range(out.shape[0]):
        lead = ahead[n]
        if turns > 0.0:
            room = max(MAX_SPEED_CHANGE - 2.0 * math.pi * warp[0, n] * warp[1, n], 0.0)
            lead += -min(max(MAX_HOLD * sudden[n], -room), room) * sine / turns
        phase = max(out[n] + lead - (delay_before[n] + share * (delay[n] - delay_before[n])), -1.0)
        lowest, highest = min(lowest, phase), max(highest, phase)
        out[n] = phase
    return lowest, highest


@kernel(
    "void(i8, i8, i4, i4, f8, f4, f4, f8[::1], f8[::1], f8[::1], f8[:,::1], f8[::1], f8[:,::1], f8[:,:,::1],"
    " f4[:,::1], i8, f8, f8, f8, f8)"
)
def gather_take(
    n: int,
    row: int,
    node: int,
    take: int,
    phase: float,
    lower: float,
    upper: float,
    first: Float64,
    last: Float64,
    lead: Float64,
    start: Float64,
    facing: Float64,
    sample: Float64,
    placement: Float64,
    share: Float32,
    share_row: int,
    x: float,
    z: float,
    path: float,
    body: float,
) -> None:
    """Fill rows `row` and `share_row` for the other take of dancer `n`, whose own clip lies at x, z, path, body.

    Both clips have their hips at one position and the same facing when the measure begins (T045).
    """
    share[share_row, n], share[share_row + 1, n] = lower, upper
    if lower == 0.0 and upper == 0.0:
        sample[row, n] = sample[row - 1, n]
        placement[row, n, 0], placement[row, n, 1], placement[row, n, 2], placement[row, n, 3] = x, z, path, body
        return
    other = max(take, 0)
    turn = facing[node] - facing[other]
    ox, oz = yaw_rotate(start[other, 0], start[other, 1], turn)
    dx, dz = yaw_rotate(start[node, 0] - ox, start[node, 1] - oz, path)
    sample[row, n] = max(first[other] + phase * (last[other] - first[other]), lead[other])
    placement[row, n, 0], placement[row, n, 1] = x + dx, z + dz
    placement[row, n, 2], placement[row, n, 3] = path + turn, body + turn


@kernel(
    "void(i8[::1], f8[::1], f4[:,::1], i4[::1], f8[:,::1], f8[:,::1], f8[:,:,::1], f8[:,:,:,::1], f8[:,:,::1], f8[::1],"
    " f4[:,:,::1])"
)
def plan_feet(
    rows: Int64, phase: Float64, share: Float32, node: Int32, correction: Float64, aimed: Float64, warp_curve: Float64,
    foot_curve: Float64, foot_aim: Float64, locks: Float64, foot_offset: Float32,
) -> None:  # fmt: skip
    """Write how far footstep plans have the feet of the dancers `rows` (n,) from their places in the clips as placed.

    `foot_offset` (A, 2, 3): x, z [m] of the feet from there, and the height [m] to which their plan lifts them.
    `share`: the pipeline's, as `gather_dancers` has filled it; `foot_curve` of N nodes; `foot_aim` (A, 2, 6) of the
    measures, `locks` (A,): 0 for dancers whose feet are not locked; other arrays as in `gather_dancers`.
    """
    for i in range(rows.shape[0]):
        n, at = rows[i], min(max(phase[i], 0.0), 1.0)
        own, weight = max(node[n], 0), locks[n] * (1.0 - share[INTO_NEXT, n])
        x, z = correction[n, 0], correction[n, 1]
        knot, part = curve_place(at, warp_curve.shape[1])
        now = share_between(warp_curve[own], knot, part)
        root_x = warped_shift(now, aimed[n, 2], aimed[n, 0], x)
        root_z = warped_shift(now, aimed[n, 2], aimed[n, 1], z)
        for foot in range(2):
            foot_x, foot_z, lift = shift_between(foot_curve[own, foot], knot, part, at, foot_aim[n, foot], x, z)
            foot_offset[n, foot, 0], foot_offset[n, foot, 1] = weight * (foot_x - root_x), weight * (foot_z - root_z)
            foot_offset[n, foot, 2] = weight * lift


@kernel(
    "void(i8[::1], f8[::1], f8, f8, b1, b1,"
    " i4[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], i4[::1], f4[:,::1], f8[:,::1],"
    " i4[::1], f8[:,::1], i4[::1], f4[:,::1], f8[:,::1],"
    " f8[::1], f8[::1], f8[::1], f8[:,::1], f8[::1], f8[:,:,::1], f8[:,:,::1],"
    " f8[:,::1], f8[:,:,::1], f4[:,::1], i4[:,::1], f4[::1])"
)
def gather_dancers(
    rows: Int64,
    phase: Float64,
    fraction: float,
    window: float,
    continues: bool,
    takes: bool,
    node: Int32,
    clip_placement: Float64,
    correction: Float64,
    aimed: Float64,
    on_support: Float64,
    take: Int32,
    take_share: Float32,
    amplitude: Float64,
    next_node: Int32,
    next_where: Float64,
    next_take: Int32,
    next_take_share: Float32,
    next_amplitude: Float64,
    first: Float64,
    last: Float64,
    lead: Float64,
    start: Float64,
    facing: Float64,
    turns: Float64,
    warp_curve: Float64,
    sample: Float64,
    placement: Float64,
    share: Float32,
    mean: Int32,
    scaled_amplitude: Float32,
) -> None:
    """Fill the pipeline's arrays for the dancers `rows` (n,) at `phase` (n,) of their measures, clamped to 0 to 1.

    Their measures: `node`, `clip_placement` (A, 3) placement of the clips, `correction` and `aimed` (A, 3),
    `on_support`, `take`, `take_share` (2, A) and `amplitude` (2, A), eased by `fraction`. For the following measures,
    if the dance `continues`, the same for the next clips, blended in over the last `window` of the measure (K004). Of N
    nodes: `first`, `last`, `lead` samples, `start` (N, 2) and `facing` (N,) of the hips at their beginning, `turns` and
    `warp_curve`. Outputs as in `PosePipeline`: `sample` (4, A), `placement` (4, A, 4), `share` (5, A), `mean` (2, A),
    amplitude `scaled_amplitude` (A,); without `takes` only samples and placements of PRESENT and NEXT, and INTO_NEXT.
    """
    for i in range(rows.shape[0]):
        n, at = rows[i], min(max(phase[i], 0.0), 1.0)  # never read a clip beyond its measure
        own = max(node[n], 0)
        x, z, path, body = place_clip(
            clip_placement[n], correction[n], aimed[n], at, turns[own], warp_curve[own], on_support[n]
        )
        sample[PRESENT, n] = first[own] + at * (last[own] - first[own])
        placement[PRESENT, n, 0], placement[PRESENT, n, 1] = x, z
        placement[PRESENT, n, 2], placement[PRESENT, n, 3] = path, body
        if takes:
            gather_take(
                n, PRESENT_TAKE, own, take[n], at, take_share[0, n], take_share[1, n], first, last, lead, start, facing,
                sample, placement, share, LOWER, x, z, path, body,
            )  # fmt: skip
        mean[0, n] = max(take[n], 0) if take_share[1, n] > 0.5 else own
        loud = amplitude[0, n] + ease(fraction) * (amplitude[1, n] - amplitude[0, n])
        into = ease((at - (1.0 - window)) / window) if continues and next_node[n] >= 0 else 0.0
        share[INTO_NEXT, n] = into
        if into == 0.0:
            sample[NEXT, n], scaled_amplitude[n] = sample[PRESENT, n], loud
            share[NEXT_LOWER, n] = share[NEXT_UPPER, n] = 0.0  # clear the previous request
            continue
        coming = max(next_node[n], 0)
        back = (at - 1.0) * (last[coming] - first[coming])
        x, z, path = next_where[n, 0], next_where[n, 1], next_where[n, 2]
        sample[NEXT, n] = max(first[coming] + back, lead[coming])
        placement[NEXT, n, 0], placement[NEXT, n, 1] = x, z
        placement[NEXT, n, 2], placement[NEXT, n, 3] = path, path
        if takes:
            gather_take(
                n, NEXT_TAKE, coming, next_take[n], at - 1.0, next_take_share[0, n], next_take_share[1, n], first, last,
                lead, start, facing, sample, placement, share, NEXT_LOWER, x, z, path, path,
            )  # fmt: skip
        mean[1, n] = max(next_take[n], 0) if next_take_share[1, n] > 0.5 else coming
        scaled_amplitude[n] = loud + into * (next_amplitude[0, n] - loud)


@kernel("void(f8[:,::1], i8[::1], f8[:,::1], f8[:,:,::1], f4[:,::1], f4[:,::1])")
def clip_hips(out: Float64, rows: Int64, sample: Float64, placement: Float64, share: Float32, root: Float32) -> None:
    """Compute the clips' hip positions of the dancers `rows` (n,) [m], `out` (n, 2).

    Transitions are included, other takes are not; `root` (S, 3).
    """
    for i in range(rows.shape[0]):
        n = rows[i]
        k, into = int(sample[PRESENT, n]), share[INTO_NEXT, n]
        dx, dz = yaw_rotate(root[k, 0], root[k, 2], placement[PRESENT, n, 2])
        x, z = placement[PRESENT, n, 0] + dx, placement[PRESENT, n, 1] + dz
        if into > 0.0:
            k = int(sample[NEXT, n])
            dx, dz = yaw_rotate(root[k, 0], root[k, 2], placement[NEXT, n, 2])
            x += into * (placement[NEXT, n, 0] + dx - x)
            z += into * (placement[NEXT, n, 1] + dz - z)
        out[i, 0], out[i, 1] = x, z


@kernel("void(f4[:,:,::1], f4[:,:,::1])")
def shift_feet(leg_position: Float32, foot_offset: Float32) -> None:
    """Move ankles and toes of the legs (A, 9, 3) [m] by the `foot_offset` (A, 2, 3) of the footstep plans."""
    for n in range(leg_position.shape[0]):
        for foot in range(2):
            for joint in (3 + 4 * foot, 4 + 4 * foot):
                leg_position[n, joint, 0] += foot_offset[n, foot, 0]
                leg_position[n, joint, 2] += foot_offset[n, foot, 1]


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], f4)")
def set_steps(feet: Float32, foot_offset: Float32, lock: Float32, age: float) -> None:
    """Write the `foot_offset` (A, 2, 3) of the footstep plans to the columns of `feet` (A, 2, 12), and the clearance of
    feet that they lift or that the `lock` (A, 2, 16) raises, `age` [s] after its tick."""
    for n in range(feet.shape[0]):
        for foot in range(2):
            feet[n, foot, OFFSET_X], feet[n, foot, OFFSET_Z] = foot_offset[n, foot, 0], foot_offset[n, foot, 1]
            lift = max(foot_offset[n, foot, 2], lock[n, foot, RAISE] + age * lock[n, foot, RAISE_SPEED])
            if lift > feet[n, foot, CLEARANCE]:
                feet[n, foot, CLEARANCE] = lift
                feet[n, foot, CLEARANCE_SOFTNESS] = CLEARANCE_SOFTNESS_SHARE * lift


@kernel("void(b1[:,::1], f8[:,::1], f8, f4[:,::1], b1[:,::1], f4[:,:,::1], i8, i8)")
def standing_feet(
    out: Bool, sample: Float64, later: float, share: Float32, contact: Bool, foot_offset: Float32, begin: int, end: int
) -> None:
    """Compute which feet (A, 2) of the dancers begin..end-1 are in contact in the clips `later` samples after those
    sampled, from the annotation `contact` (S, 2) of all samples.

    While clips are mixed or blended a foot counts only if all of them have it on the floor. A foot that its footstep
    plan lifts, by `foot_offset` (A, 2, 3), does not stand.
    """
    last = contact.shape[0] - 1.0
    for n in range(begin, end):
        into = share[INTO_NEXT, n]
        own, coming = round(min(sample[PRESENT, n] + later, last)), round(min(sample[NEXT, n] + later, last))
        other = round(min(sample[PRESENT_TAKE, n] + later, last))
        for foot in range(2):
            stands = contact[own, foot]
            if share[LOWER, n] > 0.0:
                stands = stands and contact[other, foot]
            stands = (stands or into >= 1.0) and (contact[coming, foot] or into <= 0.0)
            out[n, foot] = stands and foot_offset[n, foot, 2] < STEPPING


@kernel("void(f4[:,:,::1], f8[:,::1], f4[:,::1], f4[:,::1], i8, i8)")
def set_clearance(feet: Float32, sample: Float64, share: Float32, height: Float32, begin: int, end: int) -> None:
    """Set the minimum foot heights where clips are mixed or blended, of the dancers begin..end-1: columns CLEAR and
    ROUND of `feet` (A, 2, 12).

    The blend of a standing and a swinging foot would drag over the floor at a fraction of the swing's height. A foot is
    therefore as high as the highest of its clips, up to MAX_CLEARANCE, by the sole `height` (S, 2) [m] of all samples.
    Unblended clips are unchanged, and a foot that stands in all clips stands.
    """
    weight = np.empty(4)
    for n in range(begin, end):
        into, lower, coming = share[INTO_NEXT, n], share[LOWER, n], share[NEXT_LOWER, n] * (share[INTO_NEXT, n] > 0.0)
        weight[PRESENT], weight[PRESENT_TAKE] = (1.0 - into) * (1.0 - lower), (1.0 - into) * lower
        weight[NEXT], weight[NEXT_TAKE] = into * (1.0 - coming), into * coming
        most = max(max(weight[0], weight[1]), max(weight[2], weight[3]))
        mixed = ease((1.0 - most) / MINOR_SHARE)
        for foot in range(2):
            feet[n, foot, CLEARANCE] = feet[n, foot, CLEARANCE_SOFTNESS] = 0.0
            if mixed == 0.0:
                continue
            total = 0.0
            for k in range(4):
                if weight[k] <= 0.0:
                    continue
                low = math.floor(sample[k, n])
                part, high = sample[k, n] - low, min(low + 1, height.shape[0] - 1)
                up = height[low, foot] + part * (height[high, foot] - height[low, foot])
                up *= ease(weight[k] / MINOR_SHARE) / math.sqrt(1.0 + (up / MAX_CLEARANCE) ** 2)
                total += up * up * up * up
            feet[n, foot, CLEARANCE] = math.sqrt(math.sqrt(total))
            feet[n, foot, CLEARANCE_SOFTNESS] = CLEARANCE_SOFTNESS_SHARE * mixed * feet[n, foot, CLEARANCE]
