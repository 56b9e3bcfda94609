"""The pose pipeline against numpy and scipy: exact SLERP, the papers' formulas, forward kinematics by matrices."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from live.motion import quaternion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.pose.pipeline_kernels import INTO_NEXT, LOWER, NEXT, PRESENT, PRESENT_TAKE, UPPER, head_turn
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline, PoseSkeleton, mean_pose
from live.motion.skeleton import JOINT_COUNT, SKELETON

SAMPLES = 24
UPPER_JOINTS = slice(1, 14)
UP = np.array([0.0, 1.0, 0.0])


def clips(seed, spread=0.9):
    """Motion as bodies make it: rotations near a pose, up to `spread` [rad] from it, changing smoothly."""
    chance = np.random.default_rng(seed)
    time = np.linspace(0, 2 * math.pi, SAMPLES)[:, None, None]
    phase = chance.uniform(0, 2 * math.pi, (1, JOINT_COUNT, 3))
    turns = spread / math.sqrt(3) * np.sin(time + phase)
    around = quaternion.unit(chance.normal(0, 1, (JOINT_COUNT, 4)))
    size = np.linalg.norm(turns, axis=-1)
    rotation = quaternion.mul(around, quaternion.from_axis_angle(turns / size[..., None], size))
    root = chance.normal(0, 1, (1, 3)) + 0.2 * np.sin(time[:, 0] + chance.uniform(0, 6, (1, 3)))
    return root.astype(np.float32), quaternion.align_signs(rotation).astype(np.float32)


def at(root, rotation, sample):
    low = min(int(sample), SAMPLES - 2)
    t = sample - low
    turned = quaternion.slerp(rotation[low].astype(float), rotation[low + 1].astype(float), np.full(JOINT_COUNT, t))
    return (1 - t) * root[low] + t * root[low + 1], turned


def placed(pose, place):
    root, rotation = pose
    x, z, path, body = place
    c, s = math.cos(path), math.sin(path)
    turned = np.array(rotation)
    turned[0] = quaternion.mul(quaternion.from_axis_angle(UP, np.array(body)), rotation[0])
    return np.array([x + root[0] * c + root[2] * s, root[1], z + root[2] * c - root[0] * s]), turned


def blended(a, b, share):
    return (1 - share) * a[0] + share * b[0], quaternion.slerp(a[1], b[1], np.full(JOINT_COUNT, share))


def close(pipeline, row, pose, tolerance=1e-3):
    positions, rotations = forward_kinematics(pose[0][None], pose[1][None])
    assert pipeline.position[row] == pytest.approx(positions[0], abs=tolerance)
    assert np.abs((pipeline.rotation[row] * rotations[0]).sum(-1)) == pytest.approx(1.0, abs=1e-4)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0, SAMPLES - 1), st.floats(0, SAMPLES - 1), st.floats(0, 1))
def test_sample_place_blend_and_forward_kinematics(seed, first, second, weight):
    root, rotation = clips(seed)
    places = np.random.default_rng(seed).uniform(-3, 3, (2, 4))
    pipeline = PosePipeline(1)
    pipeline.sample[PRESENT], pipeline.sample[NEXT] = first, second
    pipeline.placement[PRESENT, 0], pipeline.placement[NEXT, 0] = places
    pipeline.share[INTO_NEXT] = weight
    pipeline.run(ClipStore.of(root, rotation))
    a, b = (placed(at(root, rotation, s), p) for s, p in zip((first, second), places, strict=True))
    # towards half a turn apart the chord takes the arc's place
    if weight in (0.0, 1.0) or np.abs((a[1] * b[1]).sum(-1)).min() > 0.2:
        close(pipeline, 0, blended(a, b, weight), 2e-3)
    assert np.linalg.norm(pipeline.rotation[0], axis=-1) == pytest.approx(1.0, abs=1e-3)


def test_a_blend_between_far_poses_never_jumps():
    """An elbow bent by 100 degrees one way blends into 100 degrees the other way through the straight arm, not round
    the back, and a moving clip never makes it change its mind: the shorter arc would."""
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
def test_another_take_in_the_lower_and_in_the_upper_body(seed, lower, upper):
    """T045: both alike is SLERP of the clips; T044: the upper body's rotations alone are the other clip's."""
    root, rotation = clips(seed, spread=0.4)
    pipeline = PosePipeline(1)
    pipeline.sample[PRESENT], pipeline.sample[PRESENT_TAKE] = 3.25, 17.5
    pipeline.share[LOWER], pipeline.share[UPPER] = lower, upper
    pipeline.run(ClipStore.of(root, rotation))
    a, b = at(root, rotation, 3.25), at(root, rotation, 17.5)
    wanted = blended(a, b, lower)
    wanted[1][UPPER_JOINTS] = blended(a, b, upper)[1][UPPER_JOINTS]
    close(pipeline, 0, wanted)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.5, 1.5), st.floats(0, SAMPLES - 1))
def test_amplitude_is_the_formula_of_t058(seed, amplitude, sample):
    """q' = q_mean (q_mean^-1 q)^r on the upper body, by scipy's rotation vectors; the lower body stays."""
    root, rotation = clips(seed)
    mean = mean_pose(rotation)
    pipeline = PosePipeline(1)
    pipeline.sample[PRESENT] = sample
    pipeline.amplitude[:] = amplitude
    pipeline.run(ClipStore.of(root, rotation, mean[None]))
    place, pose = at(root, rotation, sample)
    middle, own = (Rotation.from_quat(np.roll(q[UPPER_JOINTS], -1, axis=-1)) for q in (mean, pose))
    larger = middle * Rotation.from_rotvec(amplitude * (middle.inv() * own).as_rotvec())
    wanted = np.array(pose)
    wanted[UPPER_JOINTS] = np.roll(larger.as_quat(), 1, axis=-1)
    close(pipeline, 0, (place, wanted), 2e-3)


def test_the_mean_pose_leaves_nothing_on_the_average():
    """The mean of the rotation vectors from it is zero (T058's mean, in log space)."""
    _, rotation = clips(5)
    middle = Rotation.from_quat(np.roll(mean_pose(rotation), -1, axis=-1))
    away = [(middle.inv() * Rotation.from_quat(np.roll(q, -1, axis=-1))).as_rotvec() for q in rotation]
    assert np.mean(away, axis=0) == pytest.approx(0.0, abs=0.02)
    assert mean_pose(rotation[:1]) == pytest.approx(rotation[0], abs=1e-6)


@pytest.mark.parametrize("count", [1, 31, 32, 33, 100])
def test_no_dancer_depends_on_the_others_or_on_threads(count):
    chance = np.random.default_rng(count)
    store = ClipStore.of(*clips(1), mean_pose(clips(1)[1])[None])
    whole = PosePipeline(count)
    fields = ("sample", "placement", "share", "amplitude", "head", "feet")
    for name in fields:
        getattr(whole, name)[:] = chance.uniform(0, 1, getattr(whole, name).shape)
    whole.sample *= SAMPLES - 1
    whole.lock = True
    position, rotation = (array.copy() for array in whole.run(store))
    threads = PosePipeline(count, threads=2)
    for name in fields:
        getattr(threads, name)[:] = getattr(whole, name)
    threads.lock = True
    assert np.array_equal(threads.run(store)[0], position)
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


def test_samples_outside_the_clips_are_their_ends():
    root, rotation = clips(3)
    pipeline = PosePipeline(2)
    pipeline.sample[PRESENT] = -5.0, 1e9
    pipeline.run(ClipStore.of(root, rotation))
    close(pipeline, 0, (root[0], rotation[0]))
    close(pipeline, 1, (root[-1], rotation[-1]))


def test_bones_keep_their_lengths_with_every_edit():
    chance = np.random.default_rng(2)
    root, rotation = clips(7)
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
    """A standing body whose chest is turned by `turned` [rad] from the public."""
    rotation = np.zeros((1, JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    rotation[0, 0] = quaternion.from_axis_angle(UP, np.array(turned))
    return ClipStore.of(SKELETON.offsets[:1], rotation)


@given(st.floats(-math.pi, math.pi))
def test_heads_face_the_public_as_far_as_necks_allow(turned):
    """T123-T125: the final head faces 0 while the body is within 40 degrees, and is never beyond 60 from the chest."""
    pipeline = PosePipeline(1)
    pipeline.head[:] = 1.0
    pipeline.run(upright(turned))
    head, chest = (heading(pipeline.rotation[0, SKELETON.index(name)]) for name in ("head", "upperChest"))
    neck = math.remainder(head - chest, 2 * math.pi)
    assert abs(neck) <= math.radians(60.0) + 1e-4
    if abs(turned) < math.radians(45.0):
        assert head == pytest.approx(0.0, abs=1e-4)


def test_the_head_swings_round_without_a_jump():
    """Over a whole spin the neck's angle is continuous and its speed at most that of the body."""
    turns = np.linspace(-math.pi, math.pi, 20001)
    neck = np.array([head_turn(turn) for turn in turns])
    slope = np.diff(neck) / np.diff(turns)
    assert np.abs(slope).max() < 1.01
    assert neck[0] == pytest.approx(neck[-1], abs=1e-9)
    assert np.abs(np.diff(slope)).max() < 0.01  # rounded corners


def test_a_head_that_looks_straight_down_is_left_alone():
    store = upright(0.4)
    store.rotation[0, SKELETON.index("head")] = quaternion.from_axis_angle(np.array([1.0, 0, 0]), np.array(math.pi / 2))
    with_head, without = PosePipeline(1), PosePipeline(1)
    with_head.head[:] = 1.0
    assert np.array_equal(with_head.run(store)[1], without.run(store)[1])


def test_legs_only_gives_the_same_legs():
    root, rotation = clips(11)
    skeleton, joints = PoseSkeleton.legs_only()
    whole, legs = PosePipeline(5), PosePipeline(5, skeleton)
    whole.sample[PRESENT] = legs.sample[PRESENT] = np.linspace(0, SAMPLES - 1, 5)
    whole.run(ClipStore.of(root, rotation))
    legs.run(ClipStore.of(root, rotation[:, joints]))
    assert legs.position == pytest.approx(whole.position[:, joints], abs=1e-5)
