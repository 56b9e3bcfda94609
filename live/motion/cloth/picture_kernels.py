"""Kernel of garments in a picture between two ticks: carried with the body of the picture, and kept out of it."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.motion.cloth.cloth_kernels import FLOOR, THICKNESS, project_runs
from live.motion.cloth.contact_kernels import keep_out
from live.motion.cloth.limb_kernels import (
    JOINT_ROWS,
    LANES,
    LIMB_ROWS,
    TURN,
    gather_joints,
    interpolate_joints,
    place_bridges,
    place_limbs,
    skin_particles,
)

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]
Uint8 = npt.NDArray[np.uint8]
_ZERO: Any = np.float32(0.0)
_ONE: Any = np.float32(1.0)
_CLOSE: Any = np.float32(0.004)  # distance from the body [m] where lengths leave no more


@kernel("void(f4[:,::1], f4[:,::1], f4[:,::1], f4[:,:,::1], f4[:,:,::1], f4, f4, f4[:,:,::1])")
def _carry(
    then: Float32, last: Float32, now: Float32, x: Float32, v: Float32, age: float, per_tick: float, out: Float32
) -> None:
    """Move particles with the joint that carries them, and on with their speed relative to it.

    then, last, now (JOINT_ROWS, LANES): the joint at the tick before the last, at the last tick, and in the picture;
    x, v, out (3, P, LANES).
    """
    for p in range(x.shape[1]):
        for i in range(LANES):
            dx, dy, dz = x[0, p, i] - last[0, i], x[1, p, i] - last[1, i], x[2, p, i] - last[2, i]
            a = last[TURN, i] * dx + last[TURN + 3, i] * dy + last[TURN + 6, i] * dz  # in the joint's axes
            b = last[TURN + 1, i] * dx + last[TURN + 4, i] * dy + last[TURN + 7, i] * dz
            c = last[TURN + 2, i] * dx + last[TURN + 5, i] * dy + last[TURN + 8, i] * dz
            # where the same place of the body was a tick before: so fast it moves
            ex = x[0, p, i] - (then[0, i] + then[TURN, i] * a + then[TURN + 1, i] * b + then[TURN + 2, i] * c)
            ey = x[1, p, i] - (then[1, i] + then[TURN + 3, i] * a + then[TURN + 4, i] * b + then[TURN + 5, i] * c)
            ez = x[2, p, i] - (then[2, i] + then[TURN + 6, i] * a + then[TURN + 7, i] * b + then[TURN + 8, i] * c)
            vx, vy, vz = v[0, p, i] - ex * per_tick, v[1, p, i] - ey * per_tick, v[2, p, i] - ez * per_tick
            a += age * (last[TURN, i] * vx + last[TURN + 3, i] * vy + last[TURN + 6, i] * vz)
            b += age * (last[TURN + 1, i] * vx + last[TURN + 4, i] * vy + last[TURN + 7, i] * vz)
            c += age * (last[TURN + 2, i] * vx + last[TURN + 5, i] * vy + last[TURN + 8, i] * vz)
            out[0, p, i] = now[0, i] + now[TURN, i] * a + now[TURN + 1, i] * b + now[TURN + 2, i] * c
            out[1, p, i] = now[1, i] + now[TURN + 3, i] * a + now[TURN + 4, i] * b + now[TURN + 5, i] * c
            out[2, p, i] = now[2, i] + now[TURN + 6, i] * a + now[TURN + 7, i] * b + now[TURN + 8, i] * c


@kernel(
    "void(f4[:,:,:,::1], f4[:,:,:,::1], f4[:,:,:,::1], f4[:,:,::1], u1[:,::1], f4[:,:,::1], f4[:,:,::1], i4[:,::1],"
    " i4[::1], i4[::1], i4[:,::1], f4[:,:,:,::1], f4[:,:,:,::1], i4[:,::1], f4[:,::1], i8, i4[:,::1], f4[:,::1],"
    " i4[:,::1], i4[:,::1], f4[::1], i4[:,::1], f4, f4, b1, f4[:,:,::1], i8, i8)"
)
def draw_garments(
    x: Float32,
    v: Float32,
    before: Float32,
    carrier: Float32,
    fresh: Uint8,
    position: Float32,
    rotation: Float32,
    rows: Int32,
    joints: Int32,
    limb_joint: Int32,
    bridges: Int32,
    limbs: Float32,
    rest: Float32,
    by: Int32,
    weight: Float32,
    pinned: int,
    limit_runs: Int32,
    limits: Float32,
    contacts: Int32,
    more_contacts: Int32,
    matter: Float32,
    order: Int32,
    age: float,
    tick: float,
    skinned: bool,
    out: Float32,
    begin: int,
    end: int,
) -> None:
    """Write the particles of the blocks begin to end - 1 in a picture `age` [s] after the last tick: out (n, R * C, 3).

    Arguments as in `step_garments`; position and rotation are the joints of the picture. carrier (B, 7, LANES): the
    first joint at the tick before the last; order (R, C): particle at each place of the grid. All garments are skin if
    `skinned`, else those that begin anew. Nothing of the state changes.
    """
    count, joint_count, limb_count = x.shape[2], joints.shape[0], limb_joint.shape[0]
    now = np.empty((7, joint_count, LANES), np.float32)
    one = np.empty((7, 1, LANES), np.float32)
    placed, last = np.empty((JOINT_ROWS, joint_count, LANES), np.float32), np.empty((JOINT_ROWS, 1, LANES), np.float32)
    then = np.empty((JOINT_ROWS, 1, LANES), np.float32)
    limb, work = np.empty((LIMB_ROWS, limb_count + len(bridges), LANES), np.float32), np.empty((9, LANES), np.float32)
    seen, skin = np.empty((3, count, LANES), np.float32), np.empty((3, count, LANES), np.float32)
    flat = seen.reshape((3, count * LANES))
    for b in range(begin, end):
        gather_joints(position, rotation, rows[b], joints, now)
        interpolate_joints(now, now, _ONE, placed)
        place_limbs(placed, limb_joint, limbs[b], limb)
        place_bridges(limb, bridges, work)
        as_skin = 0
        for i in range(LANES):
            as_skin += 1 if skinned or fresh[b, i] != 0 else 0
        if as_skin < LANES:
            one[:, 0] = before[b, :, 0]
            interpolate_joints(one, one, _ONE, last)
            one[:, 0] = carrier[b]
            interpolate_joints(one, one, _ONE, then)
            _carry(then[:, 0].copy(), last[:, 0].copy(), placed[:, 0].copy(), x[b], v[b], age, _ONE / tick, seen)
        if as_skin > 0:
            skin_particles(placed, by, weight, rest[b], count, skin)
            for i in range(LANES):
                if skinned or fresh[b, i] != 0:
                    seen[:, :, i] = skin[:, :, i]
        skin_particles(placed, by, weight, rest[b], pinned, seen)
        keep_out(flat, contacts, limb, matter[THICKNESS])
        keep_out(flat, more_contacts, limb, matter[THICKNESS])
        if not skinned:
            project_runs(flat, limit_runs, limits, _ZERO)
            keep_out(flat, contacts, limb, _CLOSE)
            project_runs(flat, limit_runs, limits, _ZERO)
        for i in range(LANES):
            who = b * LANES + i
            if who >= out.shape[0]:
                break
            for r in range(order.shape[0]):
                for c in range(order.shape[1]):
                    p, to = order[r, c], r * order.shape[1] + c
                    out[who, to, 0] = seen[0, p, i]
                    out[who, to, 1] = max(seen[1, p, i], matter[FLOOR])
                    out[who, to, 2] = seen[2, p, i]
