"""Kernels of garments: extended position-based dynamics in small steps, with contact of the own body and the floor.

After Müller et al., *Position Based Dynamics* (2007), Macklin, Müller and Chentanez, *XPBD* (2016), and Macklin et al.,
*Small Steps in Physics Simulation* (2019): each tick has several substeps with one iteration each. The length of cloth
is limited as in Provot, *Deformation Constraints in a Mass-Spring Model* (1995), and by attachments to the fixed rows
as in Kim, Chentanez and Müller-Fischer, *Long Range Attachments* (2012).

Positions of a block are (3, P, LANES), see `limb_kernels`. A *run* is a number of particles that lie one after the
other, with as many partners that do, too: one loop projects all constraints between them. No particle is in a run
twice, so the order within it does not matter.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.motion.cloth.air_kernels import face_air, follow_falls
from live.motion.cloth.contact_kernels import keep_out
from live.motion.cloth.limb_kernels import (
    JOINT_ROWS,
    LANES,
    LIMB_ROWS,
    gather_joints,
    interpolate_joints,
    place_bridges,
    place_limbs,
    skin_particles,
)
from live.motion.cloth.order_kernels import keep_order

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]
Uint8 = npt.NDArray[np.uint8]

EXACT, AT_MOST = 0, 1
"""Kinds of a run: a length, or an upper limit of one."""
RUN_KIND, RUN_FIRST, RUN_SECOND, RUN_COUNT = range(4)
"""Columns of `runs`."""
REST, COMPLIANCE, FIRST_MASS, SECOND_MASS = range(4)
"""Columns of `amounts`: length [m], compliance [m/N] of a particle of 1 kg, inverse masses of both ends [1/kg]."""
DRAG, GRAVITY, THICKNESS, FLOOR, FLOOR_FRICTION, FACING, FOLLOWS = range(7)
"""Entries of `matter`: drag of the air [1/s], acceleration [m/s2], distance kept from the body and height kept over the
floor [m], share of the speed along the floor that is lost in a substep, drag across the surface [1/m], share of the
body's falls beyond gravity that it follows."""
MATTER_COLUMNS = 7
_ZERO: Any = np.float32(0.0)
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)
_TINY: Any = np.float32(1e-12)
_RUNAWAY: Any = np.float32(1e4)
_KEPT: Any = np.float32(0.9)
_PUT_ON = 40  # steps in which a garment that begins goes from the rest pose into its wearer's
_FASTEST: Any = np.float32(9.0)  # no cloth is faster [m/s]; feet of the fastest kicks are as fast


@kernel("void(f4[:,::1], i4[:,::1], f4[:,::1], f4)")
def project_runs(places: Float32, runs: Int32, amounts: Float32, per_step: float) -> None:
    """Project the constraints of all `runs` (K, 4) once, in their order; places (3, P LANES).

    `per_step`: 1 / h², by which the compliance of `amounts` (K, 4) is multiplied for substeps of h [s].
    """
    x, y, z = places[0], places[1], places[2]
    for k in range(runs.shape[0]):
        first, second, n = runs[k, RUN_FIRST] * LANES, runs[k, RUN_SECOND] * LANES, runs[k, RUN_COUNT] * LANES
        lowest = -np.float32(np.inf) if runs[k, RUN_KIND] == EXACT else _ZERO
        rest, wa, wb = amounts[k, REST], amounts[k, FIRST_MASS], amounts[k, SECOND_MASS]
        share = _ONE / (wa + wb + amounts[k, COMPLIANCE] * per_step)
        wa, wb = wa * share, wb * share
        ax, ay, az = x[first : first + n], y[first : first + n], z[first : first + n]
        bx, by, bz = x[second : second + n], y[second : second + n], z[second : second + n]
        for i in range(n):
            dx, dy, dz = bx[i] - ax[i], by[i] - ay[i], bz[i] - az[i]
            far = max(_ONE - rest / math.sqrt(dx * dx + dy * dy + dz * dz + _TINY), lowest)
            dx, dy, dz = dx * far, dy * far, dz * far
            ax[i] += wa * dx
            ay[i] += wa * dy
            az[i] += wa * dz
            bx[i] -= wb * dx
            by[i] -= wb * dy
            bz[i] -= wb * dz


@kernel("void(f4[::1], f4[::1], f4[::1], f4, f4, f4)")
def _predict(x: Float32, old: Float32, v: Float32, kept: float, added: float, h: float) -> None:
    for i in range(x.shape[0]):
        old[i] = x[i]
        v[i] = v[i] * kept + added
        x[i] += h * v[i]


@kernel("void(f4[:,::1], f4[:,::1], f4[:,::1], f4)")
def _set_speed(x: Float32, old: Float32, v: Float32, per_h: float) -> None:
    """Compute the speed of all particles, (3, P LANES) each, at most _FASTEST."""
    ax, ay, az, bx, by, bz, vx, vy, vz = x[0], x[1], x[2], old[0], old[1], old[2], v[0], v[1], v[2]
    for i in range(ax.shape[0]):
        dx, dy, dz = (ax[i] - bx[i]) * per_h, (ay[i] - by[i]) * per_h, (az[i] - bz[i]) * per_h
        kept = min(_FASTEST / math.sqrt(dx * dx + dy * dy + dz * dz + _TINY), _ONE)
        vx[i], vy[i], vz[i] = dx * kept, dy * kept, dz * kept


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4, f4)")
def _keep_above_floor(x: Float32, old: Float32, floor: float, friction: float) -> None:
    n = x.shape[1] * LANES
    fx, fy, fz = x[0].reshape(n), x[1].reshape(n), x[2].reshape(n)
    ox, oz = old[0].reshape(n), old[2].reshape(n)
    for i in range(n):
        held = friction if fy[i] < floor else _ZERO
        fy[i] = max(fy[i], floor)
        fx[i] += held * (ox[i] - fx[i])
        fz[i] += held * (oz[i] - fz[i])


@kernel("void(f4[:,:,::1], u1[::1])")
def _mark_runaways(x: Float32, fresh: Uint8) -> None:
    """Set fresh (LANES,) where a number of x (3, P, LANES) is not finite or absurd, and clear it elsewhere."""
    for i in range(LANES):
        fresh[i] = 0
    for axis in range(3):
        for p in range(x.shape[1]):
            for i in range(LANES):
                fresh[i] |= not abs(x[axis, p, i]) < _RUNAWAY


@kernel("void(f4[::1], f4[::1], f4)")
def _go_on(x: Float32, last: Float32, kept: float) -> None:
    """Move x on by a share of the way that it has come since `last`, which becomes x."""
    for i in range(x.shape[0]):
        way = x[i] - last[i]
        last[i] = x[i]
        x[i] += way * kept if kept > _ZERO else _ZERO


@kernel("void(f4[:,:,::1], f4[:,::1], f4[:,:,::1])")
def _stand(now: Float32, standing: Float32, out: Float32) -> None:
    """Compute the joints `out` (7, J, LANES) of the rest pose, at the place of the first of the joints `now`."""
    for j in range(standing.shape[0]):
        sx, sy, sz = standing[j, 0], standing[j, 1], standing[j, 2]
        for i in range(LANES):
            w, x, y, z = now[3, 0, i], now[4, 0, i], now[5, 0, i], now[6, 0, i]
            tx, ty, tz = _TWO * (y * sz - z * sy), _TWO * (z * sx - x * sz), _TWO * (x * sy - y * sx)
            out[0, j, i] = now[0, 0, i] + sx + w * tx + y * tz - z * ty
            out[1, j, i] = now[1, 0, i] + sy + w * ty + z * tx - x * tz
            out[2, j, i] = now[2, 0, i] + sz + w * tz + x * ty - y * tx
            out[3, j, i], out[4, j, i], out[5, j, i], out[6, j, i] = w, x, y, z


@kernel(
    "void(f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], u1[::1], f4[:,:,::1], f4[:,::1], f4[:,:,::1], f4[:,:,::1], f4[:,::1],"
    " f4[:,:,::1], i4[::1], i4[:,::1], f4[:,:,::1], i4[:,::1], f4[:,::1], f4[:,:,::1], i8, i4[:,::1], f4[:,::1],"
    " i4[:,::1], f4[:,::1], i4[:,::1], i4[:,::1], i4[:,::1], f4[:,::1], f4, f4)"
)
def _begin(
    x: Float32, v: Float32, before: Float32, fresh: Uint8, now: Float32, standing: Float32, placed: Float32,
    limb: Float32, work: Float32, skin: Float32, limb_joint: Int32, bridges: Int32, limbs: Float32, by: Int32,
    weight: Float32, rest: Float32, pinned: int, runs: Int32, amounts: Float32, limit_runs: Int32, limits: Float32,
    contacts: Int32, more_contacts: Int32, rings: Int32, areas: Float32, thickness: float, per_step: float,
) -> None:  # fmt: skip
    """Let the garments of a block that are `fresh` begin at rest: put on in the rest pose, from which the body then
    bends into its own, so that legs are in the skirt even of somebody who sits."""
    begins, count = 0, x.shape[1]
    for i in range(LANES):
        begins += fresh[i]
    if begins == 0:
        return
    start = np.empty((7, now.shape[1], LANES), np.float32)
    _stand(now, standing, start)
    last = np.empty((3, count, LANES), np.float32)
    flat, flat_last = skin.reshape((3, count * LANES)), last.reshape((3, count * LANES))
    for step in range(_PUT_ON + 1):
        share: Any = np.float32(step) / np.float32(_PUT_ON)
        interpolate_joints(start, now, share, placed)
        place_limbs(placed, limb_joint, limbs, limb)
        place_bridges(limb, bridges, work)
        skin_particles(placed, by, weight, rest, count if step == 0 else pinned, skin)
        for axis in range(3):
            _go_on(flat[axis], flat_last[axis], _KEPT if step > 1 else _ZERO)
        project_runs(flat, runs, amounts, per_step)
        keep_order(flat, rings, areas, limb, 1)
        keep_out(flat, contacts, limb, thickness)
        if step == _PUT_ON:
            keep_out(flat, more_contacts, limb, thickness)
        project_runs(flat, limit_runs, limits, per_step)
        keep_out(flat, contacts, limb, thickness)
    for i in range(LANES):
        if fresh[i] != 0:
            x[:, :, i] = skin[:, :, i]
            v[:, :, i] = _ZERO
            before[:, :, i] = now[:, :, i]


@kernel(
    "void(f4[:,:,:,::1], f4[:,:,:,::1], f4[:,:,:,::1], f4[:,:,::1], u1[:,::1], f4[:,:,::1], f4[:,:,::1], i4[:,::1],"
    " i4[::1], f4[:,::1], i4[::1], i4[:,::1], f4[:,:,:,::1], f4[:,:,:,::1], i4[:,::1], f4[:,::1], i8, i4[:,::1],"
    " f4[:,::1], i4[:,::1], f4[:,::1],"
    " i4[:,::1], f4[:,::1], i4[:,::1], i4[:,::1], i4[:,::1], f4[:,::1], f4[::1], f4[::1], i8, f4, i8, i8)"
)
def step_garments(
    x: Float32,
    v: Float32,
    before: Float32,
    carrier: Float32,
    fresh: Uint8,
    position: Float32,
    rotation: Float32,
    rows: Int32,
    joints: Int32,
    standing: Float32,
    limb_joint: Int32,
    bridges: Int32,
    limbs: Float32,
    rest: Float32,
    by: Int32,
    weight: Float32,
    pinned: int,
    runs: Int32,
    amounts: Float32,
    limit_runs: Int32,
    limits: Float32,
    last_runs: Int32,
    last_limits: Float32,
    contacts: Int32,
    more_contacts: Int32,
    rings: Int32,
    areas: Float32,
    matter: Float32,
    wind: Float32,
    substeps: int,
    tick: float,
    begin: int,
    end: int,
) -> None:
    """Advance the blocks begin to end - 1 of garments of one pattern by a tick of `tick` [s].

    The state: x, v (B, 3, P, LANES) [m, m/s]; before (B, 7, J, LANES), the joints at the last tick; carrier (B, 7,
    LANES), the first joint at the tick before it; fresh (B, LANES), 1 where a garment begins anew, as skin, which is
    also set where a number is not finite. position (A, J, 3) and rotation (A, J, 4): the joints now. rows (B, LANES):
    dancers; joints (J,): the joints that the pattern needs; standing (J, 3): where they are in the rest pose, relative
    to the first; limb_joint (K,) and limbs (B, LIMB_ROWS, K, LANES) as in
    `place_limbs`, bridges as in `place_bridges`; rest (B, 6, P, LANES), by and weight as in `skin_particles`; `pinned`:
    the first so many particles stay on the body. contacts and limits are kept in each substep, more_contacts and
    last_limits in the last one. wind (3,) [m/s].
    """
    count, joint_count, limb_count = x.shape[2], joints.shape[0], limb_joint.shape[0]
    h: Any = tick / np.float32(substeps)
    per_step, per_h = _ONE / (h * h), _ONE / h
    kept: Any = _ONE / (_ONE + matter[DRAG] * h)  # implicit, so that any drag is stable
    thickness = matter[THICKNESS]
    now = np.empty((7, joint_count, LANES), np.float32)
    placed = np.empty((JOINT_ROWS, joint_count, LANES), np.float32)
    limb, work = np.empty((LIMB_ROWS, limb_count + len(bridges), LANES), np.float32), np.empty((9, LANES), np.float32)
    old, skin = np.empty((3, count, LANES), np.float32), np.empty((3, count, LANES), np.float32)
    for b in range(begin, end):
        gather_joints(position, rotation, rows[b], joints, now)
        _begin(
            x[b], v[b], before[b], fresh[b], now, standing, placed, limb, work, skin, limb_joint, bridges, limbs[b],
            by, weight, rest[b], pinned, runs, amounts, limit_runs, limits, contacts, more_contacts, rings, areas,
            thickness, per_step,
        )  # fmt: skip
        own, speed = x[b], v[b]
        flat, flat_speed = own.reshape((3, count * LANES)), speed.reshape((3, count * LANES))
        face_air(flat, flat_speed, rings, wind, matter[FACING] * tick)
        if matter[FOLLOWS] > _ZERO:
            follow_falls(speed, now, before[b], carrier[b], fresh[b], matter[GRAVITY], matter[FOLLOWS], tick)
        carrier[b] = before[b, :, 0]
        flat_old = old.reshape((3, count * LANES))
        for s in range(substeps):
            share: Any = np.float32(s + 1) / np.float32(substeps)
            interpolate_joints(before[b], now, share, placed)
            place_limbs(placed, limb_joint, limbs[b], limb)
            place_bridges(limb, bridges, work)
            for axis in range(3):
                fall: Any = matter[GRAVITY] * h if axis == 1 else _ZERO
                _predict(flat[axis], flat_old[axis], flat_speed[axis], kept, (_ONE - kept) * wind[axis] - fall, h)
            skin_particles(placed, by, weight, rest[b], pinned, own)
            project_runs(flat, runs, amounts, per_step)
            if s == substeps - 1:  # once in a tick is enough
                keep_order(flat, rings, areas, limb, 1)
            keep_out(flat, contacts, limb, thickness)
            if s == substeps - 1:
                keep_out(flat, more_contacts, limb, thickness)
                project_runs(flat, last_runs, last_limits, per_step)
                keep_out(flat, contacts, limb, thickness)  # pictures limit lengths once more
            else:
                project_runs(flat, limit_runs, limits, per_step)
            _keep_above_floor(own, old, matter[FLOOR], matter[FLOOR_FRICTION])
            _set_speed(flat, flat_old, flat_speed, per_h)
        _mark_runaways(own, fresh[b])
        before[b] = now
