"""Tests of two-bone inverse kinematics: properties for any target, pole and pair of lengths."""

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from live.motion import quaternion
from live.motion.pose.two_bone_ik import SOFTNESS, bone_rotation, hinge_axis, two_bone

Float = npt.NDArray[np.float64]

coordinate = st.integers(-20000, 20000).map(lambda tenth: tenth / 10000)
point = st.tuples(coordinate, coordinate, coordinate).map(np.array)
length = st.floats(0.05, 0.6)


def bone_lengths(root: Float, middle: Float, end: Float) -> tuple[float, float]:
    return float(np.linalg.norm(middle - root)), float(np.linalg.norm(end - middle))


@given(point, point, point, length, length)
def test_bone_lengths_are_constant_for_any_target(
    root: Float, target: Float, pole: Float, upper: float, lower: float
) -> None:
    middle, end = two_bone(root, target, pole, upper=upper, lower=lower)
    assert np.allclose(bone_lengths(root, middle, end), (upper, lower), atol=1e-6)
    assert np.linalg.norm(end - root) <= (upper + lower) * (1.0 + 1e-9)


@given(point, point, point, length, length, st.floats(0.0, 1.0))
def test_target_within_reach_is_reached_exactly(
    root: Float, direction: Float, pole: Float, upper: float, lower: float, share: float
) -> None:
    assume(np.linalg.norm(direction) > 0.01)
    nearest, farthest = abs(upper - lower) + 2e-4, (1.0 - SOFTNESS) * (upper + lower)
    distance = nearest + share * (farthest - nearest)
    target = root + distance * direction / np.linalg.norm(direction)
    _, end = two_bone(root, target, pole, upper=upper, lower=lower)
    assert np.allclose(end, target, atol=1e-9)


@given(point, point, length, length)
def test_middle_joint_bends_toward_pole(target: Float, pole: Float, upper: float, lower: float) -> None:
    assume(np.linalg.norm(np.cross(target, pole)) > 0.05 * np.linalg.norm(target) * np.linalg.norm(pole) > 0.0)
    middle, end = two_bone(np.zeros(3), target, pole, upper=upper, lower=lower)
    aside = middle - end * (middle @ end) / max(end @ end, 1e-12)
    assert aside @ pole >= -1e-9


def test_limb_stretches_smoothly_within_its_length() -> None:
    distances = np.linspace(0.7, 1.4, 400)
    targets = distances[:, None] * (0.0, -1.0, 0.0)
    middle, end = two_bone(np.zeros(3), targets, np.array((0.0, 0.0, 1.0)), upper=0.5, lower=0.5)
    reached = np.linalg.norm(end, axis=1)
    speed = np.diff(reached) / np.diff(distances)
    assert (reached <= 1.0).all()
    assert (reached[distances < 1.05] < 1.0).all()
    assert (speed >= 0.0).all()
    assert np.abs(np.diff(speed)).max() < 0.16, "the knee snaps"
    assert (middle[:, 2] >= 0.0).all(), "the knee gives way backwards"


def test_degenerate_targets_and_poles_give_finite_results() -> None:
    root, up = np.zeros((2, 3)), np.array((0.0, 1.0, 0.0))
    for target, pole in ((root, up), (np.tile(up, (2, 1)), up), (root, np.zeros(3))):
        for part in two_bone(root, target, pole, upper=0.4, lower=0.4):
            assert np.isfinite(part).all()
        assert np.isfinite(hinge_axis(root, target, pole)).all()
        assert np.isfinite(bone_rotation(np.zeros((2, 3)) + up, up, np.array((1.0, 0.0, 0.0)), up)).all()


@pytest.mark.long
@given(point, point)
def test_bone_rotation_aligns_direction_and_hinge(direction: Float, hinge: Float) -> None:
    assume(np.linalg.norm(np.cross(direction, hinge)) > 1e-3)
    rotation = bone_rotation(direction, hinge, np.array((1.0, 0.0, 0.0)), np.array((0.0, 1.0, 0.0)))
    along = quaternion.unit(direction)
    normal = quaternion.unit(hinge - along * (hinge @ along))
    assert np.allclose(quaternion.rotate(rotation, np.array((1.0, 0.0, 0.0))), along, atol=1e-6)
    assert np.allclose(quaternion.rotate(rotation, np.array((0.0, 1.0, 0.0))), normal, atol=1e-6)


@given(point, point, length, length)
def test_bones_are_normal_to_hinge_and_bend_toward_pole(target: Float, pole: Float, upper: float, lower: float) -> None:
    assume(np.linalg.norm(np.cross(target, pole)) > 0.05 * np.linalg.norm(target) * np.linalg.norm(pole) > 0.0)
    middle, end = two_bone(np.zeros(3), target, pole, upper=upper, lower=lower)
    hinge = hinge_axis(np.zeros(3), target, pole)
    assert abs(hinge @ middle) < 1e-6
    assert abs(hinge @ (end - middle)) < 1e-6
    assert hinge @ np.cross(end, middle) >= -1e-9


def test_bone_swinging_through_pole_rotates_continuously() -> None:
    """The upper arm passes the direction of the elbow's pole: its own rotation must stay continuous."""
    angles = np.linspace(-0.4, 0.4, 81)
    pole = np.array((1.0, 0.0, 0.0))
    target = 0.45 * np.stack((np.cos(angles), np.sin(angles) - 0.6, 0.0 * angles), axis=1)
    middle, _ = two_bone(np.zeros(3), target, pole, upper=0.3, lower=0.25)
    assert (middle[:, 1] > 0.0).any(), "the bone never passes the pole"
    assert (middle[:, 1] < 0.0).any(), "the bone never passes the pole"
    hinge = hinge_axis(np.zeros(3), target, pole)
    rotation = bone_rotation(middle, hinge, np.array((1.0, 0.0, 0.0)), np.array((0.0, 0.0, 1.0)))
    assert np.abs((rotation[1:] * rotation[:-1]).sum(axis=1)).min() > 0.99
