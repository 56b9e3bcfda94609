"""Tests of inertialization against Bollo's conditions: value and speed kept at the cut, full decay, no overshoot."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from live.motion import quaternion
from live.motion.pose.inertialization import Inertialization
from live.motion.pose.inertialization_kernels import MAX_FADE_TIME, MIN_FADE_TIME, update_ages
from live.motion.pose.pipeline_kernels import PRESENT
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline, PoseSkeleton
from live.motion.skeleton import JOINT_COUNT

RATE = 64.0
DT = 1.0 / RATE
SAMPLES = 64
COUNT = 40  # more than a block


def smooth_clips(seed, spread=0.7):
    """Two motions of a body within `spread` [rad] of one pose, stored one after the other."""
    chance = np.random.default_rng(seed)
    around = quaternion.unit(chance.normal(0, 1, (JOINT_COUNT, 4)))
    time = np.linspace(0, 2 * math.pi, SAMPLES)[:, None, None]
    rotations, roots = [], []
    for _ in range(2):
        turns = spread / math.sqrt(3) * np.sin(time + chance.uniform(0, 2 * math.pi, (1, JOINT_COUNT, 3)))
        size = np.linalg.norm(turns, axis=-1)
        rotations.append(quaternion.mul(around, quaternion.from_axis_angle(turns / size[..., None], size)))
        roots.append(0.3 * np.sin(time[:, 0] + chance.uniform(0, 6, (1, 3))))
    rotation = quaternion.align_signs(np.concatenate(rotations)).astype(np.float32)
    return ClipStore.of(np.concatenate(roots).astype(np.float32), rotation)


class Cut:
    """COUNT dancers who cut from individual samples of the first clip to random samples of the second."""

    def __init__(self, seed, spread=0.7):
        chance = np.random.default_rng(seed)
        self.store = smooth_clips(seed, spread)
        self.old = chance.integers(4, SAMPLES - 34, COUNT) + 0.5
        self.new = SAMPLES + chance.integers(4, SAMPLES - 34, COUNT) + 0.5
        self.inertia = Inertialization(COUNT, JOINT_COUNT)
        self.pipeline = PosePipeline(COUNT)
        self.pipeline.difference, self.pipeline.age = self.inertia.difference, self.inertia.age
        before = self._two(self.old)
        after = self._two(self.new)
        rows = np.arange(COUNT, dtype=np.int32)
        self.inertia.cut(rows, before, after, self.pipeline.skeleton.parents, time=10.0, dt=DT)

    def _two(self, sample):
        found = [self.clip(sample - back) for back in (0.0, 1.0)]
        return tuple(np.stack([pose[k] for pose in found]) for k in range(2))

    def clip(self, sample):
        """Positions and rotations of the clips alone."""
        self.inertia.age[:] = MAX_FADE_TIME
        self.pipeline.sample[PRESENT] = sample
        return tuple(array.copy() for array in self.pipeline.run(self.store))

    def shown(self, seconds):
        """The same `seconds` after the cut, with the remaining old motion."""
        self.inertia.update_age(10.0 + seconds)
        self.pipeline.sample[PRESENT] = self.new + seconds * RATE
        return tuple(array.copy() for array in self.pipeline.run(self.store))


@pytest.mark.long
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 1.3))
def test_pose_is_continuous_at_cut(seed, spread):
    cut = Cut(seed, spread)
    position, rotation = cut.shown(0.0)
    old_position, old_rotation = cut.clip(cut.old)
    assert position == pytest.approx(old_position, abs=2e-5)
    assert np.abs((rotation * old_rotation).sum(-1)) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.long
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 1.0))
def test_speed_is_continuous_at_cut(seed, spread):
    """Between two frames a hundredth of a tick apart, against the old clip's speed between its samples."""
    cut = Cut(seed, spread)
    small = 0.01 * DT
    now, then = cut.shown(0.0)[0].astype(np.float64), cut.shown(small)[0]
    old = (cut.clip(cut.old)[0].astype(np.float64) - cut.clip(cut.old - 1.0)[0]) * RATE
    speed = (then - now) / small
    jump = np.linalg.norm(speed - old, axis=-1)
    # both clips' own accelerations within a tick (the old speed is that of the tick before), and float32 over so short
    # a time
    bends = [cut.clip(at + 1)[0] - 2 * cut.clip(at)[0] + cut.clip(at - 1)[0] for at in (cut.new, cut.old - 1.0)]
    turning = sum(np.linalg.norm(bend, axis=-1).max() for bend in bends)
    assert jump.max() < RATE * turning + 0.15


@given(st.integers(0, 2**32 - 1))
def test_difference_is_zero_after_maximum_fade_time(seed):
    cut = Cut(seed)
    for seconds in (MAX_FADE_TIME, MAX_FADE_TIME + 0.05):
        shown, clip = cut.shown(seconds), cut.clip(cut.new + seconds * RATE)
        assert (shown[0] == clip[0]).all()
        assert (shown[1] == clip[1]).all()


def test_dancers_without_cut_stay_unchanged():
    """One dancer of a block is cut: the other dancers are bit for bit the same."""
    cut = Cut(5)
    plain = cut.clip(cut.new)
    cut.inertia.clear(np.flatnonzero(np.arange(COUNT) != 3))
    cut.inertia.update_age(10.0)
    cut.pipeline.sample[PRESENT] = cut.new
    shown = cut.pipeline.run(cut.store)
    others = np.arange(COUNT) != 3
    assert (shown[0][others] == plain[0][others]).all()
    assert (shown[1][others] == plain[1][others]).all()
    assert np.abs(shown[0][3] - plain[0][3]).max() > 0.01


def decayed_difference(offset, speed, seconds):
    """Remaining difference of one joint after each of `seconds`, as the kernels let it fade, (T, 3)."""
    inertia = Inertialization(1, JOINT_COUNT)
    parents = PosePipeline(1).skeleton.parents
    rest = np.zeros((2, 1, JOINT_COUNT, 3), np.float32), np.tile(np.float32([1, 0, 0, 0]), (2, 1, JOINT_COUNT, 1))
    old = rest[0].copy()
    old[0, 0, 0], old[1, 0, 0] = offset, offset - DT * speed
    inertia.cut(np.zeros(1, np.int32), (old, rest[1]), rest, parents, time=0.0, dt=DT)
    pipeline = PosePipeline(1)
    pipeline.difference, pipeline.age = inertia.difference, inertia.age
    still = ClipStore.of(np.zeros((2, 3), np.float32), rest[1][:, 0])
    found = []
    for at in seconds:
        inertia.update_age(at)
        found.append(pipeline.run(still)[0][0, 0].copy())
    return np.array(found, np.float64), float(inertia.difference[0, JOINT_COUNT, 6])


def quintic(offset, speed, duration, seconds):
    """The polynomial of Bollo's six conditions, from solving for its coefficients."""
    t = duration
    powers = np.arange(6)
    rows = [
        np.eye(6)[0], np.eye(6)[1], 2 * np.eye(6)[2], t**powers, powers * t ** np.maximum(powers - 1, 0),
        powers * (powers - 1) * t ** np.maximum(powers - 2, 0),
    ]  # fmt: skip
    wanted = np.zeros((6, 3))
    wanted[0], wanted[1] = offset, speed
    coefficients = np.linalg.solve(np.array(rows), wanted)
    left = np.minimum(np.array(seconds), duration)
    return (left[:, None] ** powers) @ coefficients


@given(st.integers(0, 2**32 - 1))
def test_difference_fades_by_quintic_within_bound(seed):
    chance = np.random.default_rng(seed)
    offset, speed = chance.normal(0, 0.3, 3), chance.normal(0, 2.0, 3)
    seconds = np.linspace(0.0, MAX_FADE_TIME, 41)
    found, duration = decayed_difference(offset, speed, seconds)
    assert MIN_FADE_TIME <= duration <= MAX_FADE_TIME + 1e-6
    assert found == pytest.approx(quintic(offset, speed, duration, seconds), abs=2e-4)
    bound = np.linalg.norm(offset) + 0.2 * duration * np.linalg.norm(speed)
    assert np.linalg.norm(found, axis=-1).max() <= bound + 1e-4


@given(st.floats(0.02, 1.0), st.floats(0.0, 1.0), st.integers(0, 2**32 - 1))
def test_closing_difference_never_overshoots(size, share, seed):
    """Bollo's bound: while the shortest fade permits, the difference shrinks steadily and never changes sign."""
    way = np.random.default_rng(seed).normal(0, 1, 3)
    way /= np.linalg.norm(way)
    fastest = 2.5 * size / MIN_FADE_TIME
    found, _ = decayed_difference(size * way, -share * fastest * way, np.linspace(0.0, MAX_FADE_TIME, 81))
    along = found @ way
    assert along.min() > -2e-4 * (1.0 + size)
    assert np.diff(along).max() < 2e-4 * (1.0 + size)


def test_rotation_difference_takes_shorter_arc():
    """Shoulders 170 degrees apart about changing axes: the difference never exceeds that and never flips."""
    store_rotation = np.tile(np.float32([1, 0, 0, 0]), (4, JOINT_COUNT, 1))
    store_rotation[1, 5] = np.roll(Rotation.from_euler("z", 170, degrees=True).as_quat(), 1)
    store_rotation[0, 5] = np.roll(Rotation.from_euler("z", 189, degrees=True).as_quat(), 1)
    store = ClipStore.of(np.zeros((4, 3), np.float32), store_rotation)
    pipeline = PosePipeline(1)
    poses = {}
    for sample in range(4):
        pipeline.sample[PRESENT] = sample
        poses[sample] = tuple(array.copy() for array in pipeline.run(store))
    inertia = Inertialization(1, JOINT_COUNT)
    old = tuple(np.stack([poses[1][k], poses[0][k]]) for k in range(2))
    new = tuple(np.stack([poses[2][k], poses[3][k]]) for k in range(2))
    inertia.cut(np.zeros(1, np.int32), old, new, pipeline.skeleton.parents, time=0.0, dt=DT)
    offset, speed = inertia.difference[0, 5, :3], inertia.difference[0, 5, 3:6]
    assert math.degrees(np.linalg.norm(offset)) == pytest.approx(170.0, abs=0.1)
    assert math.degrees(speed[2] * DT) == pytest.approx(-19.0, abs=0.1)  # 189 to 170, not -171 to 170


def test_legs_only_skeleton_has_same_differences():
    """The foot lock uses nine joints: their positions must equal those of the whole body."""
    cut = Cut(11)
    whole = cut.shown(0.1)[0]
    skeleton, joints = PoseSkeleton.legs_only()
    legs = PosePipeline(COUNT, skeleton)
    legs.sample, legs.difference, legs.age = cut.pipeline.sample, cut.inertia.difference, cut.inertia.age
    legs.difference_rows = joints
    store = ClipStore.of(cut.store.root, cut.store.rotation[:, joints])
    assert legs.run(store)[0] == pytest.approx(whole[:, joints], abs=1e-6)


def test_cut_age_grows_to_maximum():
    age, began = np.zeros(3, np.float32), np.array([1.0, -np.inf, 1.3])
    assert update_ages(age, began, 1.35)
    np.testing.assert_allclose(age, [0.35, MAX_FADE_TIME, 0.05], atol=1e-6)
    assert not update_ages(age, began, 3.0)
