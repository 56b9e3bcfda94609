"""Tests of arm clearance: contacts end, bones keep their lengths, nothing jumps, and who is not concerned stays."""

from pathlib import Path

import numpy as np
import pytest

from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.pose.arm_clearance import ArmEasing, apply_arm_clearance, clear_own_trunk
from live.motion.pose.body_capsules import ARM_CHAINS
from live.motion.pose.hand_hold import HeldArms
from live.motion.pose.neighbour_clearance_kernels import BACK, FRONT, LEFT, RIGHT, find_pairs
from live.motion.quality.body_contact import arm_distances, neighbour_contacts, self_contacts, trunk_scale
from live.motion.quaternion import from_axis_angle, inverse, mul, rotate
from live.motion.skeleton import JOINT_COUNT, MIRROR, SKELETON
from tests.fixtures.mostly_long import mostly_long

ARM_JOINTS = ARM_CHAINS[:, 1:].ravel()
OTHERS = [joint for joint in range(JOINT_COUNT) if joint not in ARM_CHAINS]
UP = np.array([0.0, 1.0, 0.0])
REFLECTED = np.array([1.0, 1.0, -1.0, -1.0], np.float32)


def posed(local, place=None, heading=0.0):
    """World poses of local rotations (A, J, 4) with hips at `place` (A, 2) [m]."""
    local = np.array(local, np.float64)
    local[:, 0] = mul(from_axis_angle(UP, np.broadcast_to(heading, len(local))), local[:, 0])
    root = np.tile([0.0, 0.935, 0.0], (len(local), 1))
    if place is not None:
        root[:, ::2] = place
    position, rotation = forward_kinematics(root, local)
    return np.ascontiguousarray(position, np.float32), np.ascontiguousarray(rotation, np.float32)


def turn_to(begin, end):
    """The shortest rotations from the direction `begin` (3,) to the directions `end` (n, 3)."""
    end = end / np.linalg.norm(end, axis=-1, keepdims=True)
    found = np.concatenate([1.0 + (end @ begin)[:, None], np.cross(begin, end)], axis=1)
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


def random_local(count, seed=0, ahead=0.03, spread=0.12):
    """Local rotations of dancers whose hands are about a place `ahead` of the trunk's middle [m], (count, J, 4)."""
    chance = np.random.default_rng(seed)
    axis = chance.normal(size=(count, JOINT_COUNT, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    local = from_axis_angle(axis, np.full((count, JOINT_COUNT), 0.1))
    rest = SKELETON.rest_positions().astype(np.float64)
    for (upper, forearm, _), sign in zip(ARM_CHAINS, (1.0, -1.0), strict=True):
        raised = np.array([0.4 * sign, -0.8, 1.5 * ahead]) + chance.normal(0.0, 0.3, (count, 3))
        raised /= np.linalg.norm(raised, axis=-1, keepdims=True)
        hand = np.array([0.08 * sign, 1.15, ahead]) + chance.normal(0.0, spread, (count, 3))
        local[:, upper] = turn_to(np.array([sign, 0.0, 0.0]), raised)
        bent = turn_to(np.array([sign, 0.0, 0.0]), hand - rest[upper] - 0.265 * raised)
        local[:, forearm] = mul(inverse(local[:, upper]), bent)
    return local


def cleared(poses, share=1.0, **given):
    """The poses after arm clearance."""
    position, rotation = poses[0].copy(), poses[1].copy()
    shares = np.full(len(position), share, np.float64)
    apply_arm_clearance(position, rotation, shares, **given)
    return position, rotation


def alone(poses, **given):
    """The poses after the clearance from the own trunk only."""
    return cleared(poses, visible=np.zeros(len(poses[0]), np.bool_), **given)


def deepest(position):
    """How near the forearms come to the trunk's axis: 0 on it, 1 at the surface, (A,)."""
    arms = position[:, ARM_CHAINS].astype(np.float64)
    part = np.linspace(0.0, 1.0, 9)[:, None]
    points = arms[:, :, 1, None] + part * (arms[:, :, 2] - arms[:, :, 1])[:, :, None]
    return trunk_scale(position, points.reshape(len(position), -1, 3)).min(axis=1)


def test_forearms_leave_the_own_trunk():
    """Nearly all that are not deep inside leave it; those near its axis may be on their way through."""
    poses = posed(random_local(600))
    before, after = deepest(poses[0]), deepest(alone(poses)[0])
    assert (before < 1.0).mean() > 0.1
    shallow = before > 0.75
    assert (before[shallow] < 1.0).sum() > 30
    assert (after[shallow] < 1.0).sum() < 0.05 * (before[shallow] < 1.0).sum()
    assert (after[~shallow] < 1.0).mean() < 0.5


def test_bones_keep_their_lengths_and_rotations_fit_positions():
    poses = posed(random_local(300, seed=1), np.random.default_rng(1).uniform(-4.0, 4.0, (300, 2)))
    position, rotation = cleared(poses)
    assert np.abs(position - poses[0]).max() > 0.05
    for joint, parent in enumerate(SKELETON.parents):
        if parent >= 0:
            there = position[:, parent] + rotate(rotation[:, parent].astype(np.float64), SKELETON.offsets[joint])
            np.testing.assert_allclose(position[:, joint], there, atol=2e-4)
    np.testing.assert_allclose(np.linalg.norm(rotation, axis=-1), 1.0, atol=1e-4)
    np.testing.assert_array_equal(position[:, OTHERS], poses[0][:, OTHERS])
    np.testing.assert_array_equal(rotation[:, OTHERS], poses[1][:, OTHERS])
    for _, forearm, hand in ARM_CHAINS:  # the hand keeps its angle to the forearm
        before = mul(inverse(poses[1][:, forearm]), poses[1][:, hand])
        np.testing.assert_allclose(mul(inverse(rotation[:, forearm]), rotation[:, hand]), before, atol=1e-4)


def test_arms_away_from_everything_keep_every_bit():
    local = from_axis_angle(UP, np.zeros((4, JOINT_COUNT)))  # arms out to the sides
    poses = posed(local, [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [0.0, 1.0]])
    for found, before in zip(cleared(poses), poses, strict=True):
        np.testing.assert_array_equal(found, before)


def test_without_a_share_nothing_moves_and_half_a_share_moves_less():
    poses = posed(random_local(200, seed=2), np.random.default_rng(2).uniform(-8.0, 8.0, (200, 2)))
    np.testing.assert_array_equal(cleared(poses, 0.0)[0], poses[0])
    whole, half = (np.linalg.norm(cleared(poses, share)[0] - poses[0], axis=-1).mean() for share in (1.0, 0.5))
    assert 0.3 * whole < half < 0.8 * whole


def test_mirror_images_are_cleared_as_mirror_images():
    place = np.random.default_rng(3).uniform(-1.5, 1.5, (60, 2))
    position, rotation = posed(random_local(60, seed=3), place)
    mirrored = position[:, MIRROR] * np.float32([-1, 1, 1]), np.ascontiguousarray(rotation[:, MIRROR] * REFLECTED)
    mirrored = np.ascontiguousarray(mirrored[0]), mirrored[1]
    found = cleared((position, rotation))
    image = cleared(mirrored)
    np.testing.assert_allclose(image[0], found[0][:, MIRROR] * [-1, 1, 1], atol=2e-3)


def test_a_dancer_is_cleared_the_same_in_any_row():
    place = np.random.default_rng(4).uniform(-1.5, 1.5, (50, 2))
    poses = posed(random_local(50, seed=4), place)
    order = np.random.default_rng(5).permutation(50)
    shuffled = cleared((np.ascontiguousarray(poses[0][order]), np.ascontiguousarray(poses[1][order])))
    np.testing.assert_allclose(shuffled[0], cleared(poses)[0][order], atol=2e-3)
    np.testing.assert_array_equal(cleared(poses)[0], cleared(poses)[0])  # every bit, the second time


def test_a_second_time_moves_almost_nothing():
    poses = posed(random_local(400, seed=6))
    shallow = deepest(poses[0]) > 0.75
    poses = poses[0][shallow], poses[1][shallow]
    first = alone(poses)
    moved = np.linalg.norm(alone(first)[0] - first[0], axis=-1)
    assert np.percentile(moved.max(axis=1), 95) < 0.01
    assert moved.mean() < 0.15 * np.linalg.norm(first[0] - poses[0], axis=-1).mean()


def sweep(steps, seed):
    """Arms that go evenly between random poses, (steps, J, 4)."""
    begin, end = random_local(2, seed=seed)
    begin, end = begin * np.sign((begin * end).sum(axis=-1, keepdims=True)), end
    t = np.linspace(0.0, 1.0, steps)[:, None, None]
    mixed = (1.0 - t) * begin + t * end
    return mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)


def roughness(path):
    """Largest step between neighbouring samples of arm joints [m]."""
    return np.linalg.norm(np.diff(path[:, ARM_JOINTS], axis=0), axis=-1).max()


@mostly_long("seed", range(20), quick=[0, 3, 6, 9, 12, 15])
def test_hands_that_pass_through_the_trunk_are_at_most_thirty_times_as_fast(seed):
    """From before the body to behind it: near the trunk's axis the shortest way out changes sides."""
    begin, end = (random_local(1, seed=seed, ahead=ahead, spread=0.03)[0] for ahead in (0.2, -0.2))
    end = end * np.where((begin * end).sum(axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    t = np.linspace(0.0, 1.0, 4001)[:, None, None]
    mixed = (1.0 - t) * begin + t * end
    raw = posed(mixed / np.linalg.norm(mixed, axis=-1, keepdims=True))
    assert roughness(alone(raw)[0]) < 30.0 * roughness(raw[0])


@mostly_long("seed", range(8), quick=[0, 1])
def test_motion_through_the_own_trunk_stays_continuous(seed):
    """With steps ten times finer the largest step of the arms is about ten times smaller, too: nothing jumps."""
    coarse, fine = (roughness(alone(posed(sweep(steps, seed)))[0]) for steps in (2001, 20001))
    assert fine < 0.2 * coarse


@mostly_long("seed", range(6), quick=[1, 3, 4])
def test_motion_beside_somebody_stays_continuous(seed):
    def path(steps):
        """All moments at once, each couple far from the others."""
        local = np.empty((2 * steps, JOINT_COUNT, 4))
        local[::2], local[1::2] = sweep(steps, seed), random_local(1, seed=seed + 50, ahead=0.4)
        apart = 4.0 * np.stack(np.divmod(np.arange(steps), 64), axis=1)
        place = np.repeat(apart, 2, axis=0) + np.tile([[0.0, 0.0], [0.3, 0.5]], (steps, 1))
        position, _ = cleared(posed(local, place, heading=np.tile([0.4, 3.0], steps)))
        joints = position[:, ARM_JOINTS].reshape(steps, -1, 3) - np.insert(apart, 1, 0.0, axis=1)[:, None]
        return np.linalg.norm(np.diff(joints, axis=0), axis=-1).max()

    assert path(4001) < 0.2 * path(401)


@pytest.mark.long
def test_arms_of_neighbours_come_apart_and_hands_leave_trunks():
    """A hundred random couples that face each other at 0.65 m."""
    touching, after, hands = 0, 0, 0
    for seed in range(100):
        poses = posed(
            random_local(2, seed=seed, ahead=0.5, spread=0.25), [[0.0, 0.0], [0.65, 0.0]], heading=np.array([1.2, -1.4])
        )
        touching += neighbour_contacts(poses[0])[0]
        arms, hand = neighbour_contacts(cleared(poses)[0])
        after, hands = after + arms, hands + hand
    assert touching > 20
    assert after <= 0.1 * touching
    assert hands == 0


def arms_together():
    """Two dancers 0.9 m apart, side by side, arms out: hands and forearms overlap."""
    local = from_axis_angle(UP, np.zeros((2, JOINT_COUNT)))
    for row in range(2):
        for side, sign in enumerate((1.0, -1.0)):
            local[row, ARM_CHAINS[side, 0]] = from_axis_angle(np.array([0.0, 0.0, 1.0]), np.array(-sign * 0.5))
            local[row, ARM_CHAINS[side, 1]] = from_axis_angle(UP, np.array(-sign * 0.5))
    return posed(local, [[-0.45, 0.0], [0.45, 0.0]])


def test_both_give_way_alike_and_one_alone_gives_way_wholly():
    poses = arms_together()
    assert neighbour_contacts(poses[0])[0]
    both = np.linalg.norm(cleared(poses)[0] - poses[0], axis=-1)
    assert both[0, ARM_CHAINS[0, 2]] == pytest.approx(both[1, ARM_CHAINS[1, 2]], abs=1e-3)
    assert both[0, ARM_CHAINS[0, 2]] > 0.02
    assert both[:, [ARM_CHAINS[1, 2], ARM_CHAINS[0, 2]]][[0, 1], [0, 1]].max() == 0.0  # the outer arms
    one = cleared(poses, np.array([1.0, 0.0]))[0]
    np.testing.assert_array_equal(one[1], poses[0][1])
    assert np.linalg.norm(one - poses[0], axis=-1)[0, ARM_CHAINS[0, 2]] > both[0, ARM_CHAINS[0, 2]]
    assert arm_distances(one, np.array([0]), np.array([1])).min() > 0.06


def arms_that_meet(rate, speed=1.0):
    """Two dancers 0.9 m apart who lower their arms towards each other and raise them again: poses (T, 2, J, ...)."""
    time = np.arange(int(2.0 / speed * rate)) / rate
    raised = 1.2 - 1.7 * np.sin(np.pi * 0.5 * speed * time) ** 2
    local = np.tile(from_axis_angle(UP, np.zeros(JOINT_COUNT)), (len(time), 2, 1, 1))
    for side, sign in enumerate((1.0, -1.0)):
        local[:, :, ARM_CHAINS[side, 0]] = from_axis_angle(np.array([0.0, 0.0, 1.0]), sign * raised)[:, None]
    place = np.tile([[-0.45, 0.0], [0.45, 0.0]], (len(time), 1))
    position, rotation = posed(local.reshape(-1, JOINT_COUNT, 4), place)
    return time, position.reshape(len(time), 2, -1, 3), rotation.reshape(len(time), 2, -1, 4)


def eased(time, position, rotation):
    """The frames after arm clearance with easing."""
    frames, easing = [], ArmEasing()
    for at, *pose in zip(time, position, rotation, strict=True):
        frames.append(cleared(pose, easing=easing, time=at))
    return np.array([frame[0] for frame in frames]), np.array([frame[1] for frame in frames])


def jolt(position, rate):
    """Largest change of velocity of arm joints from frame to frame [m/s]."""
    return np.linalg.norm(np.diff(position[:, :, ARM_JOINTS], 2, axis=0), axis=-1).max() * rate


@mostly_long(("speed", "softer", "touching"), [(1.5, 0.93, 0.0), (4.0, 0.85, 0.0)], quick=[1])
def test_arms_of_a_show_give_way_softly_and_in_time(speed, softer, touching):
    """Hands come together at 4 m/s, and at 11 m/s. Softer arms would miss the beat."""
    time, position, rotation = arms_that_meet(60.0, speed)
    at_once = np.array([cleared(pose)[0] for pose in zip(position, rotation, strict=True)])
    soft, turned = eased(time, position, rotation)
    before, after = (sum(neighbour_contacts(frame)[0] for frame in frames) for frames in (position, soft))
    assert before > 20
    assert after <= touching * before
    assert jolt(soft, 60.0) < softer * jolt(at_once, 60.0)
    length = np.linalg.norm(SKELETON.offsets[ARM_JOINTS], axis=-1)
    parents = [SKELETON.parents[joint] for joint in ARM_JOINTS]
    bones = np.linalg.norm(soft[:, :, ARM_JOINTS] - soft[:, :, parents], axis=-1)
    np.testing.assert_allclose(bones, np.broadcast_to(length, bones.shape), atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(turned, axis=-1), 1.0, atol=1e-4)


def test_arms_give_way_about_the_same_at_every_frame_rate():
    slow, fast = (eased(*arms_that_meet(rate))[0] for rate in (60.0, 240.0))
    moved = np.linalg.norm(slow - arms_that_meet(60.0)[1], axis=-1).max()
    assert np.linalg.norm(slow - fast[::4], axis=-1).max() < 0.2 * moved


def test_arms_are_at_once_where_they_should_be_at_the_first_frame_and_after_a_gap():
    poses, others = arms_together(), posed(random_local(2, seed=3, ahead=0.5), [[0.0, 0.0], [0.65, 0.0]])
    easing = ArmEasing()
    for time, pose in ((5.0, poses), (7.0, others), (7.0, others)):
        for soft, once in zip(cleared(pose, easing=easing, time=time), cleared(pose), strict=True):
            np.testing.assert_allclose(soft, once, atol=1e-6)


def test_who_is_not_visible_is_in_nobodys_way():
    poses = arms_together()
    found = cleared(poses, visible=np.array([True, False]))
    np.testing.assert_array_equal(found[0], poses[0])


def held_arms(count, share=1.0):
    """The dancers 0 and 1 hold each other by the left and the right hand."""
    held = HeldArms(count)
    held.add_holds(np.array([[0, 1]], np.int32), np.array([[0, 1]], np.int32), np.array([share], np.float32))
    return held


def test_joined_hands_stay_and_open_by_and_by():
    poses = arms_together()
    np.testing.assert_array_equal(cleared(poses, held=held_arms(2))[0], poses[0])
    moved = [np.linalg.norm(cleared(poses, held=held_arms(2, s))[0] - poses[0], axis=-1).max() for s in (0.9, 0.5, 0.1)]
    assert 0.0 < moved[0] < moved[1] < moved[2]


def test_a_couple_that_dances_as_recorded_may_touch_but_a_third_may_not():
    poses = arms_together()
    held = HeldArms(3)
    held.partner[1], held.together[1] = 0, 1.0
    third = tuple(np.concatenate([each, each[1:]]) for each in poses)
    third[0][2] += [0.05, 0.0, 0.02]
    pair = HeldArms(2)
    pair.partner[1], pair.together[1] = 0, 1.0
    np.testing.assert_array_equal(cleared(poses, held=pair)[0], poses[0])
    assert np.abs(cleared(third, held=held)[0][2] - third[0][2]).max() > 0.02


def test_pairs_are_those_of_all_overlapping_boxes():
    chance = np.random.default_rng(7)
    for count, spread in ((0, 1.0), (1, 1.0), (40, 2.0), (300, 15.0), (300, 1.0), (64, 3000.0)):
        centre, half = chance.uniform(-spread, spread, (2, count)), chance.uniform(0.2, 1.1, (2, count))
        box = np.empty((4, count), np.float32)
        box[LEFT], box[RIGHT] = centre[0] - half[0], centre[0] + half[0]
        box[BACK], box[FRONT] = centre[1] - half[1], centre[1] + half[1]
        visible = chance.uniform(size=count) < 0.8
        found = {tuple(sorted(pair)) for pair in find_pairs(box, visible).tolist()}
        overlap = (
            (box[LEFT][:, None] <= box[RIGHT]) & (box[LEFT] <= box[RIGHT][:, None])
            & (box[BACK][:, None] <= box[FRONT]) & (box[BACK] <= box[FRONT][:, None])
            & visible & visible[:, None]
        )  # fmt: skip
        wanted = set(zip(*(each.tolist() for each in np.nonzero(np.triu(overlap, 1))), strict=True))
        assert found == wanted
        assert len(find_pairs(box, visible)) == len(wanted)


def test_a_clip_keeps_out_of_the_trunk_and_changes_nothing_else():
    local = np.ascontiguousarray(np.concatenate([sweep(60, 1), sweep(60, 3)]), np.float32)
    root = np.ascontiguousarray(np.tile([0.0, 0.935, 0.0], (120, 1)), np.float32)
    clip = Clip("sweep", root, local, 60.0, np.zeros((120, 2), np.bool_))
    found = clear_own_trunk(clip)
    before, after = (self_contacts(forward_kinematics(each.root_position, each.rotation)[0]) for each in (clip, found))
    assert before.mean() > 0.05
    assert after.mean() < 0.6 * before.mean()
    still = [joint for joint in OTHERS if joint not in ARM_CHAINS]
    same = np.abs((found.rotation[:, still] * clip.rotation[:, still]).sum(axis=-1))
    np.testing.assert_allclose(same, 1.0, atol=1e-5)
    np.testing.assert_array_equal(found.root_position, clip.root_position)


SALSA = Path(__file__).resolve().parents[4] / "shared" / "mocap" / "salsa" / "60_01.bvh"


@pytest.mark.skipif(not SALSA.is_file(), reason="the shared recordings are not here")
def test_recorded_salsa_keeps_out_of_the_own_trunk():
    from live.library.motion_file import read_motion
    from live.motion.retarget.retarget import retarget

    clip = retarget(read_motion(SALSA), name="salsa", fps=60.0, drop_frames=6)
    before, after = (
        self_contacts(forward_kinematics(each.root_position, each.rotation)[0]).mean()
        for each in (clip, clear_own_trunk(clip))
    )
    assert before > 0.01
    assert after < 0.001


def test_dancers_without_detail_keep_every_bit_and_others_move_as_if_alone():
    """Rows of dancers far from the camera, between and beside those who are near; the near ones do not meet them."""
    count, near = 300, np.zeros(300, np.bool_)
    near[40:90], near[200:215], near[255] = True, True, True
    place = np.random.default_rng(5).uniform(-4.0, 4.0, (count, 2))
    place[~near, 1] -= 50.0
    poses = posed(random_local(count, seed=5), place)
    found = cleared(poses, detail=near.astype(np.float64))
    whole = cleared(poses)
    for with_detail, everybody, before in zip(found, whole, poses, strict=True):
        np.testing.assert_array_equal(with_detail[near], everybody[near])
        np.testing.assert_array_equal(with_detail[~near], before[~near])
    assert np.abs(found[0][near] - poses[0][near]).max() > 0.05


@pytest.mark.parametrize("scattered", [False, True])
def test_arms_move_less_with_less_detail_and_ease_over_frames(scattered):
    poses = posed(random_local(200, seed=6), np.random.default_rng(6).uniform(-9.0, 9.0, (200, 2)))
    parts, moved = np.linspace(0.0, 1.0, 6), []
    others = np.arange(200) % 2 == 1 if scattered else np.arange(200) >= 100
    for part in parts:
        easing, detail = ArmEasing(), np.where(others, 1.0, part)
        for frame in range(30):
            position, _ = cleared(poses, detail=detail, easing=easing, time=frame / 60)
        moved.append(np.linalg.norm(position - poses[0], axis=-1)[~others].max(axis=1))
    moved = np.array(moved)
    assert (moved[0] == 0.0).all()
    assert moved[-1].max() > 0.05
    assert (np.diff(moved.mean(axis=1)) > 0.0).all()
    assert np.abs(np.diff(moved, axis=0)).max() < 0.75 * moved[-1].max()  # no dancer's arms snap at some detail
