"""Tests of foot lock kernels: hips sink and knees straighten smoothly; a foot within reach is placed exactly."""

import numpy as np
import pytest

from live.motion.pose.foot_lock import LEG_JOINTS, FootLock
from live.motion.pose.foot_lock_kernels import (
    CLEARANCE,
    CLEARANCE_SOFTNESS,
    FEET_COLUMNS,
    LENGTH_BUFFER,
    LIFT,
    PELVIS_DROP,
    SHIFT_Z,
    hip_drop,
)
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

HIP, KNEE, ANKLE, TOES = (SKELETON.index(name) for name in ("leftUpperLeg", "leftLowerLeg", "leftFoot", "leftToes"))
LEG = float(np.linalg.norm(SKELETON.offsets[KNEE]) + np.linalg.norm(SKELETON.offsets[ANKLE]))


def shifted_poses(shift, height=0.0, lift=None, clear=None):
    """Joints (T, J, 3) of a standing dancer with bent knees, the left foot requested `shift` (T,) [m] behind."""
    count = len(shift)
    rotation = np.zeros((1, SKELETON.joint_count, 4), np.float32)
    rotation[..., 0] = 1.0
    for side in ("left", "right"):  # knees bent by 0.7 rad, thighs forward by half of that
        for joint, angle in (("UpperLeg", -0.35), ("LowerLeg", 0.7), ("Foot", -0.35)):
            j = SKELETON.index(side + joint)
            rotation[0, j] = np.cos(angle / 2), np.sin(angle / 2), 0.0, 0.0
    plain = PosePipeline(1)
    root = np.array([[0.0, 1.0, 0.0]], np.float32)
    position, _ = plain.run(ClipStore.of(root, rotation))
    root[0, 1] += SOLE_BELOW_ANKLE - position[0, ANKLE, 1] + height
    pipeline = PosePipeline(count)
    pipeline.lock = True
    pipeline.feet[:, 0, SHIFT_Z] = -shift
    if lift is not None:
        pipeline.feet[:, 0, LIFT] = lift
    if clear is not None:
        pipeline.feet[:, 0, CLEARANCE], pipeline.feet[:, 0, CLEARANCE_SOFTNESS] = clear, 0.3 * clear
    return pipeline.run(ClipStore.of(root, rotation))[0].astype(float), root


def test_hips_sink_smoothly_within_limit():
    """Of a foot that stays behind, and not at all as long as its leg reaches."""
    shift = np.linspace(0.1, 0.34, 481).astype(np.float32)
    drop = np.array([hip_drop(LEG, flat, 0.75, 0.76, PELVIS_DROP) for flat in shift])
    assert drop[0] == pytest.approx(0.0, abs=1e-6)
    assert (np.diff(drop) > -1e-6).all()
    assert PELVIS_DROP / 4 < drop[-1] < PELVIS_DROP
    slope = np.diff(drop[::4]) / np.diff(shift[::4])
    assert np.abs(np.diff(slope)).max() < 0.25 * slope.max()  # it neither begins nor stops at once


def test_foot_within_reach_is_placed_exactly():
    position, _ = shifted_poses(np.linspace(0.0, 0.24, 241))
    asked = position[0, ANKLE, 2] - np.linspace(0.0, 0.24, 241)
    length = np.linalg.norm(position[:, ANKLE] - position[:, HIP], axis=1)
    easy = length < LEG - LENGTH_BUFFER - 0.03 - 1e-4
    assert easy.sum() > 20
    assert position[easy, ANKLE, 2] == pytest.approx(asked[easy], abs=1e-4)
    assert (length <= LEG - LENGTH_BUFFER + 1e-4).all()
    assert np.abs(position[:, ANKLE, 2] - asked).max() < 0.05


def test_knee_straightens_smoothly():
    """With the foot pulled back evenly, the knee moves at most three times as fast as requested for the foot."""
    shift = np.linspace(0.0, 0.24, 241)
    position, _ = shifted_poses(shift)
    knee = np.linalg.norm(np.diff(position[:, KNEE], axis=0), axis=1) / np.diff(shift)
    assert knee.max() < 3.0
    assert np.abs(np.diff(knee)).max() < 0.25


def test_foot_lift_fades_after_release():
    """A clip's foot 2 cm below the floor is put on it; after release it returns to the clip's height without a step."""
    lock, dt = FootLock(1), 1.0 / 60.0
    position, _ = shifted_poses(np.zeros(1))
    legs = np.ascontiguousarray(position[:, LEG_JOINTS], np.float32)
    heights = []
    for tick in range(60):
        low = -0.02 if tick < 30 else -0.02 + 0.6 * dt * (tick - 29)  # from then on the clip's foot rises
        moved = legs.copy()
        moved[0, 3:5, 1] += low
        lock.tick(moved, np.array([[tick < 30, True]]), dt)
        lift = float(lock.state[0, 0, LIFT])
        heights.append(low + max(lift, -low, 0.0) if tick >= 30 else low + max(-low, 0.0))
    change = np.abs(np.diff(heights, n=2)).max() * 60.0
    assert change < 0.65  # it takes up the clip's 0.6 m/s; a foot that waited for the clip would jump by more later
    assert heights[-1] == pytest.approx(-0.02 + 0.6 * dt * 30, abs=2e-3)
    assert min(heights) > -1e-6
    assert lock.state.shape[2] > FEET_COLUMNS


def test_foot_clearance_is_kept_smoothly():
    """As high as requested or slightly higher, from any height; a foot that is high enough hardly moves."""
    clear = np.linspace(0.0, 0.06, 121)
    for height in (0.0, -0.02, 0.05, 0.2):
        position, _ = shifted_poses(np.zeros(121), height=height, clear=clear)
        sole = position[:, ANKLE, 1] - SOLE_BELOW_ANKLE
        assert (sole > np.maximum(clear, height) - 1e-4).all()
        assert (sole < np.maximum(clear, height) + 0.15 * clear + 1e-4).all()
        assert np.abs(np.diff(sole, n=2)).max() < 1e-3
        assert sole[0] == pytest.approx(max(height, 0.0), abs=1e-4)
