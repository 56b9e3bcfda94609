"""Bodies that move, and garments on them, for tests of cloth."""

import numpy as np

from live.clock.ticks import TICK
from live.motion.cloth.fabric import fabric_of
from live.motion.cloth.garment_batch import GarmentBatch
from live.motion.cloth.garment_catalogue import PATTERNS
from live.motion.cloth.pattern import compile_pattern
from live.motion.skeleton import SKELETON
from live.render.body.body_limbs import body_sections
from tests.render.poses import ALL, ARMS_DOWN, pose

STILL = np.zeros(3, np.float32)


def dressed(name, count=1, fabric="cotton", body="dancer", pattern=None):
    """A batch of `count` dancers who wear the garment `name`, or a pattern of one's own."""
    pattern = pattern or PATTERNS[name]
    batch = GarmentBatch(compile_pattern(pattern, fabric_of(pattern.kind, fabric)))
    batch.wear(np.arange(count, dtype=np.int32), [body_sections(body)] * count)
    return batch


def posed(turns=ARMS_DOWN, place=(0.0, 0.0), heading_deg=0.0, lift=0.0, count=1):
    """Joints of `count` dancers in the same pose, (count, J, 3) and (count, J, 4)."""
    position, rotation = pose(turns, place, heading_deg)
    position = position.copy()
    position[:, 1] += np.float32(lift)
    return np.repeat(position[None], count, 0), np.repeat(rotation[None], count, 0).astype(np.float32)


def blended(share, first, second):
    """Joint angles between two poses."""
    names = {*first, *second}
    zero = (0.0, 0.0, 0.0)
    return {
        name: tuple((1 - share) * np.array(first.get(name, zero)) + share * np.array(second.get(name, zero)))
        for name in names
    }


def wild(tick, dancer=0):
    """A dance that changes between poses in a third of a second (a beat at 180 bpm), spins, travels and jumps."""
    names = list(ALL)
    time = tick * TICK + 0.21 * dancer
    beat, share = divmod(time * 3.0, 1.0)
    share = 3 * share**2 - 2 * share**3
    first, second = names[(int(beat) * 3 + dancer) % len(names)], names[(int(beat) * 3 + 3 + dancer) % len(names)]
    turns = blended(share, ALL[first], ALL[second])
    place = 0.8 * np.sin(1.3 * time), 0.8 * np.sin(0.9 * time)
    return pose_with(turns, place, np.degrees(4.0 * np.sin(1.1 * time)), 0.25 * abs(np.sin(np.pi * time * 1.5)))


def pose_with(turns, place, heading, lift):
    """One dancer's joints."""
    position, rotation = pose(turns, place, float(heading))
    position = position.copy()
    position[:, 1] += np.float32(lift)
    return position, rotation


def wild_dance(ticks, count):
    """Joints of `count` dancers over the ticks, (ticks, count, J, 3) and (ticks, count, J, 4)."""
    rows = [[wild(tick, dancer) for dancer in range(count)] for tick in range(ticks)]
    return (
        np.array([[one[0] for one in row] for row in rows], np.float32),
        np.array([[one[1] for one in row] for row in rows], np.float32),
    )


def grid(batch, position, rotation, age=0.0, skinned=False):
    """The garments in a picture, (n, rows, columns, 3)."""
    pattern = batch.compiled.pattern
    out = np.zeros((batch.count, pattern.count, 3), np.float32)
    batch.draw(position, rotation, out, age=age, dt=TICK, skinned=skinned)
    return out.reshape(batch.count, pattern.rows, pattern.columns, 3)


def stretch(batch, places):
    """How much longer than cut the free edges down the columns and along the rows are, as shares."""
    pattern, places = batch.compiled.pattern, places.astype(np.float64)
    down = np.linalg.norm(np.diff(places, axis=1), axis=-1) / pattern.spacing - 1.0
    after = np.roll(places, -1, axis=2) if pattern.closed else places[:, :, 1:]
    along = np.linalg.norm(after - places[:, :, : after.shape[2]], axis=-1)
    along = along / np.array(pattern.widths)[None, :, None] - 1.0
    return down[:, pattern.pinned_rows - 1 :], along[:, pattern.pinned_rows :]


def skinned(mesh, position, rotation):
    """Vertices and normals of a body mesh in a pose, by blended dual quaternions (Kavan et al. 2007) in numpy."""
    rest, position, q = (
        SKELETON.rest_positions().astype(np.float64),
        position.astype(np.float64),
        rotation.astype(float),
    )
    count = len(rest)
    move = position - turned(q, rest)
    dual = 0.5 * product(np.concatenate([np.zeros((count, 1)), move], axis=1), q)
    joints, weights = np.minimum(mesh.joint, count - 1), mesh.weight.astype(np.float64)
    weights = np.where(mesh.joint < count, weights, 0.0)  # joints that only pictures have follow the head or hand
    real, dual = q[joints], dual[joints]
    sign = np.where((real * real[:, :1]).sum(-1) < 0.0, -1.0, 1.0)
    real, dual = ((weights * sign)[..., None] * real).sum(1), ((weights * sign)[..., None] * dual).sum(1)
    size = np.maximum(np.linalg.norm(real, axis=1, keepdims=True), 1e-9)
    real, dual = real / size, dual / size
    moved = 2.0 * product(dual, real * np.array([1.0, -1.0, -1.0, -1.0]))[:, 1:]
    return turned(real, mesh.position.astype(np.float64)) + moved, turned(real, mesh.normal.astype(np.float64))


def product(a, b):
    """Product of quaternions (w, x, y, z)."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )  # fmt: skip


def turned(q, v):
    """Rotate vectors."""
    t = 2.0 * np.cross(q[..., 1:], v)
    return v + q[..., :1] * t + np.cross(q[..., 1:], t)
