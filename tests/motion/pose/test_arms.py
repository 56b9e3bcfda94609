"""Tests of hand holds: palms meet within reach, bone lengths are kept, motion is smooth, other joints stay."""

import numpy as np
import pytest

from live.motion.forward_kinematics import forward_kinematics
from live.motion.pose.hand_hold import ARM_JOINTS, LEFT, NOBODY, RIGHT, HandHolds
from live.motion.pose.hand_hold_kernels import FADE_RANGE, LENGTH_BUFFER, PALM, join_hands
from live.motion.quaternion import from_axis_angle, inverse, mul, rotate
from live.motion.skeleton import JOINT_COUNT, SKELETON

TICK = 1.0 / 64.0
BPM = 120.0
REACH = 0.265 + 0.245 + float(PALM) - float(LENGTH_BUFFER)


def palms(position, rotation, hand):
    """Palm center of the given hand of poses (A, J, ...)."""
    j = int(ARM_JOINTS[2 + 3 * hand])
    sign = 1.0 if hand == LEFT else -1.0
    return position[:, j] + rotate(rotation[:, j].astype(float), np.array([sign * float(PALM), 0.0, 0.0]))


def facing(distance, t=0.0, seed=1):
    """Two dancers facing each other at a distance [m], with random joint rotations, swaying with time t [s]."""
    rng = np.random.default_rng(seed)
    axis, angle = rng.normal(size=(2, JOINT_COUNT, 3)), rng.uniform(0.0, 0.35, (2, JOINT_COUNT))
    rate = rng.uniform(1.0, 4.0, (2, JOINT_COUNT))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    local = from_axis_angle(axis, angle * np.sin(rate * t + 1.0))
    for side, sign in (("left", 1.0), ("right", -1.0)):  # arms hang
        j = SKELETON.index(side + "UpperArm")
        local[:, j] = mul(from_axis_angle(np.array([0.0, 0.0, 1.0]), -sign * 1.3), local[:, j])
        bend = 0.6 + 0.4 * np.sin(rate[:, 0] * t)  # forearms bend as elbows do
        local[:, j + 1] = from_axis_angle(np.array([0.0, 1.0, 0.0]), -sign * bend)
    local[:, 0] = from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array([0.0, np.pi]))
    root = np.array([[0.0, 0.935, -0.5 * distance], [0.0, 0.935, 0.5 * distance]])
    position, rotation = forward_kinematics(root, local)
    return position.astype(np.float32), rotation.astype(np.float32)


BOTH = np.array([[0, 1], [0, 1]], np.int32), np.array([[LEFT, RIGHT], [RIGHT, LEFT]], np.int32)


def joined_poses(position, rotation, share=1.0):
    """The same poses with both hands joined."""
    position, rotation = position.copy(), rotation.copy()
    join_hands(position, rotation, *BOTH, np.full(2, share, np.float32), ARM_JOINTS)
    return position, rotation


@pytest.mark.parametrize("distance", [0.6, 0.75, 0.9])
@pytest.mark.parametrize("seed", range(6))
def test_hands_meet_within_reach_and_bone_lengths_stay(distance, seed):
    before = facing(distance, seed=seed)
    position, rotation = joined_poses(*before)
    shoulders = np.linalg.norm(before[0][0, ARM_JOINTS[[0, 3]]] - before[0][1, ARM_JOINTS[[3, 0]]], axis=-1)
    for hand in (LEFT, RIGHT):
        one, other = palms(position, rotation, hand)[0], palms(position, rotation, 1 - hand)[1]
        if shoulders[hand] < 2.0 * REACH * (1.0 - float(FADE_RANGE)) - 0.1:
            assert np.linalg.norm(one - other) < 0.01
    assert np.linalg.norm(rotation, axis=-1) == pytest.approx(1.0, abs=1e-5)
    bones = SKELETON.parents[1:]
    for joint, parent in enumerate(bones, 1):  # every bone is where its parent's rotation puts it
        at = position[:, parent] + rotate(rotation[:, parent].astype(float), SKELETON.offsets[joint].astype(float))
        assert position[:, joint] == pytest.approx(at, abs=2e-5)
    for hand in (LEFT, RIGHT):  # wrists keep their rotation
        lower, wrist = ARM_JOINTS[1 + 3 * hand], ARM_JOINTS[2 + 3 * hand]
        was, now = (mul(inverse(r[:, lower].astype(float)), r[:, wrist].astype(float)) for r in (before[1], rotation))
        assert np.abs((was * now).sum(-1)) == pytest.approx(1.0, abs=1e-5)
    others = [j for j in range(JOINT_COUNT) if j not in ARM_JOINTS[:6]]
    assert (rotation[:, others] == before[1][:, others]).all()


def test_elbow_keeps_hinge_axis():
    """Joining swings the arm and bends the elbow about its own axis: no twist between upper arm and forearm."""
    before = facing(0.75, seed=3)
    rotation = joined_poses(*before)[1]
    for hand in (LEFT, RIGHT):
        upper, lower = ARM_JOINTS[3 * hand], ARM_JOINTS[3 * hand + 1]
        was, now = (mul(inverse(r[:, upper].astype(float)), r[:, lower].astype(float)) for r in (before[1], rotation))
        turn = mul(inverse(was), now)
        twist = 2.0 * np.arctan2(np.abs(turn[:, 1]), np.abs(turn[:, 0]))  # about the forearm's own axis, x
        assert np.degrees(twist).max() < 25.0


@pytest.mark.parametrize("distance", [1.35, 3.0])
def test_hands_out_of_reach_do_not_move(distance):
    before = facing(distance)
    for was, now in zip(before, joined_poses(*before), strict=True):
        assert (was == now).all()


def test_open_hold_leaves_pose_unchanged():
    before = facing(0.75)
    assert (joined_poses(*before, share=0.0)[0] == before[0]).all()
    assert joined_poses(*before, share=1e-4)[0] == pytest.approx(before[0], abs=1e-3)


def test_many_holds_match_single_holds():
    poses = [facing(0.7, seed=seed) for seed in range(40)]
    position, rotation = (np.concatenate([pose[k] for pose in poses]) for k in range(2))
    who = np.stack([2 * np.arange(40), 2 * np.arange(40) + 1], 1).astype(np.int32)
    hand = np.tile(np.array([[LEFT, RIGHT]], np.int32), (40, 1))
    join_hands(position, rotation, who, hand, np.ones(40, np.float32), ARM_JOINTS)
    for n, (p, r) in enumerate(poses):
        alone = p.copy(), r.copy()
        join_hands(*alone, who[:1], hand[:1], np.ones(1, np.float32), ARM_JOINTS)
        assert (position[2 * n : 2 * n + 2] == alone[0]).all()


def _requested_holds(*, hold):
    other = np.full((2, 2), NOBODY, np.int32)
    hand = np.zeros((2, 2, 2), np.int32)
    if hold:
        other[0] = 1
        hand[0] = [[LEFT, RIGHT], [RIGHT, LEFT]]
    return other, hand


@pytest.mark.long
def test_holds_close_and_open_smoothly_within_beat():
    """Two dancers sway while holds close and open: no joint jumps, and each change ends within a beat."""
    hands, positions, closed = HandHolds(2), [], []
    for tick in range(256):
        hands.tick(*_requested_holds(hold=40 <= tick < 160), TICK, BPM)
        position, rotation = facing(0.75, tick * TICK)
        free = position.copy()
        hands.apply(position, rotation, 0.0)
        positions.append(position)
        closed.append(np.abs(position - free).max())
    assert max(closed[:41]) == 0.0
    assert min(closed[100:160]) > 0.05
    assert max(closed[160 + 32 :]) == 0.0  # a beat
    path = np.array(positions)
    speed = np.linalg.norm(np.diff(path, axis=0), axis=-1) / TICK
    assert speed.max() < 5.0
    kink = np.linalg.norm(np.diff(path, n=2, axis=0), axis=-1) / TICK  # change of velocity from tick to tick
    assert kink.max() < 1.0


def test_hand_releases_before_changing_partner():
    hands = HandHolds(3)
    first = np.full((3, 2), NOBODY, np.int32), np.zeros((3, 2, 2), np.int32)
    then = first[0].copy(), first[1]
    first[0][0, 0], then[0][1, 0] = 2, 2
    for _ in range(64):
        hands.tick(*first, TICK, BPM)
    assert hands.state[0, 0, 0] > 0.95
    for _ in range(64):
        hands.tick(*then, TICK, BPM)
        assert not (hands.state[0, 0, 0] > 0.0 and hands.state[0, 1, 0] > 0.0)
    assert hands.state[0, 1, 0] > 0.9


def test_holds_advance_between_ticks():
    hands = HandHolds(2)
    for _ in range(8):
        hands.tick(*_requested_holds(hold=True), TICK, BPM)
    late, next_ = facing(0.75), facing(0.75)
    hands.apply(*late, TICK)
    hands.tick(*_requested_holds(hold=True), TICK, BPM)
    hands.apply(*next_, 0.0)
    assert late[0] == pytest.approx(next_[0], abs=0.01)
