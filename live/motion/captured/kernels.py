"""Captured bodies, one at a time: a strange skeleton's pose onto ours; poses remembered, sampled and worn by dancers.

Quaternions (w, x, y, z) in double precision; the loops run over the 22 joints of few dancers, so there are no blocks.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel, part
from live.base.kernels import angle_wrap

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]
UInt8 = npt.NDArray[np.uint8]
Vector = tuple[float, float, float]
Rotation = tuple[float, float, float, float]

NEAR = 0.05
"""A foot this high [m] over the lower one counts e times less when the hips are placed."""
SHORT = 0.02
"""What is nearer to its parent than this [m] says nothing of where the bone points."""
LEAST_LEG, MOST_LEG = 0.3, 1.8
"""Legs [m] that are believed."""
TIME, BEAT = range(2)
"""Columns of `stamp`: when a remembered pose came [s], and the danced beat at that time."""
KEY, WANTED, CAUGHT, SHARE, PLACE_X, PLACE_Z, YAW, TURNED, ASKED = range(9)
"""Columns of what is asked: by which stamp, of when; how much of that pose, the rest being the one held before a gap;
how much is worn of it, the rest being the dancer's own; where the capture's origin lies [m] and its turn [rad]; and how
far the dancer was turned from her own heading last [rad], whole turns counted."""
_STEPS = 16383


@part
def _times(a: Rotation, b: Rotation) -> Rotation:
    """First b, then a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@part
def _turn(q: Rotation, x: float, y: float, z: float) -> Vector:
    """The vector turned by q."""
    tx, ty, tz = 2.0 * (q[2] * z - q[3] * y), 2.0 * (q[3] * x - q[1] * z), 2.0 * (q[1] * y - q[2] * x)
    return (
        x + q[0] * tx + q[2] * tz - q[3] * ty,
        y + q[0] * ty + q[3] * tx - q[1] * tz,
        z + q[0] * tz + q[1] * ty - q[2] * tx,
    )


@part
def _back(q: Rotation) -> Rotation:
    """The turn back."""
    return q[0], -q[1], -q[2], -q[3]


@part
def _between(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> Rotation:
    """The shortest turn that brings direction a to direction b; none at all where they are opposite."""
    scale = 1.0 / math.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
    w = 1.0 + (ax * bx + ay * by + az * bz) * scale
    x, y, z = (ay * bz - az * by) * scale, (az * bx - ax * bz) * scale, (ax * by - ay * bx) * scale
    size = math.sqrt(w * w + x * x + y * y + z * z)
    if size < 1e-6:
        return 1.0, 0.0, 0.0, 0.0
    return w / size, x / size, y / size, z / size


@part
def _mixed(a: Rotation, b: Rotation, t: float) -> Rotation:
    """From a to b by the shorter way, at the share t of it: the chord, made a rotation again."""
    sign = 1.0 if a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] >= 0.0 else -1.0
    w, x = a[0] + t * (sign * b[0] - a[0]), a[1] + t * (sign * b[1] - a[1])
    y, z = a[2] + t * (sign * b[2] - a[2]), a[3] + t * (sign * b[3] - a[3])
    size = math.sqrt(w * w + x * x + y * y + z * z)
    if size < 1e-9:
        return a
    return w / size, x / size, y / size, z / size


@part
def _heading(q: Rotation) -> float:
    """How far q turns about the vertical [rad]: its twist."""
    return 2.0 * math.atan2(q[2], q[0])


@part
def _vector(q: Rotation) -> Vector:
    """The logarithm of q: axis times half the angle."""
    sine = math.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    sign = 1.0 if q[0] >= 0.0 else -1.0
    scale = sign * math.atan2(sine, abs(q[0])) / sine if sine > 1e-9 else sign
    return q[1] * scale, q[2] * scale, q[3] * scale


@part
def _through_rest(a: Rotation, b: Rotation, t: float) -> Rotation:
    """Between a and b by their turns from the rest pose.

    The shorter way from one to the other may be the other way round a moment later, and then a limb would jump; but no
    joint turns half round from its rest pose.
    """
    ax, ay, az = _vector(a)
    bx, by, bz = _vector(b)
    x, y, z = ax + t * (bx - ax), ay + t * (by - ay), az + t * (bz - az)
    half = math.sqrt(x * x + y * y + z * z)
    scale = math.sin(half) / half if half > 1e-9 else 1.0
    return math.cos(half), x * scale, y * scale, z * scale


@part
def _row(rows: Any, n: int) -> Rotation:
    return rows[n, 0], rows[n, 1], rows[n, 2], rows[n, 3]


@part
def _chain(
    theirs: Float64, ours: Float64, rotation: Float64, bones: Float64, known: Bool, root: Float64,
    offsets: Float32, parents: Int32, limb: Bool,
) -> None:  # fmt: skip
    """Every joint in the world, `theirs` (J, 7) place and rotation, of `ours` (J, 4) the rotation; and that locally."""
    for j in range(parents.shape[0]):
        p = max(parents[j], 0)
        q = (bones[j, 3], bones[j, 4], bones[j, 5], bones[j, 6]) if known[j] else (1.0, 0.0, 0.0, 0.0)
        above, x, y, z = (root[3], root[4], root[5], root[6]), root[0], root[1], root[2]
        if j > 0:
            above = theirs[p, 3], theirs[p, 4], theirs[p, 5], theirs[p, 6]
            x, y, z = theirs[p, 0], theirs[p, 1], theirs[p, 2]
        if known[j]:
            dx, dy, dz = _turn(above, bones[j, 0], bones[j, 1], bones[j, 2])
            x, y, z = x + dx, y + dy, z + dz
        world = _times(above, q)
        theirs[j, 0], theirs[j, 1], theirs[j, 2] = x, y, z
        theirs[j, 3], theirs[j, 4], theirs[j, 5], theirs[j, 6] = world
        if limb[j] and known[j + 1]:
            bx, by, bz = bones[j + 1, 0], bones[j + 1, 1], bones[j + 1, 2]
            if bx * bx + by * by + bz * bz > SHORT * SHORT:
                world = _times(world, _between(offsets[j + 1, 0], offsets[j + 1, 1], offsets[j + 1, 2], bx, by, bz))
        ours[j, 0], ours[j, 1], ours[j, 2], ours[j, 3] = world
        local = _times(_back(_row(ours, p)), world) if j > 0 else world
        rotation[j, 0], rotation[j, 1], rotation[j, 2], rotation[j, 3] = local


@part
def _ratio(bones: Float64, known: Bool, offsets: Float32, legs: Int32) -> float:
    """How long our legs are, theirs being 1; 0 where that is not known or not believed."""
    length, own = 0.0, 0.0
    for side in range(2):
        for k in range(1, 3):
            j = legs[4 * side + k]
            if not known[j]:
                return 0.0
            length += math.sqrt(bones[j, 0] ** 2 + bones[j, 1] ** 2 + bones[j, 2] ** 2)
            own += math.sqrt(offsets[j, 0] ** 2 + offsets[j, 1] ** 2 + offsets[j, 2] ** 2)
    return own / length if 2.0 * LEAST_LEG < length < 2.0 * MOST_LEG else 0.0


@part
def _leg(hips: Float64, ours: Float64, offsets: Float32, legs: Int32, soles: Float64, foot: Float64, side: int) -> None:
    """Where the ankle of a side is, and how high the sole: `foot` (4,) [m]."""
    x, y, z, p = hips[0], hips[1], hips[2], 0
    for k in range(4):
        j = legs[4 * side + k]
        dx, dy, dz = _turn(_row(ours, p), offsets[j, 0], offsets[j, 1], offsets[j, 2])
        x, y, z, p = x + dx, y + dy, z + dz, j
        if k == 2:
            foot[0], foot[1], foot[2] = x, y, z
    foot[3] = min(foot[1] - soles[0], y - soles[1])


@kernel("f8(f8[::1], f8[:,::1], f8[:,::1], b1[::1], f8[::1], f4[:,::1], i4[::1], b1[::1], i4[::1], f8[::1])")
def bring_over(
    hips: Float64, rotation: Float64, bones: Float64, known: Bool, root: Float64,
    offsets: Float32, parents: Int32, limb: Bool, legs: Int32, soles: Float64,
) -> float:  # fmt: skip
    """A captured skeleton's pose on ours: writes `hips` (3,) [m] and local `rotation` (J, 4); returns the height [m]
    of the lowest sole.

    In: `bones` (J, 7) place from the parent [m] and local rotation of the joints that are `known` (J,), in our axes,
    rest pose as ours; `root` (7,) where that skeleton stands; `limb` (J,) joints whose bone, to the next joint, shall
    point where the source's does; `legs` (8,) upper leg, lower leg, foot and toes of both sides; `soles` (2,) heights
    [m] of ankle and toe joint of a standing foot. Sizes are scaled by the length of the legs; the hips are placed so
    that the lower foot is where the source's, scaled, is.
    """
    joints = parents.shape[0]
    theirs, ours, feet = np.empty((joints, 7)), np.empty((joints, 4)), np.empty((2, 4))
    _chain(theirs, ours, rotation, bones, known, root, offsets, parents, limb)
    ratio = _ratio(bones, known, offsets, legs)
    scale = ratio if ratio > 0.0 else 1.0
    for c in range(3):
        hips[c] = scale * theirs[0, c]
    for side in range(2):
        _leg(hips, ours, offsets, legs, soles, feet[side], side)
    left, right = scale * theirs[legs[2], 1], scale * theirs[legs[6], 1]
    one, two = 0.0, 0.0
    if ratio > 0.0:
        one = math.exp(-min(max(left - right, 0.0) / NEAR, 20.0))
        two = math.exp(-min(max(right - left, 0.0) / NEAR, 20.0))
        one, two = one / (one + two), two / (one + two)
    raised = 0.0
    for c in range(3):
        way = one * (scale * theirs[legs[2], c] - feet[0, c]) + two * (scale * theirs[legs[6], c] - feet[1, c])
        hips[c] += way
        if c == 1:
            raised = way
    lowest: float = min(feet[0, 3], feet[1, 3]) + raised
    return lowest


@kernel("void(f4[:,::1], u1[::1])")
def read_rotations(rotation: Float32, data: UInt8) -> None:
    """Write `rotation` (J, 4) as six bytes of `data` for each joint say: see `live.motion.captured.packed_pose`."""
    scale = 1.0 / (math.sqrt(2.0) * _STEPS)
    kept = np.empty(3)
    for j in range(rotation.shape[0]):
        bits = 0
        for k in range(6):
            bits = bits * 256 + data[6 * j + k]
        out, squares = (bits >> 45) & 3, 0.0
        for k in range(3):
            kept[k] = (((bits >> (30 - 15 * k)) & 0x7FFF) - _STEPS) * scale
            squares += kept[k] * kept[k]
        # hostile letters may hold components that no rotation has together
        last, size = math.sqrt(max(1.0 - squares, 0.0)), math.sqrt(max(squares, 1.0))
        n = 0
        for c in range(4):
            if c == out:
                rotation[j, c] = last / size
            else:
                rotation[j, c] = kept[n] / size
                n += 1


@part
def _find(stamp: Float64, count: int, key: int, wanted: float) -> tuple[int, int, float]:
    """The two remembered poses around `wanted`, and how far it is from the first to the second."""
    size = stamp.shape[0]
    newer = (count - 1) % size
    if stamp[newer, key] <= wanted:
        return newer, newer, 0.0
    for back in range(2, min(count, size) + 1):
        older = (count - back) % size
        if stamp[older, key] <= wanted:
            gap = stamp[newer, key] - stamp[older, key]
            return older, newer, (wanted - stamp[older, key]) / gap if gap > 1e-9 else 1.0
        newer = older
    return newer, newer, 0.0


@part
def _between_two(root: Float32, held: int, i: int, j: int, t: float, caught: float, c: int) -> float:
    """A coordinate of the hips between two remembered poses, or on the way to there from the one that was held."""
    value = root[i, c] + t * (root[j, c] - root[i, c])
    mixed: float = root[held, c] + caught * (value - root[held, c])
    return mixed


@part
def _stood(
    root: Float32, held: int, i: int, j: int, t: float, asked: Float64, n: int, scale: float, mirrored: bool
) -> Vector:
    """Where the hips of what row `n` asks for are on the stage [m]."""
    caught = asked[n, CAUGHT]
    x = _between_two(root, held, i, j, t, caught, 0) * (-scale if mirrored else scale)
    y = _between_two(root, held, i, j, t, caught, 1)
    z = _between_two(root, held, i, j, t, caught, 2) * scale
    c, s = math.cos(asked[n, YAW]), math.sin(asked[n, YAW])
    return asked[n, PLACE_X] + c * x + s * z, y, asked[n, PLACE_Z] + c * z - s * x


@part
def _rotated(turned: Float32, held: int, i: int, j: int, t: float, caught: float, joint: int, mirrored: bool) -> Any:
    """The local rotation of a joint, likewise."""
    q = _mixed(_row(turned[i], joint), _row(turned[j], joint), t)
    if caught < 1.0:
        q = _mixed(_row(turned[held], joint), q, caught)
    return (q[0], q[1], -q[2], -q[3]) if mirrored else q


@part
def _about_vertical(angle: float) -> Rotation:
    return math.cos(0.5 * angle), 0.0, math.sin(0.5 * angle), 0.0


@kernel("void(f8[:,::1], f8[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], i8, f8, b1)")
def where_captured(
    place: Float64, asked: Float64, root: Float32, turned: Float32, stamp: Float64, count: int, scale: float,
    mirrored: bool,
) -> None:  # fmt: skip
    """Where the hips of what is `asked` (n, 8) are on the stage: `place` (n, 4), x, y, z [m] and their heading [rad];
    the rest as in `wear`."""
    held = stamp.shape[0]
    for n in range(asked.shape[0]):
        i, j, t = _find(stamp, count, int(asked[n, KEY]), asked[n, WANTED])
        place[n, 0], place[n, 1], place[n, 2] = _stood(root, held, i, j, t, asked, n, scale, mirrored)
        place[n, 3] = asked[n, YAW] + _heading(_rotated(turned, held, i, j, t, asked[n, CAUGHT], 0, mirrored))


@kernel(
    "void(f8[:,::1], f8[:,::1], f8[::1], i8[::1], b1[::1], f8[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], i8, f8, b1,"
    " f4[:,::1], f4[:,:,::1])"
)
def find_places(
    there: Float64, way: Float64, away: Float64, rows: npt.NDArray[np.int64], live: Bool, asked: Float64,
    root: Float32, turned: Float32, stamp: Float64, count: int, scale: float, mirrored: bool,
    shown: Float32, legs: Float32,
) -> None:  # fmt: skip
    """Where the dancers `rows` (n,), who are `live` (n,), are seen in a tick: `there` (n, 2) [m]; how far those who are
    wholly captured have gone from where their own dance has them, `way` (n, 2) [m]; and the turn from their own heading
    to the captured one, `away` (n,) [rad]: where both are mixed it goes on from the last tick's, so that nobody swings
    round. `shown` (A, 2): where their own hips are, `legs` (A, 9, 4) how turned; the rest as in `wear`.
    """
    held = stamp.shape[0]
    for n in range(rows.shape[0]):
        a, share, caught = rows[n], asked[n, SHARE], asked[n, CAUGHT]
        i, j, t = _find(stamp, count, int(asked[n, KEY]), asked[n, WANTED])
        x, _, z = _stood(root, held, i, j, t, asked, n, scale, mirrored)
        way[n, 0], way[n, 1] = x - shown[a, 0], z - shown[a, 1]
        for c in range(2):
            there[n, c] = shown[a, c] + share * way[n, c]
            if not live[n] or share < 1.0:
                way[n, c] = 0.0
        turn = (
            asked[n, YAW] + _heading(_rotated(turned, held, i, j, t, caught, 0, mirrored)) - _heading(_row(legs[a], 0))
        )
        near = away[n] if 0.0 < share < 1.0 else 0.0
        away[n] = near + angle_wrap(turn - near)


@kernel("void(i8[::1], b1[::1], f8[:,::1], f8[:,::1], f8[:,::1], b1[::1], f4[::1], f8, f8, f8)")
def put_agents(
    rows: npt.NDArray[np.int64], live: Bool, there: Float64, place: Float64, speed: Float64, led: Bool, flat: Float32,
    dt: float, fastest: float, believed: float,
) -> None:  # fmt: skip
    """The agents `rows` (n,) who are `live` (n,) stand `there` (n, 2) [m]: their columns of `flat` (AgentState) change.

    `place` (A, 2) [m] is where they were a tick of `dt` [s] ago if they were `led` (A,), `speed` (A, 2) [m/s] is
    smoothed by the share `believed` of what that makes, `fastest` at most; both are brought up to date.
    """
    count = led.shape[0]
    for n in range(rows.shape[0]):
        a = rows[n]
        x, z = 0.0, 0.0
        if led[a]:
            x, z = (there[n, 0] - place[a, 0]) / dt, (there[n, 1] - place[a, 1]) / dt
        fast = max(math.sqrt(x * x + z * z) / fastest, 1.0)
        speed[a, 0] += believed * (x / fast - speed[a, 0])
        speed[a, 1] += believed * (z / fast - speed[a, 1])
        place[a, 0], place[a, 1] = there[n, 0], there[n, 1]
        if live[n]:
            for c in range(2):
                flat[2 * a + c] = there[n, c]
                flat[2 * count + 2 * a + c] = speed[a, c]
                flat[4 * count + 2 * a + c] = 0.0
            flat[6 * count + a] = 0.0


@kernel(
    "void(i8[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f4[:,:,::1],"
    " f4[:,:,::1], f4[:,::1], f4[:,:,::1])"
)
def take_dance_along(
    rows: npt.NDArray[np.int64], way: Float64, past: Float64, present: Float64, coming: Float64,
    begin: Float64, end: Float64, coming_end: Float64, path: Float32, coming_path: Float32,
    shown: Float32, lock: Float32,
) -> None:  # fmt: skip
    """All that is planned of the dancers `rows` (n,) lies elsewhere by `way` (n, 2) [m]: placements (A, 3), ends
    (A, 2), paths (A, P, 2), where they are `shown` (A, 2); and no foot of theirs is held, `lock` (A, 2, columns)."""
    for n in range(rows.shape[0]):
        a = rows[n]
        for c in range(2):
            past[a, c] += way[n, c]
            present[a, c] += way[n, c]
            coming[a, c] += way[n, c]
            begin[a, c] += way[n, c]
            end[a, c] += way[n, c]
            coming_end[a, c] += way[n, c]
            shown[a, c] += way[n, c]
            for k in range(path.shape[1]):
                path[a, k, c] += way[n, c]
                coming_path[a, k, c] += way[n, c]
        lock[a, :, :] = 0.0


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], i8[::1], f8[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], i8, f8, b1,"
    " f4[:,::1], i4[::1], i4[::1])"
)
def wear(
    position: Float32, rotation: Float32, rows: npt.NDArray[np.int64], asked: Float64,
    root: Float32, turned: Float32, stamp: Float64, count: int, scale: float, mirrored: bool,
    offsets: Float32, parents: Int32, other: Int32,
) -> None:  # fmt: skip
    """Let the dancers `rows` (n,) of `position` (A, J, 3) and `rotation` (A, J, 4), world, wear captured poses.

    `asked` (n, 8): see above. `root` (M + 1, 3) and `turned` (M + 1, J, 4) are the poses remembered, the newest at
    `count` - 1 modulo M, and the one held before a gap at M; `stamp` (M, 2) when they came. Between two of them poses
    are interpolated. Ways are `scale` times as long; `mirrored` exchanges the sides, `other` (J,) says the other side.
    """
    joints, held = parents.shape[0], stamp.shape[0]
    own = np.empty((joints, 4))
    for n in range(rows.shape[0]):
        a, share, caught = rows[n], asked[n, SHARE], asked[n, CAUGHT]
        i, j, t = _find(stamp, count, int(asked[n, KEY]), asked[n, WANTED])
        there = _stood(root, held, i, j, t, asked, n, scale, mirrored)
        for c in range(3):
            position[a, 0, c] += share * (there[c] - position[a, 0, c])
        for k in range(joints):
            own[k, 0], own[k, 1], own[k, 2], own[k, 3] = _row(rotation[a], k)
        for k in range(joints):
            q = _rotated(turned, held, i, j, t, caught, other[k] if mirrored else k, mirrored)
            if k == 0:
                mine, hers = _heading(_row(own, 0)), _heading(q)
                turn = asked[n, TURNED] + angle_wrap(asked[n, YAW] + hers - mine - asked[n, TURNED])
                tilt, tilted = _times(_about_vertical(-mine), _row(own, 0)), _times(_about_vertical(-hers), q)
                q = _times(_about_vertical(mine + share * turn), _through_rest(tilt, tilted, share))
            else:
                p = parents[k]
                q = _through_rest(_times(_back(_row(own, p)), _row(own, k)), q, share)
                above = _row(rotation[a], p)
                d = _turn(above, offsets[k, 0], offsets[k, 1], offsets[k, 2])
                for c in range(3):
                    position[a, k, c] = position[a, p, c] + d[c]
                q = _times(above, q)
            rotation[a, k, 0], rotation[a, k, 1], rotation[a, k, 2], rotation[a, k, 3] = q
