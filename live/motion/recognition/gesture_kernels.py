"""Kernels for gestures: what a body does at one moment, a match of example gestures as they go on, and tempo.

A moment of a body is `MEASURES` numbers, relative to the body: its heading, its arms' and legs' lengths. The arrays
hold one body; the loops cover 22 joints, so there are no blocks.
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.capture.capture_kernels import rotate_vector, rotation_row
from live.motion.pose.hand_hold_kernels import multiply

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]

HIPS, SPINE, CHEST, UPPER_CHEST, NECK, HEAD = range(6)
LEFT_ARM, RIGHT_ARM = 7, 11
"""The left and the right upper arm; lower arm and hand follow."""
LEFT_LEG, RIGHT_LEG = 14, 18
"""The left and the right upper leg; lower leg, foot and toes follow."""
ARM_LENGTH = 0.51
"""From the shoulder to the wrist [m]."""
ANKLE_HEIGHT, TOES_HEIGHT = 0.085, 0.02
"""Heights of a standing foot's joints [m]."""
HIPS_HEIGHT, KNEE_HEIGHT = 0.935, 0.475
"""Heights of hips and knees of a standing body [m]."""
BODY_HEIGHT = 1.7
"""Height of the body [m]."""

(
    UP_LEFT, UP_RIGHT, LEVEL_LEFT, LEVEL_RIGHT, OUT_LEFT, OUT_RIGHT, REACH_LEFT, REACH_RIGHT, HANDS_APART, HIPS_UP,
    HIPS_OVER_ALL, KNEE_LEFT, KNEE_RIGHT, TRUNK_UP, LOWEST, TURNED, ENERGY, SPEED, SIZE, HANDS_HEIGHT, FEET_SPEED,
    BOUNCE, HANDS_SPEED, MEASURES,
) = range(24)  # fmt: skip
"""Numbers of a moment. Of both arms, in arm lengths: the wrist over the head's joint, over the shoulder, to its own
side of the shoulder, and its distance from the shoulder; between both wrists. In heights of a standing body: the hips
over the lower foot and over the lowest joint; the knees over the lower foot. Cosine between the trunk and the vertical;
height of the lower sole [m]; the turn since the last moment [rad]. Root of the mean squared joint speed and horizontal
speed of the hips [m/s]; mean distance of head, hands and feet from the hips, and height of the hands over the hips, in
body heights; sum of the feet's speeds, vertical speed of the hips, sum of the hands' speeds [m/s]."""

KEY_JOINTS = 9
"""Joints of a gesture's features: head, elbows, wrists, knees and ankles, see `body_stream`."""
FEATURES = 3 * KEY_JOINTS + 2
"""Features of a moment for examples: key joints relative to the hips, in the heading's axes [m]; height of the hips
over the lower foot [m]; the present turning, as metres at arm's length in `TURN_SECONDS`."""
TURN_SECONDS = 0.3
TURN_SHARE = 0.2
"""Smoothing of the turning: share of a new value taken per moment."""


@kernel("void(f8[:,::1], f4[::1], f4[:,::1], f4[:,::1], i4[::1])")
def joint_positions(joint: Float64, hips: Float32, rotation: Float32, offsets: Float32, parents: Int32) -> None:
    """Write the world positions `joint` (J, 3) [m] of a pose: `hips` (3,) [m] and local `rotation` (J, 4)."""
    count = parents.shape[0]
    world = np.empty((count, 4))
    for j in range(count):
        local = rotation_row(rotation, j)
        q = (local[0] + 0.0, local[1] + 0.0, local[2] + 0.0, local[3] + 0.0)
        p = parents[j]
        if p < 0:
            for c in range(3):
                joint[j, c] = hips[c]
        else:
            above = (world[p, 0], world[p, 1], world[p, 2], world[p, 3])
            x, y, z = rotate_vector(above, offsets[j, 0], offsets[j, 1], offsets[j, 2])
            joint[j, 0], joint[j, 1], joint[j, 2] = joint[p, 0] + x, joint[p, 1] + y, joint[p, 2] + z
            q = multiply(above, q)
        world[j, 0], world[j, 1], world[j, 2], world[j, 3] = q


@inline_kernel
def _distance(joint: Float64, a: int, b: int) -> float:
    x, y, z = joint[a, 0] - joint[b, 0], joint[a, 1] - joint[b, 1], joint[a, 2] - joint[b, 2]
    return math.sqrt(x * x + y * y + z * z)


@inline_kernel
def _speed(joint: Float64, before: Float64, j: int, rate: float) -> float:
    x, y, z = joint[j, 0] - before[j, 0], joint[j, 1] - before[j, 1], joint[j, 2] - before[j, 2]
    return rate * math.sqrt(x * x + y * y + z * z)


@kernel("f8(f8[::1], f8[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8, f8, i8[::1], f8, f8)")
def measure_body(
    measure: Float64, feature: Float64, before: Float64, since: Float64, until: Float64, part: float, share: float,
    key: Int64, heading: float, rate: float,
) -> float:  # fmt: skip
    """Write `measure` (MEASURES,) and `feature` (FEATURES,) of the next moment; return the new heading [rad].

    Its joints lie between the poses `since` and `until` (J, 3) [m], by `part`, and are smoothed from those a moment
    earlier, `before` (J, 3), by `share`; `before` then holds them. The turning in `feature` is smoothed from its last
    value there. `rate`: moments a second; `key` (KEY_JOINTS,): the key joints; `heading` [rad]: the last one, kept
    while hips and shoulders point nowhere, as of a lying body.
    """
    joint = np.empty((len(before), 3))
    for j in range(len(before)):
        for c in range(3):
            raw = since[j, c] + part * (until[j, c] - since[j, c])
            joint[j, c] = before[j, c] + share * (raw - before[j, c])
    across_x = joint[LEFT_LEG, 0] - joint[RIGHT_LEG, 0] + joint[LEFT_ARM, 0] - joint[RIGHT_ARM, 0]
    across_z = joint[LEFT_LEG, 2] - joint[RIGHT_LEG, 2] + joint[LEFT_ARM, 2] - joint[RIGHT_ARM, 2]
    new = heading
    if across_x * across_x + across_z * across_z > 0.01:
        new = math.atan2(-across_z, across_x)
    turned = new - heading
    turned -= 2.0 * math.pi * math.floor((turned + math.pi) / (2.0 * math.pi))
    cosine, sine = math.cos(new), math.sin(new)  # left is (cos, -sin), forward is (sin, cos) in (x, z)

    lowest, lowest_joint = 1e9, 1e9
    for j in range(joint.shape[0]):
        lowest_joint = min(lowest_joint, joint[j, 1])
    for leg in (LEFT_LEG, RIGHT_LEG):
        lowest = min(lowest, joint[leg + 2, 1] - ANKLE_HEIGHT, joint[leg + 3, 1] - TOES_HEIGHT)
    for side in range(2):
        arm = RIGHT_ARM if side else LEFT_ARM
        leg = RIGHT_LEG if side else LEFT_LEG
        x, y, z = (
            joint[arm + 2, 0] - joint[arm, 0], joint[arm + 2, 1] - joint[arm, 1], joint[arm + 2, 2] - joint[arm, 2]
        )  # fmt: skip
        out = cosine * x - sine * z
        measure[UP_LEFT + side] = (joint[arm + 2, 1] - joint[HEAD, 1]) / ARM_LENGTH
        measure[LEVEL_LEFT + side] = y / ARM_LENGTH
        measure[OUT_LEFT + side] = (-out if side else out) / ARM_LENGTH
        measure[REACH_LEFT + side] = math.sqrt(x * x + y * y + z * z) / ARM_LENGTH
        measure[KNEE_LEFT + side] = (joint[leg + 1, 1] - lowest) / KNEE_HEIGHT
    measure[HANDS_APART] = _distance(joint, LEFT_ARM + 2, RIGHT_ARM + 2) / ARM_LENGTH
    measure[HIPS_UP] = (joint[HIPS, 1] - lowest) / HIPS_HEIGHT
    measure[HIPS_OVER_ALL] = (joint[HIPS, 1] - lowest_joint) / HIPS_HEIGHT
    measure[TRUNK_UP] = (joint[NECK, 1] - joint[HIPS, 1]) / max(_distance(joint, NECK, HIPS), 1e-6)
    measure[LOWEST] = lowest
    measure[TURNED] = turned

    squares = 0.0
    for j in range(joint.shape[0]):
        speed = _speed(joint, before, j, rate)
        squares += speed * speed
    measure[ENERGY] = math.sqrt(squares / joint.shape[0])
    measure[SPEED] = rate * math.sqrt((joint[0, 0] - before[0, 0]) ** 2 + (joint[0, 2] - before[0, 2]) ** 2)
    measure[SIZE] = (
        _distance(joint, HEAD, HIPS) + _distance(joint, LEFT_ARM + 2, HIPS) + _distance(joint, RIGHT_ARM + 2, HIPS)
        + _distance(joint, LEFT_LEG + 2, HIPS) + _distance(joint, RIGHT_LEG + 2, HIPS)
    ) / (5.0 * BODY_HEIGHT)  # fmt: skip
    hands = 0.5 * (joint[LEFT_ARM + 2, 1] + joint[RIGHT_ARM + 2, 1])
    measure[HANDS_HEIGHT] = (hands - joint[HIPS, 1]) / BODY_HEIGHT
    measure[FEET_SPEED] = _speed(joint, before, LEFT_LEG + 2, rate) + _speed(joint, before, RIGHT_LEG + 2, rate)
    measure[BOUNCE] = rate * (joint[HIPS, 1] - before[HIPS, 1])
    measure[HANDS_SPEED] = _speed(joint, before, LEFT_ARM + 2, rate) + _speed(joint, before, RIGHT_ARM + 2, rate)

    for k in range(KEY_JOINTS):
        j = key[k]
        x, y, z = joint[j, 0] - joint[0, 0], joint[j, 1] - joint[0, 1], joint[j, 2] - joint[0, 2]
        feature[3 * k], feature[3 * k + 1], feature[3 * k + 2] = cosine * x - sine * z, y, sine * x + cosine * z
    feature[3 * KEY_JOINTS] = joint[HIPS, 1] - lowest
    turning = TURN_SECONDS * rate * ARM_LENGTH * turned
    feature[3 * KEY_JOINTS + 1] += TURN_SHARE * (turning - feature[3 * KEY_JOINTS + 1])
    before[:] = joint
    return new


@kernel("void(f8[::1], f8[::1], f8[::1], f8[:,::1], f8[:,::1], f8[::1], i8, f8, f8, f8, f8)")
def follow_movement(
    level: Float64, smooth: Float64, drift: Float64, signal: Float64, repeat: Float64, measure: Float64, newest: int,
    level_share: float, jitter_share: float, drift_share: float, repeat_share: float,
) -> None:  # fmt: skip
    """Take the next moment `measure` (MEASURES,) into what a movement is told by.

    `level` (4,): energy, size, speed and height of the hands, smoothed. `signal` (3, L): rings of the speed of the
    feet, the bounce and the speed of the hands, written at `newest`: smoothed (`smooth`), without their `drift`.
    `repeat` (3, L): the mean product of each with itself so many moments before, in which the past fades.
    """
    now = (measure[ENERGY], measure[SIZE], measure[SPEED], measure[HANDS_HEIGHT])
    for row in range(4):
        level[row] += level_share * (now[row] - level[row])
    heard = (measure[FEET_SPEED], measure[BOUNCE], measure[HANDS_SPEED])
    size = signal.shape[1]
    for row in range(3):
        smooth[row] += jitter_share * (heard[row] - smooth[row])
        drift[row] += drift_share * (smooth[row] - drift[row])
        value = smooth[row] - drift[row]
        signal[row, newest] = value
        for lag in range(newest + 1):
            repeat[row, lag] += repeat_share * (value * signal[row, newest - lag] - repeat[row, lag])
        for lag in range(newest + 1, size):
            repeat[row, lag] += repeat_share * (value * signal[row, newest - lag + size] - repeat[row, lag])


COST, TWO, ONE = range(3)
"""Planes of a matcher's memory: costs at the last moment; best sums at the last moment but one, and at the last one.
Each has a value for every moment of every example."""


@kernel("void(f8[::1], i8[::1], f8[:,::1], i8[:,::1], f8[::1], f4[:,::1], f4[:,::1], i8[::1], i8)")
def follow_examples(
    end_sum: Float64, end_start: Int64, memory: Float64, begun: Int64, feature: Float64,
    moment: Float32, weight: Float32, first: Int64, now: int,
) -> None:  # fmt: skip
    """Match all examples with the motion up to the moment number `now`, whose features are `feature` (F,).

    Subsequence matching as in SPRING (Sakurai et al. 2007): a match may begin at any moment, and each cell keeps the
    moment at which its own began. The step pattern is that of Sakoe and Chiba (1978, slope constraint 1): the motion
    runs at half to twice the example's speed, and each moment of the example counts once, so that a sum divided by the
    example's length is a mean cost. `memory` (3, N) and `begun` (2, N): sums and starts of the two moments before, see
    `COST`. Examples are rows `first[e]` to `first[e + 1]` of `moment` (N, F); `weight` (E, F). Written: `end_sum` (E,)
    the mean cost of the best match that ends now, and `end_start` (E,) when it began.
    """
    features = feature.shape[0]
    for e in range(end_sum.shape[0]):
        start, end = first[e], first[e + 1]
        # sums of the two moments before, of the example's moments before; the example's moment before the first is free
        cost_before = 0.0
        one_a, one_b, two_a = 0.0, 0.0, 0.0  # one: a moment ago, of the example's last moment and the last but one
        begun_one_a, begun_one_b, begun_two_a = now, now, now - 1
        for row in range(start, end):
            cost, cost_b, cost_c, cost_d = 0.0, 0.0, 0.0, 0.0  # four sums, because an addition waits for the last one
            for f in range(0, features - 3, 4):
                way, way_b = feature[f] - moment[row, f], feature[f + 1] - moment[row, f + 1]
                way_c, way_d = feature[f + 2] - moment[row, f + 2], feature[f + 3] - moment[row, f + 3]
                cost, cost_b = cost + weight[e, f] * way * way, cost_b + weight[e, f + 1] * way_b * way_b
                cost_c, cost_d = cost_c + weight[e, f + 2] * way_c * way_c, cost_d + weight[e, f + 3] * way_d * way_d
            cost = (cost + cost_b) + (cost_c + cost_d)
            for f in range(features // 4 * 4, features):
                way = feature[f] - moment[row, f]
                cost += weight[e, f] * way * way
            best, began = one_a + cost, begun_one_a
            if row > start:
                other = one_b + cost_before + cost
                if other < best:
                    best, began = other, begun_one_b
            other = two_a + 0.5 * (memory[COST, row] + cost)
            if other < best:
                best, began = other, begun_two_a
            one_b, begun_one_b = one_a, begun_one_a
            one_a, begun_one_a = memory[ONE, row], begun[1, row]
            two_a, begun_two_a = memory[TWO, row], begun[0, row]
            cost_before = cost
            memory[COST, row] = cost
            memory[TWO, row], begun[0, row] = memory[ONE, row], begun[1, row]
            memory[ONE, row], begun[1, row] = best, began
        end_sum[e] = memory[ONE, end - 1] / (end - start)
        end_start[e] = begun[1, end - 1]


USUAL_SECONDS = 15.0
USUAL_SHARE = 1.0 / (16.0 * USUAL_SECONDS)
"""Time constant of a gesture's usual cost [s], and the share of a new moment in it at 16 moments a second."""
USUAL_POWER = 0.65
USUAL_FACTOR = 0.185
"""A limit is `USUAL_FACTOR` times the usual cost [m²] to the power of `USUAL_POWER`, …"""
LEAST_LIMIT, MOST_LIMIT = 0.5, 2.0
"""… within these shares of the example's threshold."""
STILL_STEP = 0.006
"""Root mean square of a key joint's way in a moment [m] below which a body is taken to stand: about 0.1 m/s."""
MOST_USUAL = 100.0
"""A cost, in thresholds, beyond which no example was compared yet."""


@inline_kernel
def _follow_usual(
    least: Float64, best: Float64, usual: Float64, limit: Float64, scale: Float64, end_sum: Float64,
    threshold: Float64, gesture: Int64, feature: Float64, before: Float64, none_waits: float,
) -> int:  # fmt: skip
    """Update what is usual of each gesture, and its limit; return how many are within it or wait to be told."""
    moved = 0.0
    for f in range(3 * KEY_JOINTS):
        moved += (feature[f] - before[f]) ** 2
    before[:] = feature
    moves = moved > KEY_JOINTS * STILL_STEP**2
    for g in range(best.shape[0]):
        least[g] = MOST_USUAL
    for e in range(end_sum.shape[0]):
        least[gesture[e]] = min(least[gesture[e]], end_sum[e] / threshold[e])
    near = 0
    for g in range(best.shape[0]):
        if moves and least[g] < MOST_USUAL:
            usual[g] += USUAL_SHARE * (math.log(max(least[g], 1e-6)) - usual[g])
            limit[g] = min(max(scale[g] * math.exp(USUAL_POWER * usual[g]), LEAST_LIMIT), MOST_LIMIT)
        near += least[g] <= limit[g] or best[g] < none_waits
    return near


@kernel(
    "i8(i8[::1], f8[::1], f8[::1], i8[:,::1], i8[::1], f8[::1], f8[::1], f8[::1], f8[::1], i8[::1], f8[::1], i8[::1], "
    "f8[::1], f8[::1], i8, i8, i8, f8, f8)"
)
def tell_gestures(
    told: Int64, least: Float64, best: Float64, times: Int64, ended: Int64, usual: Float64, limit: Float64,
    scale: Float64, end_sum: Float64, end_start: Int64, threshold: Float64, gesture: Int64, feature: Float64,
    before: Float64, now: int, wait: int, longest_wait: int, overlap: float, none_waits: float,
) -> int:  # fmt: skip
    """Tell each match of a gesture once, at its best end; return how many are told at the moment `now`.

    `told` (G,): their gestures, the first ones. Of each gesture's waiting match `best` (G,) is its cost in limits, or
    `none_waits`, and `times` (3, G) its beginning, when its best end was and when it was first found; `ended` (G,):
    when the last told one ended. `end_sum`, `end_start` (E,): see `follow_examples`; `threshold` (E,) and `gesture`
    (E,) of each example. A match is told `wait` moments after its best end, or `longest_wait` after it was found,
    unless another gesture's waiting match at the same time is nearer. A match may begin before the last told one of its
    gesture has ended, by `overlap` of its length.

    An example's limit is its threshold times its gesture's `limit` (G,), which follows how near this motion usually
    comes to the nearest example, as scores are normalised by a background's (Reynolds et al. 2000, "Speaker
    verification"): another body and a camera's errors raise the cost of all matches alike, and the nearest of several
    examples is nearer. `usual` (G,): mean logarithm of the least cost in thresholds while the body moves; `scale` (G,):
    see `USUAL_FACTOR`. `least` (G,) is scratch; `before` (F,) are the features of the last moment, and then `feature`.
    """
    if not _follow_usual(least, best, usual, limit, scale, end_sum, threshold, gesture, feature, before, none_waits):
        return 0
    count = 0
    for e in range(end_sum.shape[0]):
        g, begun = gesture[e], end_start[e]
        share = end_sum[e] / (threshold[e] * limit[g])
        if share > 1.0 or share >= best[g] or begun < ended[g] - overlap * (now - begun):
            continue
        if best[g] == none_waits:
            times[2, g] = now
        best[g], times[0, g], times[1, g] = share, begun, now
    for g in range(best.shape[0]):
        if best[g] == none_waits or (now - times[1, g] < wait and now - times[2, g] < longest_wait):
            continue
        begun, end, better = times[0, g], times[1, g], False
        for other in range(best.shape[0]):
            both = min(times[1, other], end) - max(times[0, other], begun)
            better |= best[other] < best[g] and both > 0.5 * (end - begun)
        best[g] = none_waits
        if not better:
            ended[g], told[count] = now, g
            count += 1
    return count


@kernel("UniTuple(f8, 2)(f8[::1], f8[:,::1], f8[::1], f8[::1], f8, f8, f8, i8)")
def rate_periods(
    rating: Float64, repeat: Float64, period: Float64, weight: Float64, share: float, likely: float, spread: float,
    near: int,
) -> tuple[float, float]:  # fmt: skip
    """Rate each beat period `period` (P,) [moments] by how well the motion repeats after one, two, four and eight of
    it, with `weight` (4,); return the best one and how far it stands out.

    `repeat` (K, L): see `follow_movement`. `rating` (P,) takes in a new one by `share`. The best period is the best
    rated one among `near` neighbours, on each side, of the best by rating and nearness to `likely` [moments], with a
    standard deviation of `spread` octaves. It stands out by so many standard deviations of all ratings.
    """
    lags, candidates = repeat.shape[1], period.shape[0]
    mean, squares, highest, place = 0.0, 0.0, -1e9, 0
    for p in range(candidates):
        total, sums = 0.0, 0.0
        for r in range(4):
            lag = period[p] * (1 << r)
            whole = int(lag)
            if whole + 1 < lags and weight[r] > 0.0:
                part = lag - whole
                for k in range(repeat.shape[0]):
                    between = repeat[k, whole] + part * (repeat[k, whole + 1] - repeat[k, whole])
                    total += weight[r] * between / (repeat[k, 0] + 1e-9)
                sums += weight[r]
        rating[p] += share * (total / max(sums, 1e-9) - rating[p])
        mean += rating[p] / candidates
        squares += rating[p] * rating[p] / candidates
        away = math.log2(period[p] / likely) / spread
        preferred = (rating[p] + 1.0) * math.exp(-0.5 * away * away)
        if preferred > highest:
            highest, place = preferred, p
    best = place
    for p in range(max(place - near, 0), min(place + near + 1, candidates)):
        if rating[p] > rating[best]:
            best = p
    return period[best], (rating[best] - mean) / math.sqrt(max(squares - mean * mean, 1e-12))
