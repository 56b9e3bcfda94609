"""Tests of bodies seen by cameras: made landmarks of the project's steps become the pose again."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.capture.landmark_body import HOLD, LandmarkBody
from live.motion.capture.packed_pose import pack_pose
from live.motion.capture.stage_points import fuse_views, same_persons
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from tests.fixtures.mostly_long import mostly_long
from tests.motion.capture.made_landmarks import RATE, landmark_places, look_at, seen, step_clip, truth

FRONT, SIDE = look_at((0.5, 1.6, 5.0), (0.0, 0.9, 0.0)), look_at((-4.5, 1.8, 2.0), (0.0, 0.9, 0.0))
TURN, RUN = ("waltz", "turning waltz"), ("hiphop", "running man")
SIDES = {"left": 0, "right": 1}


def dance(step, views, *, rounds=2, lead=0.0, **noise):
    """Return poses (T, J, 3), contacts (T, 2), the true poses and contacts of the last round of a step."""
    clip = step_clip(*step)
    joints, places = truth(clip)
    generator, body = np.random.default_rng(3), LandmarkBody()
    hips, rotation, contact = [], [], []
    for n in range(rounds * len(places)):
        frame = places[n % len(places)]
        points = [
            body.points(seen(frame, view, n / RATE, generator, **noise), view, camera)
            for camera, view in enumerate(views)
        ]
        pose = body.update_points(fuse_views(points), lead)
        hips.append(pose[0])
        rotation.append(pose[1])
        contact.append(body.contact)
    last = slice((rounds - 1) * len(places), None)
    found, _ = forward_kinematics(np.array(hips)[last], np.array(rotation)[last])
    return found, np.array(contact)[last], joints, clip.contact


def joint_error(found, joints):
    return float(np.linalg.norm((found - found[:, :1]) - (joints - joints[:, :1]), axis=2)[8:].mean())


def root_error(found, joints):
    return float(np.linalg.norm((found - joints)[8:, 0, ::2], axis=1).mean())


@mostly_long("step", [TURN, RUN], quick=[0])
def test_a_step_is_found_again(step):
    found, contact, joints, stands = dance(step, [FRONT], clicks=0.002)
    assert joint_error(found, joints) < 0.06
    assert root_error(found, joints) < 0.08
    assert np.abs(found[8:, 0, 1] - joints[8:, 0, 1]).mean() < 0.04
    assert 2.0 * (contact & stands).sum() / (contact.sum() + stands.sum()) > 0.8


@pytest.mark.long
def test_two_cameras_see_better_than_each_alone():
    alone = [dance(RUN, [view])[::2] for view in (FRONT, SIDE)]
    both = dance(RUN, [FRONT, SIDE])[::2]
    assert joint_error(*both) < 0.8 * min(joint_error(*each) for each in alone)
    assert root_error(*both) < min(root_error(*each) for each in alone)


@pytest.mark.long
def test_a_planted_foot_stands_still_on_the_floor():
    found, contact, _, _ = dance(TURN, [FRONT], clicks=0.002)
    moved = []
    for side, name in enumerate(("leftFoot", "rightFoot")):
        places = found[:, SKELETON.index(name)]
        held = contact[1:, side] & contact[:-1, side]
        moved += np.linalg.norm(np.diff(places, axis=0)[held][:, ::2], axis=1).tolist()
        assert places[:, 1].min() > 0.05
    assert np.median(moved) < 0.001


def test_same_landmarks_give_the_same_poses():
    first, second = dance(RUN, [FRONT], rounds=1)[0], dance(RUN, [FRONT], rounds=1)[0]
    assert first.tobytes() == second.tobytes()


def standing(bend=0.0):
    """Return landmarks (33, 3) of a dancer who stands with hanging arms, knees bent by `bend` [rad]."""
    rotation = np.zeros((1, SKELETON.joint_count, 4))
    rotation[..., 0] = 1.0
    for side, sign in (("left", -1.0), ("right", 1.0)):
        rotation[0, SKELETON.index(side + "UpperArm")] = quaternion.from_axis_angle(
            np.array((0.0, 0.0, sign)), np.array(1.2)
        )
        for bone, angle in (("UpperLeg", -0.5 * bend), ("LowerLeg", bend), ("Foot", -0.5 * bend)):
            turn = quaternion.from_axis_angle(np.array((1.0, 0.0, 0.0)), np.array(angle))
            rotation[0, SKELETON.index(side + bone)] = turn
    joints, world = forward_kinematics(np.zeros((1, 3)), rotation)
    low = joints[0, SKELETON.index("leftFoot"), 1] - 0.085
    joints = joints - (0.0, low, 0.0)
    return landmark_places(joints, world)[0], joints[0]


def show(body, places, times, view=FRONT, lead=0.0, change=lambda landmarks: landmarks):
    """Return the poses of unmoved landmarks at some times."""
    generator = np.random.default_rng(1)
    return [
        body.update(change(seen(places, view, t, generator, across=0.0, along=0.0, clicks=0.0)), view, lead)
        for t in times
    ]


def frames(begin, end):
    return np.arange(round(begin * RATE), round(end * RATE)) / RATE


def test_knees_never_bend_backwards():
    places, _ = standing()
    places[25:27] += FRONT.rotation[2] * 0.06  # the model puts the knees behind the legs
    (_, rotation) = show(LandmarkBody(), places, frames(0.0, 0.5))[-1]
    for side in SIDES:
        turn = quaternion.to_rotation_vector(rotation[SKELETON.index(side + "LowerLeg")])
        assert turn[0] > -0.05


def test_a_person_who_is_not_seen_is_held_then_lost_then_blended_back():
    body = LandmarkBody()
    places, _ = standing()
    last = show(body, places, frames(0.0, 0.5))[-1]
    seen_last = frames(0.0, 0.5)[-1]
    held = body.hold(seen_last + 0.9 * HOLD)
    assert held is not None
    assert held[0] is last[0]
    assert body.hold(seen_last + 1.1 * HOLD) is None
    assert body.lost
    crouched, _ = standing(1.2)
    back = show(body, crouched, frames(0.9, 1.4))
    assert not body.lost
    heights = [pose[0][1] for pose in back]
    assert abs(heights[0] - last[0][1]) < 0.06
    assert heights[-1] < last[0][1] - 0.1
    assert np.abs(np.diff(heights)).max() < 0.06


def test_no_person_and_weak_presence_give_nothing():
    places, _ = standing()
    assert show(LandmarkBody(), places, [0.0], change=lambda one: replace(one, presence=0.2)) == [None]


def test_limbs_that_are_not_seen_hold_then_hang():
    body = LandmarkBody()
    places, _ = standing()
    places[[13, 15, 17, 19, 21]] += (0.0, 0.55, 0.0)  # the left arm is up
    places[[15, 17, 19, 21]] += (0.0, 0.4, 0.0)

    def hidden(one):
        visibility = one.visibility.copy()
        visibility[[13, 15, 17, 19, 21]] = 0.05
        picture = one.picture.copy()
        picture[[13, 15, 17, 19, 21]] = np.random.default_rng(int(one.time * RATE)).random((5, 2))
        return replace(one, visibility=visibility, picture=picture)

    arm = SKELETON.index("leftUpperArm")
    shown = show(body, places, frames(0.0, 0.5))[-1][1][arm].copy()
    soon = show(body, places, frames(0.5, 0.8), change=hidden)
    turned = [2.0 * np.arccos(min(abs(float(pose[1][arm] @ shown)), 1.0)) for pose in soon]
    assert max(turned) < 0.05
    late = show(body, places, frames(0.8, 4.0), change=hidden)
    down = quaternion.rotate(late[-1][1][arm], np.array((1.0, 0.0, 0.0)))
    assert down[1] < -0.8
    steps = [abs(float(a[1][arm] @ b[1][arm])) for a, b in itertools.pairwise(late)]
    assert 2.0 * np.arccos(min(min(steps), 1.0)) < 0.2


@pytest.mark.parametrize("rows", [range(33), range(25, 33)])
def test_sides_that_swap_for_some_pictures_are_swapped_back(rows):
    body = LandmarkBody()
    places, _ = standing(0.6)
    places[[27, 29, 31]] += (0.0, 0.0, 0.35)  # a stride, so that the legs differ
    places[25] += (0.0, 0.0, 0.2)
    other = [n if n not in rows or n in (0,) else (n + 1 if n % 2 else n - 1) for n in range(33)]
    before = show(body, places, frames(0.0, 0.5))[-1]
    during = show(body, places[other], frames(0.5, 0.6))[-1]
    legs = [SKELETON.index(side + bone) for side in SIDES for bone in ("UpperLeg", "LowerLeg")]
    turned = 2.0 * np.arccos(np.minimum(np.abs(np.sum(before[1][legs] * during[1][legs], axis=1)), 1.0))
    assert turned.max() < 0.15
    assert 2.0 * np.arccos(min(abs(float(before[1][0] @ during[1][0])), 1.0)) < 0.15


def test_a_flip_that_lasts_is_believed():
    body = LandmarkBody()
    places, _ = standing()
    show(body, places, frames(0.0, 0.5))
    around = places * (-1.0, 1.0, -1.0)
    soon = show(body, around, frames(0.5, 0.6))[-1]
    assert quaternion.rotate(soon[1][0], np.array((0.0, 0.0, 1.0)))[2] > 0.9
    late = show(body, around, frames(0.6, 1.6))[-1]
    assert quaternion.rotate(late[1][0], np.array((0.0, 0.0, 1.0)))[2] < -0.9


def test_a_jump_leaves_the_floor_and_comes_back():
    body = LandmarkBody()
    places, _ = standing(0.3)
    generator = np.random.default_rng(1)
    heights, contacts = [], []
    for n in range(45):
        t = n / RATE
        up = max(0.0, 2.4 * (t - 0.7) - 4.9 * (t - 0.7) ** 2) if t > 0.7 else 0.0
        pose = body.update(seen(places + np.array((0.0, up, 0.0)), FRONT, t, generator, clicks=0.001), FRONT)
        heights.append(pose[0][1])
        contacts.append(body.contact)
    assert max(heights) - heights[20] > 0.15
    assert not np.array(contacts)[26:32].any()
    assert np.array(contacts)[-1].all()
    assert heights[-1] == pytest.approx(heights[20], abs=0.05)


@pytest.mark.long
def test_prediction_makes_up_for_a_delay():
    lead = 2
    late, _, joints, _ = dance(RUN, [FRONT], across=0.002, along=0.002, clicks=0.0005)
    early = dance(RUN, [FRONT], lead=lead / RATE, across=0.002, along=0.002, clicks=0.0005)[0]
    there = np.roll(joints, -lead, axis=0)
    keep = slice(0, len(joints) - lead)
    assert joint_error(early[keep], there[keep]) < 0.9 * joint_error(late[keep], there[keep])


def test_without_calibration_the_dancer_moves_over_the_floor():
    body = LandmarkBody()
    places, _ = standing()
    level = look_at((0.0, 1.1, 4.0), (0.0, 1.1, 0.0), 1.25)
    found = []
    for n, (x, z) in enumerate(((0.0, 0.0), (1.0, 0.0), (0.0, -1.0))):
        there = places + np.array((x, 0.0, z))
        generator = np.random.default_rng(1)
        for t in 3.0 * n + frames(0.0, 1.5):
            pose = body.update(seen(there, level, t, generator, across=0.0, along=0.0, clicks=0.0))
        found.append(pose[0])
    middle, right, back = found
    assert right[0] - middle[0] == pytest.approx(1.0, abs=0.3)
    assert back[2] - middle[2] == pytest.approx(-1.0, abs=0.4)
    assert middle[1] == pytest.approx(0.93, abs=0.08)


def test_poses_can_be_packed_and_malformed_landmarks_are_refused():
    body = LandmarkBody()
    places, _ = standing()
    assert len(pack_pose(*show(body, places, [0.0])[0])) == 192
    for change in (
        lambda one: replace(one, body=one.body * np.float32(np.nan)),
        lambda one: replace(one, body=one.body[:5]),
        lambda one: replace(one, picture=one.picture + 100.0),
        lambda one: replace(one, time=float("inf")),
    ):
        with pytest.raises(ValueError, match="landmarks"):
            show(body, places, [0.1], change=change)


def test_persons_in_several_cameras_are_joined_by_their_place():
    places, _ = standing()
    generator, body = np.random.default_rng(1), LandmarkBody()
    two = [places + np.array((x, 0.0, 0.0)) for x in (-1.2, 1.2)]
    front = [body.points(seen(each, FRONT, 0.0, generator), FRONT, n) for n, each in enumerate(two)]
    side = [body.points(seen(each, SIDE, 0.0, generator), SIDE, 2 + n) for n, each in enumerate(two[::-1])]
    assert same_persons([front, side]) == [[(0, 0), (1, 1)], [(0, 1), (1, 0)]]
    assert same_persons([front, side[:1]]) == [[(0, 0)], [(0, 1), (1, 0)]]
    with pytest.raises(ValueError, match="no view"):
        fuse_views([])
