"""Tests of contacts of bodies: against the drawn body, brute force over points, and what is no contact."""

import numpy as np
import pytest
from scipy.optimize import minimize

from live.motion.forward_kinematics import forward_kinematics
from live.motion.pose.body_capsules import ARM_CHAINS, TRUNK_HALF_DEPTH, TRUNK_HALF_WIDTH
from live.motion.pose.hand_hold import HeldArms
from live.motion.quality.body_contact import (
    ContactRecorder,
    arm_distances,
    neighbour_contacts,
    segment_distances,
    self_contacts,
    trunk_scale,
)
from live.motion.quaternion import from_axis_angle, rotate
from live.motion.skeleton import JOINT_COUNT, MIRROR, SKELETON
from live.render.body.body_parts import TORSO
from live.render.body.implicit_surface import Shape

REST = SKELETON.rest_positions().astype(np.float64)
LEFT_ELBOW, LEFT_WRIST = ARM_CHAINS[0, 1], ARM_CHAINS[0, 2]


def random_poses(count, seed=0):
    """Joints of upright dancers with elbows and wrists about the trunk, whatever the bones, (count, J, 3) [m]."""
    chance = np.random.default_rng(seed)
    axis = chance.normal(size=(count, JOINT_COUNT, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    poses = forward_kinematics(np.tile(REST[0], (count, 1)), from_axis_angle(axis, np.full(axis.shape[:2], 0.15)))[0]
    poses[:, ARM_CHAINS[:, 1:].ravel()] = np.array([0.0, 1.15, 0.0]) + chance.normal(0.0, 0.22, (count, 4, 3))
    return poses


def test_the_trunk_is_that_of_the_drawn_body_within_three_centimetres():
    """Points around the capsule between hips and shoulders, against the torso that is drawn."""
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ring = np.stack([TRUNK_HALF_WIDTH * np.sin(angle), 0.0 * angle, TRUNK_HALF_DEPTH * np.cos(angle)], axis=1)
    points = np.concatenate([ring + np.array([0.0, y, -0.003]) for y in np.linspace(0.94, 1.33, 10)])
    assert np.abs(Shape((TORSO,)).distance(points)).max() < 0.03
    assert np.abs(Shape((TORSO,)).distance(points)).mean() < 0.01
    assert trunk_scale(REST, points) == pytest.approx(1.0, abs=0.06)


def test_a_forearm_is_inside_where_a_point_of_it_is():
    """Upright trunk: against a plain ellipse, at 400 points of the forearm."""
    poses = random_poses(300)
    poses[:, :6] = REST[:6]
    straight = [SKELETON.index(side + joint) for side in ("left", "right") for joint in ("UpperLeg", "Shoulder")]
    poses[:, straight] = REST[straight]
    poses[:, 2] = REST[0] + (REST[4] - REST[0]) * (REST[2, 1] - REST[0, 1]) / (REST[4, 1] - REST[0, 1])  # not bent
    found = self_contacts(poses)
    low, high = REST[0], REST[0] + 0.85 * (REST[4] - REST[0])
    inside = np.zeros(len(poses), np.bool_)
    close = np.zeros(len(poses), np.bool_)
    for elbow, wrist in ARM_CHAINS[:, 1:]:
        points = poses[:, elbow, None] + np.linspace(0, 1, 400)[:, None] * (poses[:, wrist] - poses[:, elbow])[:, None]
        along = np.clip((points[..., 1] - low[1]) / (high[1] - low[1]), 0.0, 1.0)
        off = points - low - along[..., None] * (high - low)
        scale = (
            (off[..., 0] / TRUNK_HALF_WIDTH) ** 2 + (off[..., 2] / TRUNK_HALF_DEPTH) ** 2 + (off[..., 1] / 0.09) ** 2
        )
        inside |= (scale < 1.0).any(axis=1)
        close |= np.abs(scale.min(axis=1) - 1.0) < 0.1
    assert 30 < inside.sum() < 270
    np.testing.assert_array_equal(found[~close], inside[~close])


def test_contact_does_not_depend_on_place_turn_or_side():
    poses = random_poses(200, seed=1)
    found = self_contacts(poses)
    turned = rotate(from_axis_angle(np.array([0.3, 0.9, 0.1]), np.array(2.0)), poses) + np.array([3.0, 0.5, -1.0])
    np.testing.assert_array_equal(self_contacts(turned), found)
    np.testing.assert_array_equal(self_contacts(poses[:, MIRROR] * [-1.0, 1.0, 1.0]), found)


def test_a_hand_at_the_own_hip_is_no_contact():
    """Akimbo: the palm lies on the hip, so the wrist is a forearm's radius off the surface."""
    pose = REST.copy()
    pose[LEFT_ELBOW], pose[LEFT_WRIST] = (0.34, 1.19, -0.08), (TRUNK_HALF_WIDTH + 0.03, 1.02, 0.0)
    assert not self_contacts(pose)
    pose[LEFT_WRIST] = (TRUNK_HALF_WIDTH - 0.03, 1.02, 0.0)
    assert self_contacts(pose)


@pytest.mark.long
def test_segment_distance_is_the_least_over_all_points():
    chance = np.random.default_rng(2)
    a, b, c, d = chance.normal(size=(4, 40, 3))
    b[:5] = a[:5] + (d - c)[:5]  # parallel ones
    found = segment_distances(a, b, c, d)
    for n in range(len(a)):

        def distance(at, n=n):
            return np.linalg.norm(a[n] + at[0] * (b - a)[n] - c[n] - at[1] * (d - c)[n])

        starts = [(x, y) for x in (0.1, 0.9) for y in (0.1, 0.9)]
        best = min(minimize(distance, start, bounds=[(0, 1), (0, 1)]).fun for start in starts)
        assert found[n] == pytest.approx(best, abs=2e-3)


def couple(distance, turn=0.0):
    """Two dancers in the rest pose beside each other, arms out to their sides."""
    return np.stack([REST, REST + np.array([distance, 0.0, turn])])


def test_arms_touch_from_six_centimetres_on():
    reach = REST[LEFT_WRIST, 0]
    assert not any(neighbour_contacts(couple(2.0 * reach + 0.065)))
    assert neighbour_contacts(couple(2.0 * reach + 0.055)) == (True, False)
    assert arm_distances(couple(2.0 * reach + 0.055), np.array([0]), np.array([1]))[0, 0, 1] == pytest.approx(0.055)


def test_a_hand_touches_a_trunk_from_twelve_centimetres_on():
    wrist = REST[LEFT_WRIST]
    for off, touches in ((0.125, False), (0.115, True)):
        pair = couple(wrist[0] + off)
        pair[1, ARM_CHAINS] += [0.0, 1.0, 2.0]  # the other's arms are elsewhere
        pair[0, :, 1] -= wrist[1] - 1.2
        assert neighbour_contacts(pair) == (False, touches)


def test_joined_arms_of_a_couple_do_not_count():
    pair = couple(2.0 * REST[LEFT_WRIST, 0])
    held = HeldArms(2)
    held.add_holds(np.array([[0, 1]], np.int32), np.array([[0, 1]], np.int32), np.array([0.4], np.float32))
    assert neighbour_contacts(pair) == (True, False)
    assert neighbour_contacts(pair, held) == (False, False)
    third = np.concatenate([pair, pair[1:] + np.array([0.0, 0.0, 0.03])])
    assert neighbour_contacts(third, HeldArms(3)) == (True, False)
    held = HeldArms(3)
    held.add_holds(np.array([[0, 1]], np.int32), np.array([[0, 1]], np.int32), np.array([0.4], np.float32))
    assert neighbour_contacts(third, held) == (True, False)  # the third dancer's arm is at the held ones


def test_recorder_counts_visible_dancers():
    apart, together = couple(3.0), couple(2.0 * REST[LEFT_WRIST, 0])
    recorder = ContactRecorder()
    assert recorder.ratios() == dict.fromkeys(("self_contact_ratio", "neighbour_contact_ratio", "hand_contact_ratio"))
    for _ in range(3):
        recorder.add(apart)
    recorder.add(together)
    recorder.add(together, visible=np.array([True, False]))
    inside = apart.copy()
    inside[0, LEFT_ELBOW] = (0.0, 1.2, 0.0)
    recorder.add(inside)
    ratios = recorder.ratios()
    assert ratios["neighbour_contact_ratio"] == pytest.approx(1 / 6)
    assert ratios["self_contact_ratio"] == pytest.approx(1 / 11)
    assert ratios["hand_contact_ratio"] == 0.0
