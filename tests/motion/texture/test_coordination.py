"""Coordination of arms and steps against known phases."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.motion.texture.coordination import coordination_of, correlation, coupling


def walker(lag: float, seconds: float = 16.0) -> Clip:
    """Legs and arms that swing once a second; arms against the legs of their side, `lag` radians late."""
    t = np.arange(int(seconds * 60.0) + 1) / 60.0
    vector = np.zeros((len(t), JOINT_COUNT, 3))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        vector[:, SKELETON.index(side + "UpperLeg"), 0] = 0.3 * sign * np.sin(2.0 * np.pi * t)
        vector[:, SKELETON.index(side + "UpperArm"), 2] = -1.4 * sign
        vector[:, SKELETON.index(side + "Shoulder"), 1] = -0.3 * np.sin(2.0 * np.pi * t - lag)
    rotation = quaternion.from_rotation_vector(vector).astype(np.float32)
    return Clip("walker", np.zeros((len(t), 3), np.float32), rotation, 60.0, np.zeros((len(t), 2), np.bool_))


def test_lag_of_arms_is_the_change_of_phase() -> None:
    first, late = (coordination_of(walker(lag), 4) for lag in (0.0, 0.7))
    assert abs(first.steps) > 0.95
    assert abs(first.arms) > 0.95
    turned = np.angle(late.steps / first.steps)
    assert turned == pytest.approx(-0.7, abs=0.06)
    assert late.arms == pytest.approx(first.arms, abs=0.05)
    assert first.distance(late) == pytest.approx(0.5 * 2.0 * np.sin(0.35), abs=0.05)
    assert first.distance(first) == 0.0


def test_still_limbs_have_no_coupling() -> None:
    assert coupling(np.zeros(10, np.complex128), np.ones(10, np.complex128)) == 0.0
    assert correlation(np.zeros((5, 2)), np.ones((5, 2))) == 0.0
    moving = walker(0.0, 2.0)
    still = replace(moving, rotation=np.broadcast_to(moving.rotation[:1], moving.rotation.shape).copy())
    assert coordination_of(still, 4).report()["arms_steps"] == {"strength": 0.0, "phase_deg": 0.0}
