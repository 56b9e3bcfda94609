"""Reynolds' steering behaviours for one agent, as kernels that return a preferred velocity (T080-T083).

Preferred velocities are fractions of the agent's top speed: length 1 is full speed. The steering force (preferred minus
current velocity, T081) and all behaviours that need neighbours are computed later, in the neighbour pass. Terms and
rules follow Reynolds, "Steering behaviors for autonomous characters" (1999); stage plane (x, z), metres, seconds.
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]

WANDER_RATE = 0.9
"""New random displacements of a wandering agent's direction per second."""
WANDER_TURN = 1.1
"""The largest displacement of the direction [rad]."""
LOOK_AHEAD = 0.4
"""Look-ahead [s] at which a flow field or a path is sampled, since an agent cannot turn at once."""
CROSSING_PENALTY = 0.2
"""Cost [m²] added to a path segment perpendicular to the agent's heading; an opposing segment costs twice this."""
MAX_PREDICTION = 1.5
"""Longest look-ahead of pursuit and evasion [s]."""


@kernel("f8(i8,i8,i8)")
def hash_unit(seed: int, agent: int, index: int) -> float:
    """Return a pseudo-random number in [0, 1) that depends only on the arguments (mixing steps of murmur3)."""
    h = (int(seed) * 0x9E3779B1 ^ int(agent) * 0x85EBCA77 ^ int(index) * 0xC2B2AE3D) & 0xFFFFFFFF
    h = ((h ^ (h >> 16)) * 0x85EBCA6B) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 0xC2B2AE35) & 0xFFFFFFFF
    h = h ^ (h >> 16)
    return h / 4294967296.0


@kernel("UniTuple(f8,2)(f8,f8)")
def unit(x: float, z: float) -> tuple[float, float]:
    """Return the unit vector of (x, z), or (0, 0) for a zero vector."""
    d = math.sqrt(x * x + z * z)
    if d < 1e-9:
        return 0.0, 0.0
    return x / d, z / d


@kernel("UniTuple(f8,2)(f8,f8,f8,f8)")
def seek(x: float, z: float, target_x: float, target_z: float) -> tuple[float, float]:
    """Return the direction to the target at top speed (T082); zero at the target."""
    return unit(target_x - x, target_z - z)


@kernel("UniTuple(f8,2)(f8,f8,f8,f8)")
def flee(x: float, z: float, target_x: float, target_z: float) -> tuple[float, float]:
    """Return the direction away from the target at top speed: the inverse of seek (T082)."""
    return unit(x - target_x, z - target_z)


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8)")
def arrive(x: float, z: float, target_x: float, target_z: float, slowing: float) -> tuple[float, float]:
    """Return seek, slowed in proportion to the distance within `slowing` [m] of the target."""
    dx, dz = target_x - x, target_z - z
    d = math.sqrt(dx * dx + dz * dz)
    scale = 1.0 / max(d, slowing, 1e-9)
    return dx * scale, dz * scale


@kernel("f8(f8,f8,f8)")
def prediction(dx: float, dz: float, speed: float) -> float:
    """Return the time [s] to reach a point at offset (dx, dz) at `speed` [m/s], bounded by MAX_PREDICTION."""
    return min(math.sqrt(dx * dx + dz * dz) / max(speed, 0.1), MAX_PREDICTION)


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f8,f8)")
def pursue(
    x: float, z: float, quarry_x: float, quarry_z: float, quarry_vx: float, quarry_vz: float, speed: float
) -> tuple[float, float]:
    """Seek the predicted position of the quarry; `speed` [m/s] is the agent's top speed."""
    ahead = prediction(quarry_x - x, quarry_z - z, speed)
    return seek(x, z, quarry_x + quarry_vx * ahead, quarry_z + quarry_vz * ahead)


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f8,f8)")
def evade(
    x: float, z: float, hunter_x: float, hunter_z: float, hunter_vx: float, hunter_vz: float, speed: float
) -> tuple[float, float]:
    """Flee the predicted position of the hunter: the inverse of pursue."""
    ahead = prediction(hunter_x - x, hunter_z - z, speed)
    return flee(x, z, hunter_x + hunter_vx * ahead, hunter_z + hunter_vz * ahead)


@kernel("f8(i8,i8,f8)")
def noise(seed: int, agent: int, time: float) -> float:
    """Return smooth noise over time in [-1, 1]: one new value per unit of `time`, with eased interpolation."""
    turn = math.floor(time)
    t = time - turn
    before = hash_unit(seed, agent, int(turn))
    after = hash_unit(seed, agent, int(turn) + 1)
    return 2.0 * (before + (after - before) * t * t * (3.0 - 2.0 * t)) - 1.0


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f8,i8,i8,f8)")
def wander(
    x: float,
    z: float,
    vx: float,
    vz: float,
    half_width: float,
    half_depth: float,
    seed: int,
    agent: int,
    time: float,
) -> tuple[float, float]:
    """Keep the heading with small seeded random displacements (T082); turn back at the stage edge.

    The displacement is a smooth function of (seed, agent, time), so it does not depend on the tick length. An agent at
    rest starts in a random direction.
    """
    if vx * vx + vz * vz > 1e-4:
        heading = math.atan2(vx, vz)
    else:
        heading = 2.0 * math.pi * hash_unit(seed, agent, 101)
    heading += WANDER_TURN * noise(seed, agent, time * WANDER_RATE)
    wish_x, wish_z = math.sin(heading), math.cos(heading)
    if abs(x + wish_x) > half_width - 0.5 and x * wish_x > 0.0:
        wish_x = -wish_x
    if abs(z + wish_z) > half_depth - 0.5 and z * wish_z > 0.0:
        wish_z = -wish_z
    return wish_x, wish_z


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8)")
def flow_radial(x: float, z: float, centre_x: float, centre_z: float, decay: float) -> tuple[float, float]:
    """Return a flow away from the centre, zero at the centre: 1 - exp(-d / decay) of the top speed."""
    dx, dz = x - centre_x, z - centre_z
    d = math.sqrt(dx * dx + dz * dz)
    scale = (1.0 - math.exp(-d / decay)) / max(d, 1e-9)
    return dx * scale, dz * scale


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8)")
def flow_vortex(x: float, z: float, centre_x: float, centre_z: float, decay: float) -> tuple[float, float]:
    """Return a flow round the centre, zero at the centre; clockwise seen from above (from +x over +z to -x)."""
    out_x, out_z = flow_radial(x, z, centre_x, centre_z, decay)
    return -out_z, out_x


@kernel("UniTuple(f8,2)(f4[:,:,:,::1],i8,f8,f8,f8,f8)")
def flow_grid(
    grids: Float32, slot: int, x: float, z: float, half_width: float, half_depth: float
) -> tuple[float, float]:
    """Sample a flow given at the nodes of a grid over the stage, `grids` (S, rows, columns, 2), bilinearly.

    The first row lies at -half_depth, the last at +half_depth; places off the stage use the flow at the edge.
    """
    rows, columns = grids.shape[1], grids.shape[2]
    u = min(max((x / half_width + 1.0) * 0.5 * (columns - 1), 0.0), columns - 1.001)
    v = min(max((z / half_depth + 1.0) * 0.5 * (rows - 1), 0.0), rows - 1.001)
    c, r = int(u), int(v)
    u, v = u - c, v - r
    a, b, d, e = (1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v
    wish_x = a * grids[slot, r, c, 0] + b * grids[slot, r, c + 1, 0]
    wish_z = a * grids[slot, r, c, 1] + b * grids[slot, r, c + 1, 1]
    wish_x += d * grids[slot, r + 1, c, 0] + e * grids[slot, r + 1, c + 1, 0]
    wish_z += d * grids[slot, r + 1, c, 1] + e * grids[slot, r + 1, c + 1, 1]
    return wish_x, wish_z


@kernel("UniTuple(f8,5)(f4[:,:,::1],i8,i8,b1,f8,f8,f8,f8)")
def nearest_on_line(
    vertices: Float32, line: int, count: int, closed: bool, x: float, z: float, hx: float, hz: float
) -> tuple[float, float, float, float, float]:
    """Return the squared distance [m²] to a polyline, its nearest point, the segment and the position (0 to 1) in the
    segment.

    `vertices` (L, V, 2): the first `count` vertices of row `line`; a closed line has a segment back to its start. The
    first of equally near segments wins. A single vertex is a line of zero length. (hx, hz), of length at most 1:
    segments that run in another direction cost more, so an agent goes straight on where a path crosses itself.
    """
    best, best_x, best_z, best_segment, best_t, least = 1e30, 0.0, 0.0, 0, 0.0, 1e30
    heading = math.sqrt(hx * hx + hz * hz)
    segments = count if closed and count > 2 else max(count - 1, 1)
    for s in range(segments):
        e = (s + 1) % count
        ax, az = float(vertices[line, s, 0]), float(vertices[line, s, 1])
        dx, dz = vertices[line, e, 0] - ax, vertices[line, e, 1] - az
        length2 = dx * dx + dz * dz
        t = 0.0
        if length2 > 1e-12:
            t = min(max(((x - ax) * dx + (z - az) * dz) / length2, 0.0), 1.0)
        px, pz = ax + t * dx, az + t * dz
        d2 = (px - x) ** 2 + (pz - z) ** 2
        cost = d2
        if heading > 0.0 and length2 > 1e-12:
            cost += CROSSING_PENALTY * (heading - (hx * dx + hz * dz) / math.sqrt(length2))
        if cost < least:
            best, best_x, best_z, best_segment, best_t, least = d2, px, pz, s, t, cost
    return best, best_x, best_z, float(best_segment), best_t


@kernel("UniTuple(f8,4)(f4[:,:,::1],i8,i8,b1,i8,f8,f8)")
def along_line(
    vertices: Float32, line: int, count: int, closed: bool, segment: int, t: float, ahead: float
) -> tuple[float, float, float, float]:
    """Return the point `ahead` [m] farther along a polyline than position `t` of `segment`, and its tangent.

    An open line is clamped to its end.
    """
    segments = count if closed and count > 2 else max(count - 1, 1)
    px, pz, tx, tz = float(vertices[line, segment, 0]), float(vertices[line, segment, 1]), 0.0, 0.0
    left, turns = ahead, 0
    s = segment
    while turns <= segments:
        e = (s + 1) % count
        ax, az = float(vertices[line, s, 0]), float(vertices[line, s, 1])
        dx, dz = vertices[line, e, 0] - ax, vertices[line, e, 1] - az
        length = math.sqrt(dx * dx + dz * dz)
        if length > 1e-6:
            tx, tz = dx / length, dz / length
            rest = (1.0 - t) * length
            if left <= rest:
                return ax + tx * (t * length + left), az + tz * (t * length + left), tx, tz
            left -= rest
            px, pz = ax + dx, az + dz
        t = 0.0
        turns += 1
        s += 1
        if s == segments:
            if not closed:
                return px, pz, tx, tz
            s = 0
    return px, pz, tx, tz


@kernel("UniTuple(f8,2)(f4[:,:,::1],i8,i8,b1,f8,f8,f8,f8,f8,f8)")
def follow_path(
    vertices: Float32,
    line: int,
    count: int,
    closed: bool,
    width: float,
    x: float,
    z: float,
    vx: float,
    vz: float,
    speed: float,
) -> tuple[float, float]:
    """Follow a polyline in its direction, within `width` [m] of it; predictive (Reynolds 1999).

    The agent's predicted position is projected onto the path. Within the width the agent follows the tangent; outside
    it heads for a point farther along the path. At the end of an open path it arrives and stays.
    """
    future_x, future_z = x + vx * LOOK_AHEAD, z + vz * LOOK_AHEAD
    going = max(math.sqrt(vx * vx + vz * vz), 0.3)
    d2, _, _, segment, t = nearest_on_line(vertices, line, count, closed, future_x, future_z, vx / going, vz / going)
    ahead = max(0.5, speed * LOOK_AHEAD)
    aim_x, aim_z, tx, tz = along_line(vertices, line, count, closed, int(segment), t, ahead)
    if not closed:
        end_x, end_z = float(vertices[line, count - 1, 0]), float(vertices[line, count - 1, 1])
        if (aim_x - end_x) ** 2 + (aim_z - end_z) ** 2 < 1e-8:
            return arrive(x, z, end_x, end_z, 1.0)
    to_x, to_z = seek(x, z, aim_x, aim_z)
    # blended from the tangent (on the path) to the aim (at its border), so that agents do not oscillate at the border
    share = min(math.sqrt(d2) / max(width, 1e-6), 1.0)
    return unit(tx + share * (to_x - tx), tz + share * (to_z - tz))


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f8,f8)")
def follow_behind(
    x: float, z: float, before_x: float, before_z: float, before_vx: float, before_vz: float, gap: float
) -> tuple[float, float]:
    """Arrive `gap` [m] behind a moving agent, on the follower's side of it, as if pulled by a rope."""
    back_x, back_z = unit(x - before_x - 0.6 * before_vx, z - before_z - 0.6 * before_vz)
    return arrive(x, z, before_x + gap * back_x, before_z + gap * back_z, 0.8)


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f8,f8,f8)")
def follow_in_wedge(
    x: float,
    z: float,
    before_x: float,
    before_z: float,
    heading_x: float,
    heading_z: float,
    side: float,
    gap: float,
) -> tuple[float, float]:
    """Arrive `gap` [m] behind and `side` · gap to the side of an agent, relative to its heading (unit vector).

    Followers thus form a wedge.
    """
    aim_x = before_x - gap * (heading_x - side * heading_z)
    aim_z = before_z - gap * (heading_z + side * heading_x)
    return arrive(x, z, aim_x, aim_z, 0.8)


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8,f8)")
def clear_path(
    x: float, z: float, leader_x: float, leader_z: float, leader_vx: float, leader_vz: float
) -> tuple[float, float]:
    """Step aside from the leader's path if within 2 m ahead of it and 0.7 m of its line (Reynolds 1999)."""
    hx, hz = unit(leader_vx, leader_vz)
    dx, dz = x - leader_x, z - leader_z
    ahead, aside = dx * hx + dz * hz, dx * hz - dz * hx
    if ahead <= 0.0 or ahead > 2.0 or abs(aside) > 0.7:
        return 0.0, 0.0
    share = (1.0 - abs(aside) / 0.7) * (1.0 - 0.5 * ahead)
    sign = 1.0 if aside >= 0.0 else -1.0
    return sign * share * hz, -sign * share * hx
