"""Dual quaternions of the pose texture against matrices; culling, level of detail and draw lists."""

import numpy as np

from live.base.stage_snapshot import Camera
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.camera import world_to_clip
from live.render.dancers.instance_lists import BODY_REACH, HIP_REACH, ViewVolume
from live.render.render_kernels import (
    CASTING,
    FAR,
    MIRRORED,
    NEAR,
    PRESENT,
    VISIBLE,
    choose_detail,
    cull_dancers,
    fill_lists,
    pose_texels,
)
from tests.render.poses import ARABESQUE, LUNGE, pose


def _matrix(q: np.ndarray) -> np.ndarray:
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_pose_texels_match_joint_matrices() -> None:
    rest = SKELETON.rest_positions()
    poses = [pose(LUNGE, (1.0, -2.0), 30.0), pose(ARABESQUE, (-3.0, 0.5), -80.0), pose(LUNGE)]
    position = np.array([one[0] for one in poses])
    rotation = np.array([one[1] for one in poses])
    rows = 2  # three dancers in two rows: the third starts the second block
    anchor = np.array([5, 9], np.int32)  # two more joints, which move with head and left hand
    drawn = JOINT_COUNT + len(anchor)
    out = np.zeros((rows, 2 * 2 * drawn, 4), np.float32)
    pose_texels(position, rotation, rest, anchor, out)
    offset = np.array([0.05, -0.10, 0.20])
    for dancer in range(3):
        for drawn_joint in range(drawn):
            joint = drawn_joint if drawn_joint < JOINT_COUNT else anchor[drawn_joint - JOINT_COUNT]
            texel = dancer // rows * 2 * drawn + 2 * drawn_joint
            real, dual = out[dancer % rows, texel].astype(float), out[dancer % rows, texel + 1].astype(float)
            turn = _matrix(np.array([real[3], *real[:3]]))
            move = 2.0 * (real[3] * dual[:3] - dual[3] * real[:3] + np.cross(real[:3], dual[:3]))
            carried = turn @ (rest[joint] + offset) + move
            expected = position[dancer, joint] + _matrix(rotation[dancer, joint].astype(float)) @ offset
            np.testing.assert_allclose(carried, expected, atol=2e-5)


def test_culling_keeps_every_visible_dancer_and_removes_most_others() -> None:
    camera, size = Camera(), (1280, 720)
    sight = ViewVolume.of(camera, size)
    random = np.random.default_rng(4)
    joints = np.array(pose(LUNGE)[0])
    place = random.uniform((-30.0, 0.0, -30.0), (30.0, 0.0, 30.0), (2000, 3))
    position = np.ascontiguousarray((joints - joints[0] * (1.0, 0.0, 1.0))[None] + place[:, None], np.float32)
    bits, light = np.zeros(2000, np.uint8), np.array([0.3, 0.8, 0.52], np.float32)
    cull_dancers(position, place[:, 0] < 29.0, sight.planes, light, HIP_REACH + BODY_REACH, bits)
    matrix = world_to_clip(camera, size)
    for bit, points in (
        (VISIBLE, position),
        (MIRRORED, position * np.array([1, -1, 1])),
        (CASTING, (position - position[..., 1:2] * (light / light[1])) * np.array([1, 0, 1])),
    ):
        clip = np.concatenate([points, np.ones((*points.shape[:2], 1))], axis=2) @ matrix.T
        inside = ((np.abs(clip[..., :2]) <= clip[..., 3:]).all(axis=2) & (clip[..., 3] > 0.1)).any(axis=1)
        said = bits & bit > 0
        assert not (inside & (place[:, 0] < 29.0) & ~said).any()
        assert said.sum() < 1.6 * inside.sum()  # a ball is larger than she
    assert not bits[place[:, 0] >= 29.0].any()


def test_near_body_goes_to_nearest_and_all_within_distance() -> None:
    random = np.random.default_rng(5)
    position = random.uniform(-20.0, 20.0, (300, 22, 3)).astype(np.float32)
    bits = np.where(random.random(300) < 0.7, VISIBLE | PRESENT, PRESENT).astype(np.uint8)
    forward, scratch = np.array([0.0, 0.6, 0.8], np.float32), np.zeros(300, np.float32)
    seen = np.flatnonzero(bits & VISIBLE)
    way = position[:, 0] @ forward
    for near_to, count in ((-100.0, 40), (-100.0, 0), (5.0, 10), (-100.0, 1000), (-100.0, 1)):
        here = bits.copy()
        choose_detail(position, forward, near_to, count, here, scratch)
        near = {int(who) for who in seen if here[who] & NEAR}
        nearest = {int(who) for who in seen[np.argsort(way[seen])][:count]}
        assert near == nearest | {int(who) for who in seen if way[who] < near_to}
        assert ((here & (NEAR | FAR) == NEAR) ^ (here & (NEAR | FAR) == FAR)).all()


def test_draw_lists_contain_matching_dancers_by_body_with_their_skins() -> None:
    sight = np.array([VISIBLE, VISIBLE | NEAR, 0, VISIBLE | NEAR, NEAR], np.uint8)
    group, body = np.array([0, 1, 0, 17, 1], np.int32), np.array([0, 1, 0, 1, 0], np.int32)
    ways = np.zeros(16, np.int32)
    ways[0], ways[1] = 0b001, 0b111
    needs = np.array([VISIBLE, NEAR, NEAR])
    allowed = (((np.arange(64)[:, None] & needs) == needs) @ (1, 2, 4)).astype(np.int32)
    # the lists 0 and 1 share a skin, list 2 has none; a body of 3 or 5 vertices, in rows of 8
    skin_of, skin_bits = np.array([0, 0, -1], np.int32), np.array([0b011], np.int32)
    first, vertices = np.array([[100, 200]], np.int32), np.array([[3, 5]], np.int32)
    out, counts = np.zeros((3, 2, 5, 2), np.int32), np.zeros((3, 2), np.int32)
    skinned, rows = np.full(8, -1, np.int32), np.full((4, 4), -1, np.int32)
    used = fill_lists(
        sight, group, body, ways, allowed, skin_of, skin_bits, first, vertices, 8,
        out, counts, np.zeros(5, np.int32), np.zeros((1, 2, 2), np.int32), skinned, rows,
    )  # fmt: skip
    assert counts.tolist() == [[1, 2], [1, 2], [1, 2]]
    # dancers 0 and 4 have the first body, one row of 6 vertices; 1 and 3 the second, from the second row on
    assert out[0, 0, :1].tolist() == [[0, 0]]
    assert out[1, 0, :1].tolist() == [[4, 3]]
    assert out[0, 1, :2].tolist() == out[1, 1, :2].tolist() == [[1, 8], [3, 13]]
    assert out[2, 1, :2].tolist() == [[1, 0], [3, 0]]
    assert skinned.tolist() == [0, 4, 1, 3, -1, -1, -1, -1]
    assert used == 3
    assert rows.tolist() == [[100, 3, 0, 0], [200, 5, 0, 2], [200, 5, 8, 2], [-1] * 4]
