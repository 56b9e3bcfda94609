"""Tests of reaching for a fixed palm: it is met within reach, arms keep their lengths, only the arms move."""

import numpy as np
import pytest

from live.motion.forward_kinematics import forward_kinematics
from live.motion.pose.hand_hold import ARM_JOINTS, LEFT, RIGHT
from live.motion.pose.hand_hold_kernels import LENGTH_BUFFER, STRAIGHTENING_RANGE, measure_reach, reach_palms
from live.motion.quaternion import from_axis_angle, inverse, mul, rotate
from live.motion.skeleton import JOINT_COUNT, SKELETON
from tests.motion.pose.test_arms import facing, palms

OTHERS = [j for j in range(JOINT_COUNT) if j not in ARM_JOINTS[:6]]
BOTH = np.array([[0, 1], [0, 1]], np.int32), np.array([[LEFT, RIGHT], [RIGHT, LEFT]], np.int32)


def reach(position, rotation, share=1.0, who=BOTH[0], hand=BOTH[1]):
    """The same poses with dancer 1 holding both hands of dancer 0."""
    position, rotation = position.copy(), rotation.copy()
    kept = np.zeros((len(who), 4), np.float32)
    reach_palms(position, rotation, who, hand, np.full(len(who), share, np.float32), kept, ARM_JOINTS)
    return position, rotation


def arm_length(position, rotation, hand):
    """Length [m] of dancer 1's arm from shoulder to palm, with the wrist as bent."""
    elbow = position[1, ARM_JOINTS[1 + 3 * hand]]
    upper = np.linalg.norm(elbow - position[1, ARM_JOINTS[3 * hand]])
    return float(upper + np.linalg.norm(palms(position, rotation, hand)[1] - elbow))


def palm_distance(position, rotation, hand):
    """Distance [m] from dancer 1's shoulder to the palm of dancer 0 that `hand` will hold."""
    shoulder = position[1, ARM_JOINTS[3 * hand]]
    return float(np.linalg.norm(palms(position, rotation, 1 - hand)[0] - shoulder))


def assert_rigid_bones(position, rotation):
    for joint, parent in enumerate(SKELETON.parents[1:], 1):
        at = position[:, parent] + rotate(rotation[:, parent].astype(float), SKELETON.offsets[joint].astype(float))
        assert position[:, joint] == pytest.approx(at, abs=2e-5)
    assert np.linalg.norm(rotation, axis=-1) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("distance", [0.35, 0.5, 0.6, 0.75])
@pytest.mark.parametrize("seed", range(8))
def test_palms_meet_and_only_follower_arms_move(distance, seed):
    before = facing(distance, seed=seed)
    position, rotation = reach(*before)
    for hand in (LEFT, RIGHT):
        gap = np.linalg.norm(palms(position, rotation, hand)[1] - palms(position, rotation, 1 - hand)[0])
        far, whole = palm_distance(*before, hand), arm_length(*before, hand)
        assert arm_length(position, rotation, hand) == pytest.approx(whole, abs=1e-5)
        if far < whole - float(LENGTH_BUFFER) - float(STRAIGHTENING_RANGE):
            assert gap < 1e-4
        elif far < whole:
            assert gap < 0.03
        else:
            assert gap < far - whole + 0.03  # straight towards it
    assert_rigid_bones(position, rotation)
    assert (position[0] == before[0][0]).all()
    assert (rotation[0] == before[1][0]).all()
    assert (rotation[1, OTHERS] == before[1][1, OTHERS]).all()
    assert (position[1, OTHERS] == before[0][1, OTHERS]).all()
    for hand in (LEFT, RIGHT):  # wrists keep their rotation
        lower, wrist = ARM_JOINTS[1 + 3 * hand], ARM_JOINTS[2 + 3 * hand]
        was, now = (mul(inverse(r[1, lower].astype(float)), r[1, wrist].astype(float)) for r in (before[1], rotation))
        assert abs((was * now).sum()) == pytest.approx(1.0, abs=1e-5)


def test_open_hold_leaves_pose_unchanged():
    before = facing(0.5)
    assert (reach(*before, share=0.0)[1] == before[1]).all()
    assert reach(*before, share=1e-4)[0] == pytest.approx(before[0], abs=1e-3)


def opposite_poses(angle):
    """Dancer 1, whose right arm is rotated by `angle` [rad], and dancer 0, whose left palm is in front of dancer 1."""
    local = np.tile(np.array((1.0, 0.0, 0.0, 0.0)), (2, JOINT_COUNT, 1))
    upper = SKELETON.index("rightUpperArm")
    local[1, upper] = from_axis_angle(np.array([0.0, 0.0, 1.0]), np.array(angle))
    local[1, upper + 1] = from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(0.4))
    position, rotation = forward_kinematics(np.array([[0.0, 0.935, 0.0], [0.0, 0.935, 0.0]]), local)
    across = np.array((0.36, 0.05, 0.12))  # to the left, so that the path leads past the shoulder
    move = position[1, upper] + across - palms(position, rotation, LEFT)[0]
    position[0] += move
    return position.astype(np.float32), rotation.astype(np.float32)


@pytest.mark.parametrize("angle", [-0.5, 0.0, 0.5, 1.0, 1.4])
def test_joints_move_evenly_across_shoulder(angle):
    """The palm moves half around the shoulder while the hold closes: evenly, and so does the elbow."""
    before = opposite_poses(angle)
    who, hand = np.array([[0, 1]], np.int32), np.array([[LEFT, RIGHT]], np.int32)
    shares = np.linspace(0.0, 1.0, 201)
    way = np.array([reach(*before, share, who, hand)[0][1] for share in shares])
    speed = np.linalg.norm(np.diff(way, axis=0), axis=-1) / np.diff(shares)[:, None]
    assert speed.max() < 4.0  # [m] of the whole way; half round is 1.9 m at arm's length
    away = np.linalg.norm(way[:, SKELETON.index("rightHand")] - way[:, SKELETON.index("rightUpperArm")], axis=-1)
    assert away.min() > 0.25  # never through the shoulder


@pytest.mark.long
def test_arm_straightens_smoothly():
    """The leader moves away evenly: the elbow is never more than three times as fast."""
    ways = []
    for k in range(120):
        position, rotation = facing(0.5)
        position[0, :, 2] -= np.float32(0.005 * k)
        ways.append(reach(position, rotation)[0][1])
    speed = np.linalg.norm(np.diff(np.array(ways), axis=0), axis=-1) / 0.005
    assert speed.max() < 3.0


@pytest.mark.long
def test_chains_of_holds_match_sequential_holds():
    trios = []
    for seed in range(40):
        (p, r), (q, s) = facing(0.55, seed=seed), facing(0.55, seed=seed + 50)
        trios.append((np.concatenate([p, q[1:] + p[1, 0] - q[0, 0]]), np.concatenate([r, s[1:]])))
    position, rotation = (np.concatenate([one[k] for one in trios]) for k in range(2))
    chain = np.array([[0, 1], [1, 2]], np.int32), np.array([[LEFT, RIGHT], [RIGHT, LEFT]], np.int32)
    who = (3 * np.arange(40)[:, None, None] + chain[0]).reshape(-1, 2).astype(np.int32)
    hand = np.tile(chain[1], (40, 1))
    reach_palms(position, rotation, who, hand, np.ones(80, np.float32), np.zeros((80, 4), np.float32), ARM_JOINTS)
    for n, (p, r) in enumerate(trios):
        for k in range(2):
            one = np.ones(1, np.float32), np.zeros((1, 4), np.float32)
            reach_palms(p, r, chain[0][k : k + 1], chain[1][k : k + 1], *one, ARM_JOINTS)
        assert (position[3 * n : 3 * n + 3] == p).all()
        assert (rotation[3 * n : 3 * n + 3] == r).all()


def test_measured_reach_matches_geometry():
    position, rotation = facing(0.7, seed=4)
    out = np.zeros((2, 6), np.float32)
    measure_reach(position, rotation, *BOTH, ARM_JOINTS, out)
    for n, hand in enumerate((RIGHT, LEFT)):
        target, own = palms(position, rotation, 1 - hand)[0], palms(position, rotation, hand)[1]
        way = target - position[1, ARM_JOINTS[3 * hand]]
        chest = rotate(rotation[1, ARM_JOINTS[6]].astype(float), np.array((0.0, 0.0, 1.0)))
        over = palm_distance(position, rotation, hand) - arm_length(position, rotation, hand)
        assert out[n, 0] == pytest.approx(over + float(LENGTH_BUFFER), abs=1e-5)
        assert out[n, 1] == pytest.approx(float(way @ chest) / np.linalg.norm(way), abs=1e-5)
        assert out[n, 2] == pytest.approx(np.linalg.norm(target - own), abs=1e-5)
        assert rotate(rotation[1, ARM_JOINTS[6]].astype(float), out[n, 3:].astype(float)) == pytest.approx(
            way, abs=1e-5
        )


def test_kept_palm_target_ignores_leader_motion():
    before = facing(0.5)
    kept, who, hand = np.array([[-0.05, -0.1, 0.4, 1.0]], np.float32), BOTH[0][:1], np.array([[LEFT, RIGHT]], np.int32)
    ways = []
    for away in (0.0, 5.0):
        position, rotation = before[0].copy(), before[1].copy()
        position[0] += np.float32(away)
        reach_palms(position, rotation, who, hand, np.ones(1, np.float32), kept, ARM_JOINTS)
        ways.append(position[1])
    assert ways[0] == pytest.approx(ways[1], abs=1e-6)
    chest = rotate(before[1][1, ARM_JOINTS[6]].astype(float), kept[0, :3].astype(float))
    assert palms(position, rotation, RIGHT)[1] == pytest.approx(before[0][1, ARM_JOINTS[3]] + chest, abs=1e-4)
