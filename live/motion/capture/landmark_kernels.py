"""Kernels for bodies seen by cameras: landmarks to rotations of joints, One Euro filter, feet that stand.

Rotations are quaternions (w, x, y, z) in double precision. The loops cover 22 joints of one person, so there are no
blocks.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.capture.capture_kernels import inverse, nlerp, rotate_vector, rotation_row
from live.motion.pose.hand_hold_kernels import multiply

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]
Vector = tuple[float, float, float]
Rotation = tuple[float, float, float, float]

WRONG_WAY = -0.2
"""Cosine between a bend's hinge and that which the neighbours tell, under which the limb is bent the wrong way."""
STRAIGHT = 0.4
"""Sine of a bend under which a limb's hinge comes more and more from its neighbours instead of from the bend."""
HIPS, CHEST, HEAD, UPPER, LOWER, END, FRAMES = 0, 1, 2, 3, 7, 11, 15
"""Rows of the frames: pelvis, chest, head; four limbs' upper and lower bones and ends (left and right arm, left and
right leg)."""
NOSE, LEFT_EYE, RIGHT_EYE, LEFT_EAR, RIGHT_EAR, LEFT_MOUTH, RIGHT_MOUTH = 0, 2, 5, 7, 8, 9, 10
SHOULDER, ELBOW, WRIST, PINKY, INDEX, HIP, KNEE, ANKLE, HEEL, TOE = 11, 13, 15, 17, 19, 23, 25, 27, 29, 31
"""Rows of landmarks; of those with two sides the left one, after which the right one follows."""


@inline_kernel
def row(points: Any, n: int) -> Vector:
    return points[n, 0], points[n, 1], points[n, 2]


@inline_kernel
def middle(points: Any, n: int) -> Vector:
    """Return the middle between a left landmark and the right one after it."""
    return (
        0.5 * (points[n, 0] + points[n + 1, 0]),
        0.5 * (points[n, 1] + points[n + 1, 1]),
        0.5 * (points[n, 2] + points[n + 1, 2]),
    )


@inline_kernel
def less(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inline_kernel
def mixed(a: Vector, s: float, b: Vector, t: float) -> Vector:
    """Return s a + t b."""
    return s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]


@inline_kernel
def dot(a: Vector, b: Vector) -> float:
    product: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


@inline_kernel
def cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inline_kernel
def unit(a: Vector) -> Vector:
    scale = 1.0 / max(math.sqrt(dot(a, a)), 1e-9)
    return a[0] * scale, a[1] * scale, a[2] * scale


@inline_kernel
def _write(rows: Any, n: int, a: Any) -> None:
    for c in range(len(a)):
        rows[n, c] = a[c]


@kernel("void(f8[::1], f8[::1], f8[::1])")
def frame_rotation(rotation: Float64, along: Float64, side: Float64) -> None:
    """Write the `rotation` (4,) from x to `along` (3,) and from y to the part of `side` (3,) normal to it.

    Where that is nothing, y goes to any normal (Shepperd's method).
    """
    x = unit((along[0], along[1], along[2]))
    y = (side[0], side[1], side[2])
    y = mixed(y, 1.0, x, -dot(x, y))
    if dot(y, y) < 1e-12:
        y = cross(x, (0.0, 0.0, 1.0)) if abs(x[2]) < 0.9 else cross(x, (1.0, 0.0, 0.0))
    y = unit(y)
    z = cross(x, y)
    trace = x[0] + y[1] + z[2]
    if trace > max(x[0], y[1], z[2]):
        w, i, j, k = 1.0 + trace, y[2] - z[1], z[0] - x[2], x[1] - y[0]
    elif x[0] >= y[1] and x[0] >= z[2]:
        w, i, j, k = y[2] - z[1], 1.0 + x[0] - y[1] - z[2], y[0] + x[1], z[0] + x[2]
    elif y[1] >= z[2]:
        w, i, j, k = z[0] - x[2], y[0] + x[1], 1.0 - x[0] + y[1] - z[2], z[1] + y[2]
    else:
        w, i, j, k = x[1] - y[0], z[0] + x[2], z[1] + y[2], 1.0 - x[0] - y[1] + z[2]
    scale = 1.0 / math.sqrt(w * w + i * i + j * j + k * k)
    rotation[0], rotation[1], rotation[2], rotation[3] = w * scale, i * scale, j * scale, k * scale


@inline_kernel
def _limb_sides(points: Float64, m: int, aside: Vector, forward: Vector, upper: Vector, lower: Vector) -> Vector:
    """Return the hinge that the neighbours tell of limb m if it is straight.

    A knee's axis is that of pelvis and foot. A straight arm's elbow points back and down.
    """
    if m < 2:
        sign = -1.0 if m == 0 else 1.0
        across = cross(forward, mixed(upper, -sign, upper, 0.0))
        return mixed(across, sign, (0.0, 1.0, 0.0), 0.15 * sign)
    foot = unit(less(row(points, TOE + m - 2), row(points, HEEL + m - 2)))
    across = cross(foot, lower)
    return mixed(across, 1.0 if dot(across, aside) >= 0.0 else -1.0, aside, 0.7)


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1])")
def find_directions(along: Float64, side: Float64, points: Float64) -> None:
    """Write the two axes of each frame, `along` and `side` (15, 3), from landmarks `points` (33, 3) in stage axes."""
    hips, top = middle(points, HIP), middle(points, SHOULDER)
    trunk = less(top, hips)
    aside = unit(less(row(points, HIP), row(points, HIP + 1)))
    forward = cross(aside, unit(trunk))
    ears = middle(points, LEFT_EAR)
    _write(along, HIPS, aside)
    _write(side, HIPS, trunk)
    _write(along, CHEST, less(row(points, SHOULDER), row(points, SHOULDER + 1)))
    _write(side, CHEST, trunk)
    _write(side, HEAD, less(row(points, LEFT_EAR), row(points, RIGHT_EAR)))
    for c in range(3):
        eyes = points[LEFT_EYE, c] + points[RIGHT_EYE, c]
        mouth = points[LEFT_MOUTH, c] + points[RIGHT_MOUTH, c]
        along[HEAD, c] = 0.2 * (points[NOSE, c] + eyes + mouth) - ears[c]
    for m in range(4):
        first = SHOULDER + m if m < 2 else HIP + m - 2
        begin, joint, end = row(points, first), row(points, first + 2), row(points, first + 4)
        upper, lower = unit(less(joint, begin)), unit(less(end, joint))
        sides = _limb_sides(points, m, aside, forward, upper, lower)
        sides = unit(mixed(sides, 1.0, upper, -dot(sides, upper)))
        normal = cross(upper, lower)
        size = math.sqrt(dot(normal, normal))
        trust = min(size / STRAIGHT, 1.0) ** 2
        hinge = sides
        if dot(normal, sides) >= WRONG_WAY * size:
            hinge = unit(mixed(sides, 1.0 - trust, normal, trust / max(size, 1e-9)))
        bend = max(math.atan2(dot(lower, cross(hinge, upper)), dot(lower, upper)), 0.0)
        half = 0.5 * bend
        reach = unit(less(end, begin))
        out = cross(reach, hinge)
        _write(along, UPPER + m, mixed(reach, math.cos(half), out, math.sin(half)))
        _write(along, LOWER + m, mixed(reach, math.cos(half), out, -math.sin(half)))
        _write(side, UPPER + m, hinge)
        _write(side, LOWER + m, hinge)
        if m < 2:
            index, pinky = row(points, INDEX + m), row(points, PINKY + m)
            _write(along, END + m, less(mixed(index, 0.5, pinky, 0.5), end))
            _write(side, END + m, less(index, pinky))
        else:
            _write(along, END + m, less(row(points, TOE + m - 2), row(points, HEEL + m - 2)))
            _write(side, END + m, hinge)


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i8[::1], f8[:,::1], i8[::1])")
def pose_joints(
    world: Float64, along: Float64, side: Float64, rest: Float64, posed: Int64, mixes: Float64, same: Int64
) -> None:
    """Write `world` rotations (J, 4) from the axes of 15 frames and the inverse of their rest rotations `rest` (15, 4).

    `posed` (15,): joint of each frame; `mixes` (M, 4): joints between two others: joint, the two, share of the second;
    `same` (2 S,): joints that turn with another: joint, other, and so on.
    """
    turned = np.empty(4)
    for n in range(posed.shape[0]):
        frame_rotation(turned, along[n], side[n])
        _write(world, posed[n], multiply((turned[0], turned[1], turned[2], turned[3]), rotation_row(rest, n)))
    for n in range(mixes.shape[0]):
        a, b = rotation_row(world, int(mixes[n, 1])), rotation_row(world, int(mixes[n, 2]))
        _write(world, int(mixes[n, 0]), nlerp(a, b, mixes[n, 3]))
    for n in range(0, same.shape[0], 2):
        _write(world, same[n], rotation_row(world, same[n + 1]))


@inline_kernel
def _turned(q: Rotation, x: float, y: float, z: float) -> Rotation:
    """Return q turned in its own axes by the rotation vector x, y, z [rad]."""
    angle = math.sqrt(x * x + y * y + z * z)
    scale = math.sin(0.5 * angle) / angle if angle > 1e-9 else 0.5
    p = multiply(q, (math.cos(0.5 * angle), x * scale, y * scale, z * scale))
    size = 1.0 / math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3])
    return p[0] * size, p[1] * size, p[2] * size, p[3] * size


@inline_kernel
def _way(a: Rotation, b: Rotation) -> Vector:
    """Return the rotation vector from a to b in the axes of a [rad]."""
    way = multiply(inverse(a), b)
    sign = 1.0 if way[0] >= 0.0 else -1.0
    sine = math.sqrt(way[1] ** 2 + way[2] ** 2 + way[3] ** 2)
    scale = sign * 2.0 * (math.atan2(sine, sign * way[0]) / sine if sine > 1e-9 else 1.0)
    return way[1] * scale, way[2] * scale, way[3] * scale


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i4[::1], f8[::1], f8, f8[::1])")
def filter_rotations(
    value: Float64, speed: Float64, last: Float64, world: Float64, parents: Any, trust: Float64, dt: float,
    settings: Float64,
) -> None:  # fmt: skip
    """Filter local rotations `value` (J, 4) and their `speed` (J, 3) [rad/s] towards those of `world` (J, 4).

    `last` (J, 4): the unfiltered local rotations of the last time, updated.

    `trust` (J,) slows joints; `settings`: cut-off [Hz], its gain [Hz per rad/s], cut-off of the speed [Hz]. `dt` [s];
    0 takes the rotations as they are.
    """
    for j in range(parents.shape[0]):
        q = rotation_row(world, j)
        if j > 0:
            q = multiply(inverse(rotation_row(world, parents[j])), q)
        if dt <= 0.0:
            _write(value, j, q)
            _write(last, j, q)
            for c in range(3):
                speed[j, c] = 0.0
            continue
        pace = 2.0 * math.pi * settings[2] * dt
        follow, total = trust[j] * pace / (1.0 + pace), 0.0
        moved = _way(rotation_row(last, j), q)
        for c in range(3):
            speed[j, c] += follow * (moved[c] / dt - speed[j, c])
            total += speed[j, c] ** 2
        _write(last, j, q)
        old = rotation_row(value, j)
        way = _way(old, q)
        pace = 2.0 * math.pi * (settings[0] + settings[1] * math.sqrt(total)) * trust[j] * dt
        part = pace / (1.0 + pace)
        _write(value, j, _turned(old, way[0] * part, way[1] * part, way[2] * part))


@kernel("void(f8[:,::1], f8[:,::1], f8[:,::1], f8)")
def predict_rotations(out: Float64, value: Float64, speed: Float64, lead: float) -> None:
    """Write the rotations `out` (J, 4) that `value` reaches in `lead` [s] at its `speed` (J, 3)."""
    for j in range(out.shape[0]):
        _write(out, j, _turned(rotation_row(value, j), lead * speed[j, 0], lead * speed[j, 1], lead * speed[j, 2]))


THIGH, SHIN, FOOT, TOES = 0, 1, 2, 3
"""Columns of `legs`: joints of each leg."""


@inline_kernel
def _offset(offsets: Float64, legs: Int64, side: int, part: int, q: Rotation) -> Vector:
    """Return the way to a leg's joint from its parent, which is turned by q."""
    j = legs[side, part]
    return rotate_vector(q, offsets[j, 0], offsets[j, 1], offsets[j, 2])


@kernel("void(f8[:,:,::1], f8[::1], f8[:,::1], f8[:,::1], i8[:,::1])")
def find_feet(feet: Float64, hips: Float64, rotation: Float64, offsets: Float64, legs: Int64) -> None:
    """Write the places of ankle and toe joint of both `feet` (2, 2, 3) [m] of a pose with local `rotation` (J, 4)."""
    for s in range(2):
        q = rotation_row(rotation, 0)
        p = (hips[0], hips[1], hips[2])
        for k in range(4):
            p = mixed(p, 1.0, _offset(offsets, legs, s, k, q), 1.0)
            q = multiply(q, rotation_row(rotation, legs[s, k]))
            if k >= 2:
                feet[s, k - 2, 0], feet[s, k - 2, 1], feet[s, k - 2, 2] = p


FLAT, AGE, SHIFT, TARGET, FOOT_COLUMNS = 0, 1, 2, 5, 8
"""Columns of a foot's state: how flat it is held (0 to 1), whether it was planted before, its shift [m], its place."""


@inline_kernel
def _soft_length(far: float, upper: float, lower: float, softness: float) -> float:
    """Return how long a leg becomes towards a place that is so `far`: the last share is approached, never reached."""
    whole = upper + lower
    limit, soft = (1.0 - softness) * whole, softness * whole
    if far > limit:
        return whole - soft * math.exp((limit - far) / soft)
    return max(far, abs(upper - lower) + 1e-3)


@inline_kernel
def _hold_place(
    state: Float64, s: int, ankle: Vector, planted: bool, slip: float, back: float, landing: Vector
) -> None:  # fmt: skip
    """Update a foot's horizontal shift: to the place where it was planted, or back to where it is seen.

    `landing`: what is added to the place of a foot that lands [m].
    """
    if planted and state[s, AGE] == 0.0:
        for c in range(3):
            state[s, SHIFT + c] += landing[c]
            state[s, TARGET + c] = ankle[c] + state[s, SHIFT + c]
    state[s, AGE] = 1.0 if planted else 0.0
    far = math.hypot(state[s, TARGET] - ankle[0], state[s, TARGET + 2] - ankle[2])
    keep = min(slip / max(far, 1e-9), 1.0)
    for c in range(0, 3, 2):
        if planted:
            state[s, SHIFT + c] = keep * (state[s, TARGET + c] - ankle[c])
            state[s, TARGET + c] = ankle[c] + state[s, SHIFT + c]
        else:
            state[s, SHIFT + c] *= back


@inline_kernel
def _carry_hips(
    hips: Float64, drift: Float64, contact: Bool, unsure: Float64, settings: Float64, dt: float
) -> None:  # fmt: skip
    """Move the hips by the `drift` (1,) [m] along `unsure`, which fades while no foot stands."""
    if not (contact[0] or contact[1]):
        drift[0] *= 0.5 ** (dt / settings[7])
    drift[0] = min(max(drift[0], -settings[8]), settings[8])
    hips[0] += drift[0] * unsure[0]
    hips[2] += drift[0] * unsure[1]


@inline_kernel
def _pull_hips(
    hips: Float64, state: Float64, drift: Float64, contact: Bool, unsure: Float64, goal: Float64, tops: Float64
) -> None:  # fmt: skip
    """Move the hips along `unsure` with the planted feet, so that these need not be shifted that way."""
    count = contact[0] + contact[1]
    pulled = 0.0
    for s in range(2):
        if contact[s]:
            pulled += (state[s, SHIFT] * unsure[0] + state[s, SHIFT + 2] * unsure[1]) / count
    drift[0] += pulled
    for c in range(0, 3, 2):
        hips[c] += pulled * unsure[c // 2]
        for s in range(2):
            tops[s, c] += pulled * unsure[c // 2]
            if contact[s]:
                state[s, SHIFT + c] -= pulled * unsure[c // 2]
            else:
                goal[s, c] += pulled * unsure[c // 2]


@kernel("void(f8[::1], f8[:,::1], f8[:,::1], f8[::1], b1[::1], f8[::1], f8[:,::1], i8[:,::1], f8[::1], f8[::1], f8)")
def plant_feet(
    hips: Float64, rotation: Float64, state: Float64, drift: Float64, contact: Bool, unsure: Float64, offsets: Float64,
    legs: Int64, rest: Float64, settings: Float64, dt: float,
) -> None:  # fmt: skip
    """Plant the feet in `contact` (2,): changes `hips` (3,) [m] and the legs of local `rotation` (J, 4), the state
    (2, 8), and the `drift` (1,) [m] of the hips along `unsure` (2,), the unit direction (x, z) in which their place is
    least sure, or zero.

    `rest` (4,): inverse rest rotation of a leg's frame. `settings`: longest shift of a planted foot [m], half-life of
    a released foot's return and of flattening [s], softness of a stretched leg, heights of ankle and toe joint of a
    standing foot [m], longest drop of the hips [m], half-life of the drift in the air [s], most drift [m], share of the
    drift that a foot which lands takes back.
    """
    turned, goal, tops = np.empty(4), np.empty((2, 3)), np.empty((2, 3))
    along, hinge, foot_turn = np.empty(3), np.empty(3), np.empty((2, 4))
    slip, back, flatten, softness = settings[0], 0.5 ** (dt / settings[1]), 0.5 ** (dt / settings[2]), settings[3]
    pelvis = rotation_row(rotation, 0)
    drop = 0.0
    _carry_hips(hips, drift, contact, unsure, settings, dt)
    for s in range(2):
        top = mixed((hips[0], hips[1], hips[2]), 1.0, _offset(offsets, legs, s, THIGH, pelvis), 1.0)
        thigh = multiply(pelvis, rotation_row(rotation, legs[s, THIGH]))
        shin = multiply(thigh, rotation_row(rotation, legs[s, SHIN]))
        foot = multiply(shin, rotation_row(rotation, legs[s, FOOT]))
        knee = mixed(top, 1.0, _offset(offsets, legs, s, SHIN, thigh), 1.0)
        ankle = mixed(knee, 1.0, _offset(offsets, legs, s, FOOT, shin), 1.0)
        # a planted foot becomes flat, unless the dancer stands on its ball
        ahead, up = rotate_vector(foot, 0.0, 0.0, 1.0), rotate_vector(foot, 0.0, 1.0, 0.0)
        level = 1.0 if contact[s] and up[1] > 0.8 else 0.0
        state[s, FLAT] = level + (state[s, FLAT] - level) * flatten
        yaw = 0.5 * math.atan2(ahead[0], ahead[2])
        foot = nlerp(foot, (math.cos(yaw), 0.0, math.sin(yaw), 0.0), state[s, FLAT])
        _write(foot_turn, s, foot)
        landing = -settings[9] * drift[0]
        _hold_place(state, s, ankle, contact[s], slip, back, (landing * unsure[0], 0.0, landing * unsure[1]))
        toe = _offset(offsets, legs, s, TOES, foot)
        low = min(ankle[1] - settings[4], ankle[1] + toe[1] - settings[5])
        lift = -low if contact[s] or low < 0.0 else 0.0
        state[s, SHIFT + 1] = lift + (state[s, SHIFT + 1] - lift) * back
        if low + state[s, SHIFT + 1] < 0.0:
            state[s, SHIFT + 1] = -low
        for c in range(3):
            goal[s, c], tops[s, c] = ankle[c] + state[s, SHIFT + c], top[c]
    _pull_hips(hips, state, drift, contact, unsure, goal, tops)
    upper = abs(offsets[legs[0, SHIN], 1])
    lower = abs(offsets[legs[0, FOOT], 1])
    limit = (1.0 - softness) * (upper + lower)
    for s in range(2):
        if contact[s]:
            aside = (goal[s, 0] - tops[s, 0]) ** 2 + (goal[s, 2] - tops[s, 2]) ** 2
            drop = max(drop, tops[s, 1] - goal[s, 1] - math.sqrt(max(limit * limit - aside, 0.0)))
    drop = min(drop, settings[6])
    hips[1] -= drop
    for s in range(2):
        top = (tops[s, 0], tops[s, 1] - drop, tops[s, 2])
        thigh = multiply(pelvis, rotation_row(rotation, legs[s, THIGH]))
        reach = less(row(goal, s), top)
        length = _soft_length(math.sqrt(dot(reach, reach)), upper, lower, softness)
        way = unit(reach)
        pole, axis = rotate_vector(thigh, 0.0, 0.0, 1.0), rotate_vector(thigh, 1.0, 0.0, 0.0)
        side = unit(mixed(pole, 1.0, way, -dot(pole, way)))
        deep = (upper * upper - lower * lower + length * length) / (2.0 * length)
        out = math.sqrt(max(upper * upper - deep * deep, 0.0))
        knee = mixed(way, deep, side, out)
        shin_way = less(mixed(way, length, way, 0.0), knee)
        hinge[0], hinge[1], hinge[2] = axis
        along[0], along[1], along[2] = knee
        frame_rotation(turned, along, hinge)
        thigh = multiply((turned[0], turned[1], turned[2], turned[3]), (rest[0], rest[1], rest[2], rest[3]))
        along[0], along[1], along[2] = shin_way
        frame_rotation(turned, along, hinge)
        shin = multiply((turned[0], turned[1], turned[2], turned[3]), (rest[0], rest[1], rest[2], rest[3]))
        _write(rotation, legs[s, THIGH], multiply(inverse(pelvis), thigh))
        _write(rotation, legs[s, SHIN], multiply(inverse(thigh), shin))
        _write(rotation, legs[s, FOOT], multiply(inverse(shin), rotation_row(foot_turn, s)))
