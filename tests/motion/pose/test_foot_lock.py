"""Tests of foot lock: support feet stay, legs keep their lengths, released feet return without a jump."""

import numpy as np
import pytest

from live.library.step_folder import load_folder
from live.motion.clip import Clip
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.forward_kinematics import forward_kinematics
from live.motion.pose.foot_lock import LEG_JOINTS, FootLock, lock_feet
from live.motion.pose.foot_lock_kernels import (
    HELD,
    MAX_SHIFT,
    PELVIS_DROP,
    SHIFT_X,
    SHIFT_Z,
    UNLOCK_DISTANCE,
)
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline
from live.motion.retarget.retarget import retarget
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE
from tests.fixtures.mocap import mocap_motion
from tests.places import ROOT

STEPS = ROOT / "patches" / "steps"
ANKLES, TOES = ([SKELETON.index(side + joint) for side in ("left", "right")] for joint in ("Foot", "Toes"))


@pytest.fixture(scope="module")
def walk():
    """A sketched walk with a sideways drift of 0.3 m/s: its feet slide."""
    clip = next(step.clip for step in load_folder(STEPS) if step.step == "walk" and step.direction == "long forward")
    root = clip.root_position.copy()
    root[:, 0] += 0.3 * np.arange(clip.sample_count, dtype=np.float32) / clip.sample_rate
    return Clip(clip.name, root, clip.rotation.copy(), clip.sample_rate, clip.contact.copy())


def slide(clip, contact):
    """Speeds [m/s] of the support feet: the slower of ankle and toes, while `contact` is set for the foot."""
    positions, _ = forward_kinematics(clip.root_position.astype(float), clip.rotation.astype(float))
    speeds = []
    for foot in range(2):
        on = contact[1:, foot] & contact[:-1, foot]
        moved = [np.diff(positions[:, joints[foot]][:, (0, 2)], axis=0) for joints in (ANKLES, TOES)]
        speed = np.min([np.linalg.norm(m, axis=1) for m in moved], axis=0) * clip.sample_rate
        speeds.append(speed[on])
    return np.concatenate(speeds)


def test_dragged_walk_stops_sliding(walk):
    assert slide(walk, walk.contact).mean() > 0.2
    locked = lock_feet(walk)
    assert slide(locked, walk.contact).mean() < 0.02
    sunk = walk.root_position[:, 1] - locked.root_position[:, 1]
    assert sunk.min() > -1e-5
    assert sunk.max() <= PELVIS_DROP + 1e-5
    assert locked.root_position[:, (0, 2)] == pytest.approx(walk.root_position[:, (0, 2)], abs=1e-6)


def test_feet_and_upper_body_keep_rotations(walk):
    locked = lock_feet(walk)
    assert np.linalg.norm(locked.rotation, axis=-1) == pytest.approx(1.0, abs=1e-5)
    upper = [j for j in range(1, SKELETON.joint_count) if j not in LEG_JOINTS]
    same = np.abs((locked.rotation[:, upper] * walk.rotation[:, upper]).sum(-1))
    assert same == pytest.approx(1.0, abs=1e-5)
    before, after = (forward_kinematics(c.root_position, c.rotation)[1] for c in (walk, locked))
    feet = [*ANKLES, *TOES]  # they keep their rotation in the world
    assert np.abs((before[:, feet] * after[:, feet]).sum(-1)) == pytest.approx(1.0, abs=1e-4)


def test_joint_accelerations_stay_bounded(walk):
    """The largest acceleration of any joint grows by little: a foot is released with its current speed."""
    accelerations = []
    for clip in (walk, lock_feet(walk)):
        positions, _ = forward_kinematics(clip.root_position.astype(float), clip.rotation.astype(float))
        acceleration = np.linalg.norm(np.diff(positions, n=2, axis=0), axis=-1) * clip.sample_rate**2
        accelerations.append(acceleration.max())
    assert accelerations[1] < accelerations[0] + 60.0


def test_clip_without_sliding_stays_unchanged():
    clip = next(step.clip for step in load_folder(STEPS) if step.step == "walk" and step.direction == "long forward")
    before, after = (forward_kinematics(c.root_position, c.rotation)[0] for c in (clip, lock_feet(clip)))
    assert np.abs(before - after).max() < 0.01


def test_soles_stay_above_floor(walk):
    root = walk.root_position.copy()
    root[:, 1] -= 0.03
    locked = lock_feet(Clip("sunk", root, walk.rotation.copy(), walk.sample_rate, walk.contact.copy()))
    positions, _ = forward_kinematics(locked.root_position.astype(float), locked.rotation.astype(float))
    heel, ball = positions[:, ANKLES, 1] - SOLE_BELOW_ANKLE, positions[:, TOES, 1] - TOES_OVER_SOLE
    assert min(heel.min(), ball.min()) > -1e-3


def standing_pipeline(count=1):
    pipeline = PosePipeline(count)
    rotation = np.zeros((1, SKELETON.joint_count, 4), np.float32)
    rotation[..., 0] = 1.0
    return pipeline, ClipStore.of(SKELETON.offsets[:1], rotation)


def test_straight_leg_bends_forward():
    pipeline, store = standing_pipeline()
    pipeline.lock = True
    pipeline.feet[0, :, SHIFT_Z] = 0.0
    store.root[0, 1] -= 0.1  # both soles would be 10 cm in the floor
    position, _ = pipeline.run(store)
    knee, hip = (position[0, SKELETON.index(f"left{name}")] for name in ("LowerLeg", "UpperLeg"))
    assert knee[2] - hip[2] > 0.1
    assert position[0, SKELETON.index("leftFoot"), 1] == pytest.approx(SOLE_BELOW_ANKLE, abs=1e-4)


def test_foot_shift_is_limited():
    pipeline, store = standing_pipeline()
    pipeline.lock = True
    pipeline.feet[0, 0, SHIFT_X] = 5.0
    position, _ = pipeline.run(store)
    moved = position[0, SKELETON.index("leftFoot"), 0] - SKELETON.rest_positions()[SKELETON.index("leftFoot"), 0]
    assert moved <= MAX_SHIFT + 1e-4


def test_lock_releases_beyond_limit_and_locks_again():
    lock, dt = FootLock(1), 1 / 64
    contact = np.ones((1, 2), np.bool_)
    place = np.ascontiguousarray(SKELETON.rest_positions()[None, LEG_JOINTS], np.float32)
    lock.tick(place, contact, dt)
    for _ in range(64):
        place[..., 0] += 0.6 * dt
        lock.tick(place, contact, dt)
        assert np.abs(lock.state[0, :, SHIFT_X]).max() < UNLOCK_DISTANCE + 0.01
    held = []
    for _ in range(64):
        lock.tick(place, contact, dt)
        held.append(lock.state[0, 0, HELD])
    assert held[-1] == 1.0
    assert abs(lock.state[0, 0, SHIFT_X]) < UNLOCK_DISTANCE


def test_clip_jump_moves_foot_at_once():
    lock = FootLock(1)
    place = np.ascontiguousarray(SKELETON.rest_positions()[None, LEG_JOINTS], np.float32)
    contact = np.ones((1, 2), np.bool_)
    for _ in range(5):
        lock.tick(place, contact, 1 / 64)
    place[..., 2] += 3.0
    lock.tick(place, contact, 1 / 64)
    assert np.abs(lock.state[0, :, SHIFT_Z]).max() < 0.01


@pytest.mark.shared
@pytest.mark.parametrize(
    ("name", "fps", "drop"),
    [("walk/cmu_12_01_walk.bvh", None, 1), ("salsa/60_01.bvh", 60.0, 6), ("salsa/61_01.bvh", 60.0, 6)],
)
def test_recorded_feet_stop_sliding(name, fps, drop):
    """The requirement: at most 0.02 m/s on average, hips moved by at most 2 cm."""
    clip = retarget(mocap_motion(name), name=name, fps=fps, drop_frames=drop)
    locked = lock_feet(clip)
    assert slide(clip, clip.contact).mean() > 0.1
    assert slide(locked, clip.contact).mean() <= 0.02
    assert np.abs(locked.root_position - clip.root_position).max() <= 0.0201
