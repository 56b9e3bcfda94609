"""Tests of BVH world poses: the T164 example, and an independent implementation by 4x4 matrices."""

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.formats.bvh_reader import BvhMotion, bvh_to_source_motion, local_pose, parse_bvh
from live.motion.formats.source_motion import end_positions, rest_pose, world_pose
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import Skeleton
from tests.fixtures.mocap import mocap_bvh

ARM = """HIERARCHY
ROOT A
{
  OFFSET 0.000000 0.000000 0.000000
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT B
  {
    OFFSET 10.000000 0.000000 0.000000
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0.000000 -20.000000 0.000000
    }
  }
}

MOTION
Frames:    3
Frame Time: 0.040000
30.0    80.0    20.0    0.0    0.0    0.0    0.0    0.0    0.0
30.0    80.0    20.0    60.0   0.0    0.0    0.0    0.0    0.0
30.0    80.0    20.0    60.0   0.0    0.0   -30.0   0.0    0.0
"""


def test_t164_example_is_reproduced() -> None:
    """B and C = End Site in the three frames, as printed (row T164 of Schulz 2011, appendix B)."""
    motion = parse_bvh(ARM, "arm.bvh")
    world = world_pose(motion.parents, local_pose(motion))
    np.testing.assert_allclose(world.positions[:, 0], [(30, 80, 20)] * 3)
    np.testing.assert_allclose(world.positions[:, 1], [(40, 80, 20), (35, 88.6603, 20), (35, 88.6603, 20)], atol=5e-5)
    ends = end_positions(bvh_to_source_motion(motion), world)[:, 0]
    np.testing.assert_allclose(ends, [(40, 60, 20), (52.3205, 78.6603, 20), (45, 71.3397, 20)], atol=5e-5)


def axis_matrix(letter: str, value: float) -> np.ndarray:
    """4x4 matrix of one channel: x y z translate, X Y Z rotate by degrees."""
    m = np.eye(4)
    if letter.islower():
        m["xyz".index(letter), 3] = value
        return m
    a, b = [n for n in range(3) if n != "XYZ".index(letter)]
    c, s = np.cos(np.deg2rad(value)), np.sin(np.deg2rad(value))
    if letter == "Y":
        s = -s
    m[a, a], m[a, b], m[b, a], m[b, b] = c, -s, s, c
    return m


def world_matrices(motion: BvhMotion, frame: int) -> np.ndarray:
    """World matrices (J, 4, 4): OFFSET, then all translations, then all rotations in channel order."""
    world = np.empty((motion.joint_count, 4, 4))
    column = 0
    for joint, letters in enumerate(motion.channels):
        own = np.eye(4)
        own[:3, 3] = motion.offsets[joint]
        channels = list(zip(letters, motion.values[frame, column : column + len(letters)], strict=True))
        column += len(letters)
        for letter, value in sorted(channels, key=lambda one: one[0].isupper()):
            own = own @ axis_matrix(letter, value)
        parent = motion.parents[joint]
        world[joint] = own if parent < 0 else world[parent] @ own
    return world


@pytest.mark.shared
@pytest.mark.parametrize(
    "name",
    [
        "salsa/60_01.bvh",
        "group/perfume_aachan.bvh",
        "walk/131_01_styled.bvh",
        "edge/rotation_before_position_root.bvh",
        "edge/mixed_rotation_orders.bvh",
        "edge/leaf_without_end_site.bvh",
        "edge/makehuman_walk1.bvh",
        "edge/minimal_2joints.bvh",
        "edge/xyz_with_yxz_joints_dab.bvh",
    ],
)
def test_real_files_match_matrices(name: str) -> None:
    motion = mocap_bvh(name)
    world = world_pose(motion.parents, local_pose(motion))
    size = np.abs(world.positions).max()
    for frame in np.unique(np.linspace(0, motion.frame_count - 1, 7).astype(int)):
        expected = world_matrices(motion, int(frame))
        np.testing.assert_allclose(world.positions[frame], expected[:, :3, 3], atol=1e-9 * size)
        pointer = np.array((0.2, 0.5, 0.8))
        turned = np.einsum("jab,b->ja", expected[:, :3, :3], pointer)
        np.testing.assert_allclose(quaternion.rotate(world.rotations[frame], pointer), turned, atol=1e-12)


@pytest.mark.shared
@pytest.mark.parametrize("name", ["walk/figure8_MS2_8Walk_M.bvh", "edge/blender_rigify_metres_freemocap.bvh"])
def test_position_channels_on_joints_keep_bone_lengths(name: str) -> None:
    motion = mocap_bvh(name)
    world = world_pose(motion.parents, local_pose(motion))
    for joint in range(1, motion.joint_count):
        length = np.linalg.norm(world.positions[:, joint] - world.positions[:, motion.parents[joint]], axis=-1)
        np.testing.assert_allclose(length, np.linalg.norm(motion.offsets[joint]), atol=0.012)


def test_random_layouts_match_matrices() -> None:
    rng = np.random.default_rng(3)
    names = {**{c.lower(): f"{c}position" for c in "XYZ"}, **{c: f"{c}rotation" for c in "XYZ"}}
    for _ in range(30):
        text, count, total = "HIERARCHY\n", int(rng.integers(1, 9)), 0
        for joint in range(count):
            positions = rng.permutation(list("xyz"))[: rng.integers(0, 4)] if joint == 0 else []
            letters = [*positions, *rng.permutation(list("XYZ"))[: rng.integers(0 if total else 1, 4)]]
            rng.shuffle(letters)
            total += len(letters)
            offset = " ".join(map(str, rng.uniform(-9, 9, 3)))
            channels = " ".join(names[str(letter)] for letter in letters)
            text += f"{'JOINT' if joint else 'ROOT'} j{joint} {{ OFFSET {offset} CHANNELS {len(letters)} {channels}\n"
        rows = "\n".join(" ".join(map(str, row)) for row in rng.uniform(-400, 400, (3, total)))
        motion = parse_bvh(f"{text}{'}' * count}\nMOTION\nFrames: 3\nFrame Time: 0.1\n{rows}\n", "random")
        world = world_pose(motion.parents, local_pose(motion))
        for frame in range(3):
            np.testing.assert_allclose(world.positions[frame], world_matrices(motion, frame)[:, :3, 3], atol=1e-9)


def test_root_channels_add_to_or_replace_offset() -> None:
    motion = parse_bvh(ARM.replace("OFFSET 0.000000 0.000000 0.000000", "OFFSET 30 80 20", 1), "arm.bvh")
    added = world_pose(motion.parents, local_pose(motion))
    replaced = world_pose(motion.parents, local_pose(motion, "replace"))
    assert added.positions[0, 0].tolist() == [60, 160, 40]
    assert replaced.positions[0, 0].tolist() == [30, 80, 20]
    np.testing.assert_allclose(added.rotations, replaced.rotations)


@pytest.mark.parametrize(
    ("moved", "expected"), [("10 0 0", 10.0), ("10.5 0 0", 10.5), ("0 0 0", 10.0), ("0.5 0 0", 10.5)]
)
def test_inner_positions_replace_or_add_to_offset(moved: str, expected: float) -> None:
    text = f"""HIERARCHY
ROOT A {{ OFFSET 0 0 0 CHANNELS 3 Zrotation Xrotation Yrotation
  JOINT B {{ OFFSET 10 0 0 CHANNELS 3 Xposition Yposition Zposition }} }}
MOTION
Frames: 1
Frame Time: 0.1
0 0 0 {moved}
"""
    motion = parse_bvh(text, "x")
    assert world_pose(motion.parents, local_pose(motion)).positions[0, 1].tolist() == [expected, 0, 0]


@pytest.mark.shared
def test_engine_forward_kinematics_matches_world_pose() -> None:
    motion = mocap_bvh("salsa/60_01.bvh")
    local = local_pose(motion)
    skeleton = Skeleton(motion.names, motion.parents, motion.offsets.astype(np.float32))
    positions, _ = forward_kinematics(local.translation[:100, 0], local.rotation[:100], skeleton)
    np.testing.assert_allclose(positions, world_pose(motion.parents, local).positions[:100], atol=1e-4)


def test_rest_pose_is_sum_of_offsets() -> None:
    motion = parse_bvh(ARM, "arm.bvh")
    assert rest_pose(bvh_to_source_motion(motion)).positions[0].tolist() == [[0, 0, 0], [10, 0, 0]]
