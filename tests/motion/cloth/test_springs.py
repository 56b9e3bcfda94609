"""Springs of characters against a plain implementation of the specification's text, and against laws."""

import numpy as np
import pytest

from live.motion.cloth.spring_kernels import mix_springs, swing
from live.motion.cloth.spring_rig import SpringRig
from live.motion.skeleton import JOINT_COUNT, SKELETON
from tests.fixtures.mostly_long import mostly_long

TICK = 1.0 / 64.0
REST = np.ascontiguousarray(SKELETON.rest_positions(), np.float32)
HEAD, HIPS = SKELETON.index("head"), SKELETON.index("hips")


def rotation_matrix(axis, angle):
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def quaternion_of(axis, angle):
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])


def matrix_of(q):
    w, x, y, z = (float(part) for part in q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def made_rig(seed=0, colliders=True, centre=-1, stiffness=1.0, gravity=0.5, drag=0.4):
    """Two strands of five bones, one with a branch, that hang from the head."""
    draw = np.random.default_rng(seed)
    parent, head, tail = [], [], []
    for strand in range(2):
        place = REST[HEAD] + np.array([0.05 * (2 * strand - 1), 0.1, -0.09])
        for bone in range(5):
            end = place + 0.07 * np.array([0.1 * (2 * strand - 1), -1.0, -0.3]) + draw.normal(0.0, 0.004, 3)
            parent.append(-1 if bone == 0 else len(parent) - 1)
            head.append(place)
            tail.append(end)
            place = end
    parent.append(1)  # a branch
    head.append(tail[1])
    tail.append(tail[1] + np.array([0.06, -0.02, -0.03]))
    count = len(parent)
    setting = np.zeros((count, 6), np.float32)
    setting[:, 0], setting[:, 1], setting[:, 3], setting[:, 5] = stiffness, drag, -gravity, 0.01
    shapes = np.zeros((2 if colliders else 0, 7), np.float32)
    if colliders:
        shapes[0] = (*(REST[HEAD] + (0.0, 0.06, 0.0)), *(REST[HEAD] + (0.0, 0.06, 0.0)), 0.08)
        shapes[1] = (*(REST[HEAD] + (0.0, -0.1, -0.02)), *(REST[HEAD] + (0.0, -0.4, -0.02)), 0.09)
    carriers = [HEAD, SKELETON.index("upperChest")][: len(shapes)]
    return SpringRig(
        np.array(parent, np.int32), np.full(count, HEAD, np.int32), np.full(count, centre, np.int32),
        np.array(head, np.float32), np.array(tail, np.float32), setting,
        np.full(count, (1 << len(shapes)) - 1, np.int64),
        np.array(carriers, np.int32), shapes,
    )  # fmt: skip


class Springs:
    """The kernel with its state, for n dancers."""

    def __init__(self, rig, dancers=1):
        self.rig, self.start = rig, np.ones(dancers, np.uint8)
        self.now, self.before = (np.zeros((dancers, rig.count, 3), np.float32) for _ in range(2))
        self.turn = np.zeros((dancers, rig.count, 4), np.float32)

    def tick(self, position, rotation):
        rig = self.rig
        swing(
            position, rotation, REST, rig.parent, rig.joint, rig.centre, rig.head, rig.tail, rig.setting, rig.hits,
            rig.collider_joint, rig.collider, self.start, TICK, self.now, self.before, self.turn,
        )  # fmt: skip
        self.start[:] = 0


def body(axis=(0, 1, 0), angle=0.0, shift=(0.0, 0.0, 0.0)):
    """Joints of a body that is turned as a whole: positions (1, J, 3) and rotations (1, J, 4)."""
    place = REST @ rotation_matrix(axis, angle).T + np.asarray(shift)
    turn = np.tile(quaternion_of(axis, angle), (JOINT_COUNT, 1))
    return place[None].astype(np.float32), turn[None].astype(np.float32)


class Reference:
    """The update procedure of VRMC_springBone-1.0, with matrices and one bone at a time."""

    def __init__(self, rig):
        self.rig, self.current, self.previous = rig, None, None

    def tick(self, position, rotation):
        rig, count = self.rig, self.rig.count
        frames = [(matrix_of(rotation[0, j]), position[0, j].astype(float)) for j in range(JOINT_COUNT)]
        centre = [(np.eye(3), np.zeros(3)) if c < 0 else frames[c] for c in rig.centre]
        place, turn, tails = [None] * count, [None] * count, [None] * count
        for b in range(count):
            rest_head, rest_tail = rig.head[b].astype(float), rig.tail[b].astype(float)
            p = rig.parent[b]
            if p < 0:
                parent_turn, at = frames[rig.joint[b]]
                place[b] = at + parent_turn @ (rest_head - REST[rig.joint[b]])
            else:
                parent_turn = turn[p]
                place[b] = place[p] + parent_turn @ (rest_head - rig.head[p])
            length = np.linalg.norm(rest_tail - rest_head)
            bone_axis = (rest_tail - rest_head) / length
            if self.current is None:
                current = previous = place[b] + parent_turn @ (rest_tail - rest_head)
            else:
                r, t = centre[b]
                current, previous = r @ self.current[b] + t, r @ self.previous[b] + t
            stiffness, drag, *gravity, radius = rig.setting[b].astype(float)
            inertia = (current - previous) * (1.0 - drag)
            pull = TICK * (parent_turn @ bone_axis) * stiffness
            following = current + inertia + pull + TICK * np.array(gravity)
            following = place[b] + length * (following - place[b]) / np.linalg.norm(following - place[b])
            for c, row in enumerate(rig.collider.astype(float)):
                if not rig.hits[b] >> c & 1:
                    continue
                r, t = frames[rig.collider_joint[c]]
                rest = REST[rig.collider_joint[c]].astype(float)
                a, e = t + r @ (row[:3] - rest), t + r @ (row[3:6] - rest)
                share = 0.0 if np.allclose(a, e) else np.clip((following - a) @ (e - a) / ((e - a) @ (e - a)), 0.0, 1.0)
                away = following - a - share * (e - a)
                distance = np.linalg.norm(away) - row[6] - radius
                if distance < 0.0:
                    following = following - away / np.linalg.norm(away) * distance
                    following = place[b] + length * (following - place[b]) / np.linalg.norm(following - place[b])
            tails[b] = (current, following)
            start, end = parent_turn @ bone_axis, (following - place[b]) / length
            across = np.cross(start, end)
            size = np.linalg.norm(across)
            swung = np.eye(3) if size < 1e-12 else rotation_matrix(across, np.arctan2(size, start @ end))
            turn[b] = swung @ parent_turn
        self.previous = [centre[b][0].T @ (tails[b][0] - centre[b][1]) for b in range(count)]
        self.current = [centre[b][0].T @ (tails[b][1] - centre[b][1]) for b in range(count)]
        return np.array(self.current), np.array([frames[rig.joint[b]][0].T @ turn[b] for b in range(count)])


@mostly_long("centre", [-1, HIPS], quick=[0])
@mostly_long("colliders", [False, True], quick=[0])
def test_kernel_follows_the_specification(colliders, centre):
    rig = made_rig(colliders=colliders, centre=centre)
    springs, reference = Springs(rig), Reference(rig)
    for tick in range(200):
        at = tick * TICK
        posed = body((0.2, 1.0, 0.1), 1.5 * np.sin(9.0 * at), (0.6 * np.sin(5.0 * at), 0.05 * np.sin(12.0 * at), 0.0))
        springs.tick(*posed)
        tails, turns = reference.tick(*posed)
        assert np.abs(springs.now[0] - tails).max() < 2e-5
        found = np.array([matrix_of(q) for q in springs.turn[0]])
        assert np.abs(found - turns).max() < 5e-4
    if colliders:  # they did collide
        free = Springs(made_rig(colliders=False, centre=centre))
        for tick in range(200):
            free.tick(*body((0.2, 1.0, 0.1), 1.5 * np.sin(9.0 * tick * TICK)))
        assert np.abs(free.now - springs.now).max() > 0.01


@pytest.mark.long
def test_bones_keep_their_length_and_stay_out_of_colliders():
    rig = made_rig(stiffness=0.2)
    springs = Springs(rig)
    length = np.linalg.norm(rig.tail - rig.head, axis=1)
    for tick in range(400):
        angle = 2.0 * np.sin(12.0 * tick * TICK)
        position, rotation = body((0.3, 1.0, 0.0), angle)
        springs.tick(position, rotation)
        turn = np.array([matrix_of(rotation[0, HEAD]) @ matrix_of(q) for q in springs.turn[0]])
        tips = springs.now[0]
        places = tips - np.einsum("bij,bj->bi", turn, (rig.tail - rig.head).astype(float))
        assert np.allclose(np.linalg.norm(tips - places, axis=1), length, atol=1e-6)
        first = places[[0, 5]] - position[0, HEAD]
        assert np.allclose(first @ matrix_of(rotation[0, HEAD]), rig.head[[0, 5]] - REST[HEAD], atol=2e-4)
        for a, b, radius in ((row[:3], row[3:6], row[6]) for row in rig.collider[:1]):
            axis = position[0, HEAD] + matrix_of(rotation[0, HEAD]) @ (a - REST[HEAD])
            assert np.allclose(a, b)
            assert np.linalg.norm(tips[6:10] - axis, axis=1).min() > radius - 0.02


def test_springs_hang_down_at_rest_without_stiffness():
    rig = made_rig(colliders=False, stiffness=0.0, gravity=1.0)
    springs = Springs(rig)
    for _ in range(2000):
        springs.tick(*body())
    way = springs.now[0, 4] - rig.head[0]
    assert np.allclose(way / np.linalg.norm(way), (0.0, -1.0, 0.0), atol=1e-3)


def test_still_body_without_gravity_keeps_its_rest_pose():
    springs = Springs(made_rig(colliders=False, gravity=0.0))
    for _ in range(100):
        springs.tick(*body((1.0, 0.3, 0.0), 0.7, (3.0, 0.0, -2.0)))
    assert np.allclose(np.abs(springs.turn[..., 0]), 1.0, atol=1e-6)


def test_violent_motion_stays_finite():
    draw, springs = np.random.default_rng(1), Springs(made_rig(stiffness=4.0, drag=0.0, gravity=9.0))
    for _ in range(500):
        springs.tick(*body(draw.normal(size=3), draw.uniform(-3.0, 3.0), draw.uniform(-50.0, 50.0, 3)))
        assert np.isfinite(springs.now).all()
        assert np.allclose(np.linalg.norm(springs.turn, axis=-1), 1.0, atol=1e-5)


def test_mixture_begins_and_ends_at_both_ticks_and_at_rest():
    draw = np.random.default_rng(2)
    before, now = (draw.normal(size=(3, 4, 4)).astype(np.float32) for _ in range(2))
    for each in (before, now):
        each /= np.linalg.norm(each, axis=-1, keepdims=True)
    out, whole = np.zeros_like(now), np.ones(3, np.float32)
    for share, wanted in ((0.0, before), (1.0, now)):
        mix_springs(before, now, whole, share, out)
        assert np.allclose(np.abs((out * wanted).sum(axis=-1)), 1.0, atol=1e-6)
    mix_springs(before, now, np.zeros(3, np.float32), 0.5, out)
    assert np.allclose(out, (1.0, 0.0, 0.0, 0.0))
