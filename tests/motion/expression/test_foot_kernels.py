"""Tests of drawn feet: standing ones keep every bit, others point and flex, and toes stay on the floor."""

import math

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.expression.foot_kernels import FLEXED, MOST_BEND, POINTED, point_feet
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import BONE_TIPS, SKELETON

KNEE, ANKLE, TOES = (SKELETON.index(f"left{name}") for name in ("LowerLeg", "Foot", "Toes"))
RIGHT_ANKLE, RIGHT_TOES = SKELETON.index("rightFoot"), SKELETON.index("rightToes")
X = np.array([1.0, 0.0, 0.0])


def standing(lift=0.0, foot=0.0, toes=0.0, turned=0.0):
    """A figure in the rest pose, `lift` [m] higher, left foot and toes pitched down [rad], the whole `turned`."""
    root, rotation = SKELETON.offsets[None, 0].astype(np.float64).copy(), np.zeros((1, SKELETON.joint_count, 4))
    root[:, 1] += lift
    rotation[..., 0] = 1.0
    rotation[:, 0] = quaternion.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(turned))
    rotation[:, ANKLE], rotation[:, TOES] = (quaternion.from_axis_angle(X, np.array(a)) for a in (foot, toes))
    position, world = forward_kinematics(root, rotation)
    return np.ascontiguousarray(position, np.float32), np.ascontiguousarray(world, np.float32)


def pointed(pose, point):
    position, rotation = (array.copy() for array in pose)
    point_feet(position, rotation, np.ones(1, np.bool_), np.array([float(point)]), 0, 1)
    return position, rotation


def flexion(pose):
    """Angle between foot and shin beyond a right one [rad], and bend of the toes downwards."""
    position, rotation = (array[0].astype(np.float64) for array in pose)
    shin = position[ANKLE] - position[KNEE]
    ahead = quaternion.rotate(rotation[ANKLE], np.array([0.0, 0.0, 1.0]))
    bent = quaternion.mul(quaternion.inverse(rotation[ANKLE]), rotation[TOES])
    return math.asin(shin @ ahead / np.linalg.norm(shin)), 2.0 * math.atan2(bent[1], bent[0])


def tip_height(pose):
    position, rotation = (array[0].astype(np.float64) for array in pose)
    return position[TOES, 1] + quaternion.rotate(rotation[TOES], np.array(BONE_TIPS[TOES]))[1]


@pytest.mark.parametrize("point", [-1.0, 0.0, 0.35, 1.0])
def test_foot_on_the_floor_keeps_every_bit(point):
    before = standing(turned=0.7)
    after = pointed(before, point)
    assert before[0].tobytes() == after[0].tobytes()
    assert before[1].tobytes() == after[1].tobytes()


def test_nothing_is_pointed_where_nobody_asks():
    before = standing(lift=0.5, toes=0.2)
    after = pointed(before, 0.0)
    assert before[1].tobytes() == after[1].tobytes()


@pytest.mark.parametrize("turned", [0.0, 2.0])
def test_feet_high_in_the_air_are_pointed_and_flexed_wholly(turned):
    for point, wanted, toes in ((1.0, POINTED, math.radians(22.0)), (-1.0, FLEXED, math.radians(-18.0))):
        after = pointed(standing(lift=0.5, foot=0.1, turned=turned), point)
        flexed, bent = flexion(after)
        assert flexed == pytest.approx(wanted, abs=2e-3)
        assert bent == pytest.approx(toes, abs=2e-3)


def test_foot_that_is_pointed_more_already_stays_so():
    before = standing(lift=0.5, foot=1.25)
    assert flexion(pointed(before, 1.0))[0] == pytest.approx(1.25, abs=1e-3)


def test_other_joints_stay_and_bones_keep_their_lengths():
    before = standing(lift=0.4, turned=0.4)
    after = pointed(before, 1.0)
    kept = [joint for joint in range(SKELETON.joint_count) if joint not in (ANKLE, TOES, RIGHT_ANKLE, RIGHT_TOES)]
    assert np.array_equal(before[0][:, kept], after[0][:, kept])
    assert np.array_equal(before[1][:, kept], after[1][:, kept])
    assert np.array_equal(before[0][:, ANKLE], after[0][:, ANKLE])
    length = np.linalg.norm(after[0][0, TOES] - after[0][0, ANKLE])
    assert length == pytest.approx(float(np.linalg.norm(SKELETON.offsets[TOES])), abs=1e-5)
    assert np.linalg.norm(after[1], axis=-1) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("lift", np.linspace(0.0, 0.4, 21).tolist())
@pytest.mark.parametrize("foot", [0.0, 0.3])
def test_tips_never_go_into_the_floor(lift, foot):
    before = standing(lift=lift + 0.2 * math.sin(foot), foot=foot)
    assert tip_height(pointed(before, 1.0)) > min(tip_height(before), 0.0) - 1e-4


@pytest.mark.long
def test_feet_leave_the_floor_softly():
    """From the floor up no angle jumps: less than three degrees for each millimetre."""
    angles = np.array([flexion(pointed(standing(lift=lift), 1.0)) for lift in np.arange(0.0, 0.3, 0.001)])
    assert np.abs(np.diff(angles, axis=0)).max() < math.radians(3.0)


def test_toes_lie_on_the_floor_while_the_heel_rises():
    for foot in np.radians([10.0, 30.0, 50.0, 65.0]).tolist():
        raised = 0.065 * (math.cos(foot) - 1.0) + 0.130 * math.sin(foot)  # the toe joint stays where it was
        pose = standing(lift=raised, foot=foot)
        assert pose[0][0, TOES, 1] == pytest.approx(0.02, abs=1e-4)
        after = pointed(pose, 0.0)
        assert np.array_equal(pose[0], after[0])
        assert np.array_equal(pose[1][:, ANKLE], after[1][:, ANKLE])
        ahead = quaternion.rotate(after[1][0, TOES].astype(np.float64), np.array([0.0, 0.0, 1.0]))
        assert abs(math.asin(ahead[1])) < math.radians(2.0) if foot > 0.3 else True
        assert -flexion(after)[1] <= MOST_BEND + 1e-4
        assert tip_height(after) > tip_height(pose) - 1e-6


def test_absent_dancers_are_left_alone():
    position, rotation = standing(lift=0.5)
    before = rotation.copy()
    point_feet(position, rotation, np.zeros(1, np.bool_), np.ones(1), 0, 1)
    assert before.tobytes() == rotation.tobytes()
