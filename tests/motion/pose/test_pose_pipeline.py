"""Tests of the pose pipeline against numpy and scipy: exact SLERP, the papers' formulas, matrix kinematics."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from live.base.row_ranges import row_runner
from live.graph.mean_poses import mean_poses
from live.motion import quaternion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.pose.pipeline_kernels import INTO_NEXT, LOWER, NEXT, PRESENT, PRESENT_TAKE, UPPER, head_turn
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline, PoseSkeleton
from live.motion.skeleton import JOINT_COUNT, SKELETON

SAMPLES = 24
UPPER_JOINTS = slice(1, 14)
UP = np.array([0.0, 1.0, 0.0])


def random_motion(seed, spread=0.9):
    """Smooth body motion: rotations within `spread` [rad] of one pose."""
    chance = np.random.default_rng(seed)
    time = np.linspace(0, 2 * math.pi, SAMPLES)[:, None, None]
    phase = chance.uniform(0, 2 * math.pi, (1, JOINT_COUNT, 3))
    turns = spread / math.sqrt(3) * np.sin(time + phase)
    around = quaternion.unit(chance.normal(0, 1, (JOINT_COUNT, 4)))
    size = np.linalg.norm(turns, axis=-1)
    rotation = quaternion.mul(around, quaternion.from_axis_angle(turns / size[..., None], size))
    root = chance.normal(0, 1, (1, 3)) + 0.2 * np.sin(time[:, 0] + chance.uniform(0, 6, (1, 3)))
    return root.astype(np.float32), quaternion.align_signs(rotation).astype(np.float32)


def pose_at(root, rotation, sample):
    low = min(int(sample), SAMPLES - 2)
    t = sample - low
    turned = quaternion.slerp(rotation[low].astype(float), rotation[low + 1].astype(float), np.full(JOINT_COUNT, t))
    return (1 - t) * root[low] + t * root[low + 1], turned


def place_pose(pose, place):
    root, rotation = pose
    x, z, path, body = place
    c, s = math.cos(path), math.sin(path)
    turned = np.array(rotation)
    turned[0] = quaternion.mul(quaternion.from_axis_angle(UP, np.array(body)), rotation[0])
    return np.array([x + root[0] * c + root[2] * s, root[1], z + root[2] * c - root[0] * s]), turned


def blend_poses(a, b, share):
    return (1 - share) * a[0] + share * b[0], quaternion.slerp(a[1], b[1], np.full(JOINT_COUNT, share))


def assert_pose(pipeline, row, pose, tolerance=1e-3):
    positions, rotations = forward_kinematics(pose[0][None], pose[1][None])
    assert pipeline.position[row] == pytest.approx(positions[0], abs=tolerance)
    assert np.abs((pipeline.rotation[row] * rotations[0]).sum(-1)) == pytest.approx(1.0, abs=1e-4)


def mean_pose(rotation):
    """The mean pose of a clip, as a motion graph knows it."""
    return mean_poses(rotation, np.array([0]), np.array([len(rotation) - 1]))[0]


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0, SAMPLES - 1), st.floats(0, SAMPLES - 1), st.floats(0, 1))
def test_sampling_placement_blend_and_kinematics_match(seed, first, second, weight):
    root, rotation = random_motion(seed)
    places = np.random.default_rng(seed).uniform(-3, 3, (2, 4))
    pipeline = PosePipeline(1)
    pipeline.sample[PRESENT], pipeline.sample[NEXT] = first, second
    pipeline.placement[PRESENT, 0], pipeline.placement[NEXT, 0] = places
    pipeline.share[INTO_NEXT] = weight
    pipeline.run(ClipStore.of(root, rotation))
    a, b = (place_pose(pose_at(root, rotation, s), p) for s, p in zip((first, second), places, strict=True))
    # towards half a turn apart the chord takes the arc's place
    if weight in (0.0, 1.0) or np.abs((a[1] * b[1]).sum(-1)).min() > 0.2:
        assert_pose(pipeline, 0, blend_poses(a, b, weight), 2e-3)
    assert np.linalg.norm(pipeline.rotation[0], axis=-1) == pytest.approx(1.0, abs=1e-3)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(8, SAMPLES - 1), st.floats(0.5, 7.0))
def test_late_arms_have_the_rotations_of_earlier_samples(seed, sample, late):
    """A hand is late by the whole, the forearm by 3/4, the upper arm by 1/2, the shoulder by 1/4; nothing else is."""
    root, rotation = random_motion(seed)
    pipeline, place = PosePipeline(2), np.zeros(4)
    pipeline.sample[PRESENT], pipeline.late = sample, np.zeros((4, 2), np.float32)
    pipeline.late[PRESENT, 0] = late
    pipeline.run(ClipStore.of(root, rotation))
    pose = place_pose(pose_at(root, rotation, sample), place)
    assert_pose(pipeline, 1, pose, 2e-3)
    for side in ("left", "right"):
        for share, name in ((0.25, "Shoulder"), (0.5, "UpperArm"), (0.75, "LowerArm"), (1.0, "Hand")):
            joint = SKELETON.index(side + name)
            pose[1][joint] = pose_at(root, rotation, sample - share * late)[1][joint]
    assert_pose(pipeline, 0, pose, 2e-3)


def test_blend_between_distant_poses_is_continuous():
    """An elbow bent by 100 degrees one way blends into 100 degrees the other way through the straight arm, not around
    the back, and a moving clip never switches the side: the shorter arc would.
    """
    joint = SKELETON.index("leftLowerArm")
    bends = np.concatenate([np.linspace(80, 110, SAMPLES), np.linspace(-80, -110, SAMPLES)])
    rotation = np.zeros((2 * SAMPLES, JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    rotation[:, joint] = quaternion.from_axis_angle(UP, np.radians(bends))
    pipeline = PosePipeline(SAMPLES)
    pipeline.sample[PRESENT] = np.arange(SAMPLES)
    pipeline.sample[NEXT] = np.arange(SAMPLES, 2 * SAMPLES)
    pipeline.share[INTO_NEXT] = np.linspace(0, 1, SAMPLES)
    pipeline.run(ClipStore.of(np.zeros((2 * SAMPLES, 3), np.float32), rotation))
    hand = pipeline.position[:, SKELETON.index("leftHand")]
    way = np.linalg.norm(np.diff(hand, axis=0), axis=1)
    assert way.max() < 3.0 * way.mean()
    assert hand[:, 0].max() == pytest.approx(pipeline.position[0, joint, 0] + 0.245, abs=0.01)  # straight half way


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0, 1), st.floats(0, 1))
def test_takes_are_mixed_per_body_half(seed, lower, upper):
    """T045: equal shares give SLERP of the clips; T044: only the upper body's rotations come from the other clip."""
    root, rotation = random_motion(seed, spread=0.4)
    pipeline = PosePipeline(1)
    pipeline.sample[PRESENT], pipeline.sample[PRESENT_TAKE] = 3.25, 17.5
    pipeline.share[LOWER], pipeline.share[UPPER] = lower, upper
    pipeline.run(ClipStore.of(root, rotation))
    a, b = pose_at(root, rotation, 3.25), pose_at(root, rotation, 17.5)
    wanted = blend_poses(a, b, lower)
    wanted[1][UPPER_JOINTS] = blend_poses(a, b, upper)[1][UPPER_JOINTS]
    assert_pose(pipeline, 0, wanted)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.5, 1.5), st.floats(0, SAMPLES - 1))
def test_amplitude_matches_t058_formula(seed, amplitude, sample):
    """q' = q_mean (q_mean^-1 q)^r on the upper body, by scipy's rotation vectors; the lower body stays."""
    root, rotation = random_motion(seed)
    mean = mean_pose(rotation)
    pipeline = PosePipeline(1)
    pipeline.sample[PRESENT] = sample
    pipeline.amplitude[:] = amplitude
    pipeline.run(ClipStore.of(root, rotation, mean[None]))
    place, pose = pose_at(root, rotation, sample)
    middle, own = (Rotation.from_quat(np.roll(q[UPPER_JOINTS], -1, axis=-1)) for q in (mean, pose))
    larger = middle * Rotation.from_rotvec(amplitude * (middle.inv() * own).as_rotvec())
    wanted = np.array(pose)
    wanted[UPPER_JOINTS] = np.roll(larger.as_quat(), 1, axis=-1)
    assert_pose(pipeline, 0, (place, wanted), 2e-3)


def test_mean_pose_has_zero_mean_deviation():
    """The mean of the rotation vectors from the mean pose is zero (T058's mean, in log space)."""
    _, rotation = random_motion(5)
    middle = Rotation.from_quat(np.roll(mean_pose(rotation), -1, axis=-1))
    away = [(middle.inv() * Rotation.from_quat(np.roll(q, -1, axis=-1))).as_rotvec() for q in rotation]
    assert np.mean(away, axis=0) == pytest.approx(0.0, abs=0.02)
    assert mean_pose(rotation[:1]) == pytest.approx(rotation[0], abs=1e-6)


class BackwardRunner:
    """A runner that does the ranges in the opposite order."""

    threads = 3

    def run(self, part, ranges):
        for begin, end in reversed(ranges):
            part(begin, end)


@pytest.mark.parametrize("count", [1, 31, 32, 33, 100, 300])
def test_dancers_are_independent_of_others_and_threads(count):
    chance = np.random.default_rng(count)
    store = ClipStore.of(*random_motion(1), mean_pose(random_motion(1)[1])[None])
    whole = PosePipeline(count)
    fields = ("sample", "placement", "share", "amplitude", "head", "feet")
    for name in fields:
        getattr(whole, name)[:] = chance.uniform(0, 1, getattr(whole, name).shape)
    whole.sample *= SAMPLES - 1
    whole.lock = True
    position, rotation = (array.copy() for array in whole.run(store))
    with row_runner(BackwardRunner()):
        again = whole.run(store, (np.empty_like(position), np.empty_like(rotation)))
    assert np.array_equal(again[0], position)
    assert np.array_equal(again[1], rotation)
    one = PosePipeline(1)
    for dancer in {0, count // 2, count - 1}:
        for name in fields:
            array = getattr(whole, name)
            axis = 0 if name in ("amplitude", "head", "feet") else 1
            getattr(one, name)[:] = np.take(array, [dancer], axis)
        one.lock = True
        found = one.run(store)
        assert np.array_equal(found[0][0], position[dancer])
        assert np.array_equal(found[1][0], rotation[dancer])


def test_samples_outside_clips_are_clamped():
    root, rotation = random_motion(3)
    pipeline = PosePipeline(2)
    pipeline.sample[PRESENT] = -5.0, 1e9
    pipeline.run(ClipStore.of(root, rotation))
    assert_pose(pipeline, 0, (root[0], rotation[0]))
    assert_pose(pipeline, 1, (root[-1], rotation[-1]))


def test_bone_lengths_stay_with_all_edits():
    chance = np.random.default_rng(2)
    root, rotation = random_motion(7)
    pipeline = PosePipeline(64)
    pipeline.sample[:] = chance.uniform(0, SAMPLES - 1, (4, 64))
    pipeline.share[:] = chance.uniform(0, 1, (5, 64))
    pipeline.amplitude[:], pipeline.head[:] = chance.uniform(0.8, 1.2, 64), chance.uniform(0, 1, 64)
    pipeline.feet[:, :, :2] = chance.normal(0, 0.1, (64, 2, 2))
    pipeline.lock = True
    pipeline.run(ClipStore.of(root, rotation, mean_pose(rotation)[None]))
    bones = pipeline.position[:, 1:] - pipeline.position[:, SKELETON.parents[1:]]
    wanted = np.linalg.norm(SKELETON.offsets[1:], axis=1)
    # a Newton step makes blended rotations unit: where clips half a turn apart meet, bones may be a few mm long
    assert np.percentile(np.abs(np.linalg.norm(bones, axis=2) - wanted), 99) < 2e-4


def heading(rotation):
    x, _, z = quaternion.rotate(rotation.astype(float), np.array([0.0, 0.0, 1.0]))
    return math.atan2(x, z)


def upright(turned):
    """A standing body whose chest is turned by `turned` [rad] from the audience."""
    rotation = np.zeros((1, JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    rotation[0, 0] = quaternion.from_axis_angle(UP, np.array(turned))
    return ClipStore.of(SKELETON.offsets[:1], rotation)


@given(st.floats(-math.pi, math.pi))
def test_head_faces_audience_within_neck_limit(turned):
    """T123-T125: the head faces 0 while the body is within 40 degrees, and never exceeds 60 from the chest."""
    pipeline = PosePipeline(1)
    pipeline.head[:] = 1.0
    pipeline.run(upright(turned))
    head, chest = (heading(pipeline.rotation[0, SKELETON.index(name)]) for name in ("head", "upperChest"))
    neck = math.remainder(head - chest, 2 * math.pi)
    assert abs(neck) <= math.radians(60.0) + 1e-4
    if abs(turned) < math.radians(45.0):
        assert head == pytest.approx(0.0, abs=1e-4)


def test_head_turn_is_continuous_over_spin():
    """Over a whole spin the neck angle is continuous and at most as fast as the body."""
    turns = np.linspace(-math.pi, math.pi, 20001)
    neck = np.array([head_turn(turn) for turn in turns])
    slope = np.diff(neck) / np.diff(turns)
    assert np.abs(slope).max() < 1.01
    assert neck[0] == pytest.approx(neck[-1], abs=1e-9)
    assert np.abs(np.diff(slope)).max() < 0.01  # rounded corners


def test_head_looking_straight_down_stays_unchanged():
    store = upright(0.4)
    store.rotation[0, SKELETON.index("head")] = quaternion.from_axis_angle(np.array([1.0, 0, 0]), np.array(math.pi / 2))
    with_head, without = PosePipeline(1), PosePipeline(1)
    with_head.head[:] = 1.0
    assert np.array_equal(with_head.run(store)[1], without.run(store)[1])


def test_legs_only_skeleton_gives_same_legs():
    root, rotation = random_motion(11)
    skeleton, joints = PoseSkeleton.legs_only()
    whole, legs = PosePipeline(5), PosePipeline(5, skeleton)
    whole.sample[PRESENT] = legs.sample[PRESENT] = np.linspace(0, SAMPLES - 1, 5)
    whole.run(ClipStore.of(root, rotation))
    legs.run(ClipStore.of(root, rotation[:, joints]))
    assert legs.position == pytest.approx(whole.position[:, joints], abs=1e-5)
