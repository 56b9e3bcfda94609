"""Tests of the depth of limbs in one camera: bones keep their lengths, wrong depths are put right."""

import numpy as np
import pytest

from live.motion.capture.landmark_body import LandmarkBody
from live.motion.capture.limb_depth import MODEL_SIZE, LimbDepth
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from tests.fixtures.mostly_long import mostly_long
from tests.motion.capture.made_landmarks import RATE, look_at, seen, step_clip, truth

FRONT = look_at((0.0, 1.3, 5.0), (0.0, 1.0, 0.0))
BONES = (
    (11, 13, 0.265), (12, 14, 0.265), (13, 15, 0.245), (14, 16, 0.245), (23, 25, 0.415), (24, 26, 0.415),
    (25, 27, 0.39), (26, 28, 0.39), (23, 24, 0.18), (11, 12, 0.33),
)  # fmt: skip
STEPS = [("waltz", "turning waltz"), ("hiphop", "running man")]


def wrong_depth(places, generator):
    """Return landmarks (T, 33, 3) whose limbs are moved along the camera's rays as a pose model does."""
    wrong = places.copy()
    for first, spread in ((13, 0.06), (15, 0.1), (25, 0.05), (27, 0.06)):
        for row in (first, first + 1):
            ray = places[:, row] - FRONT.position
            ray /= np.linalg.norm(ray, axis=1, keepdims=True)
            moved = ray * generator.normal(0.0, spread, (len(places), 1))
            # hands and feet are moved with wrists and ankles
            rows = {15: (15, 17, 19, 21), 16: (16, 18, 20, 22), 27: (27, 29, 31), 28: (28, 30, 32)}.get(row, (row,))
            for each in rows:
                wrong[:, each] += moved
    return wrong


def depth_of(places):
    ray = 0.5 * (places[23] + places[24]) - FRONT.position
    return ray / np.linalg.norm(ray)


@mostly_long("step", STEPS, quick=[0])
@pytest.mark.parametrize("cameras", [1, 2])
def test_bones_get_their_lengths(step, cameras):
    _, places = truth(step_clip(*step))
    generator, limbs = np.random.default_rng(4), LimbDepth()
    for frame in wrong_depth(places, generator):
        frame += generator.normal(0.0, 0.01, frame.shape)
        depth = depth_of(frame) if cameras == 1 else np.zeros(3)
        fitted = limbs.fit(frame, FRONT.position, depth, MODEL_SIZE)
        before, after = (
            np.array([np.linalg.norm(points[j] - points[i]) - length for i, j, length in BONES])
            for points in (frame, fitted)
        )
        assert np.abs(after).max() < max(0.01, 0.3 * np.abs(before).max())


@pytest.mark.parametrize("step", STEPS)
def test_depth_is_put_right_and_the_picture_is_kept(step):
    _, places = truth(step_clip(*step))
    wrong, limbs = wrong_depth(places, np.random.default_rng(4)), LimbDepth()
    fitted = np.array([limbs.fit(each, FRONT.position, depth_of(each), MODEL_SIZE).copy() for each in wrong])
    ends = [15, 16, 25, 26, 27, 28]
    error = [np.linalg.norm(points[:, ends] - places[:, ends], axis=2).mean() for points in (wrong, fitted)]
    assert error[1] < 0.95 * error[0]
    moved = (np.array([FRONT.project(each) for each in fitted]) - [FRONT.project(each) for each in places])[:, ends]
    assert np.abs(moved).mean() < 0.006


def test_a_body_of_another_size_keeps_its_size():
    _, places = truth(step_clip(*STEPS[1]))
    limbs = LimbDepth()
    small = places[5] * 0.9
    fitted = limbs.fit(small, FRONT.position, depth_of(small), 0.9 * MODEL_SIZE)
    for i, j, length in BONES:
        assert np.linalg.norm(fitted[j] - fitted[i]) == pytest.approx(0.9 * length, abs=0.01)


def test_the_landmarks_given_are_left_alone():
    _, places = truth(step_clip(*STEPS[1]))
    frame = places[0].copy()
    LimbDepth().fit(frame, FRONT.position, depth_of(frame), MODEL_SIZE)
    assert (frame == places[0]).all()


@pytest.mark.long
def test_hips_whose_distance_is_not_sure_do_not_bend_planted_legs():
    clip = step_clip(*STEPS[1])
    _, places = truth(clip)
    still = places[np.full(90, int(np.argmax(clip.contact.all(axis=1))))]
    assert clip.contact.all(axis=1).any()
    generator, body = np.random.default_rng(2), LandmarkBody()
    knees, feet = [], []
    for n, frame in enumerate(still):
        # the person seems to come and go along the camera's rays, by 12 cm
        swayed = frame + depth_of(frame) * (0.06 * np.sin(2.0 * np.pi * n / 30.0))
        pose = body.update(seen(swayed, FRONT, n / RATE, generator, across=0.0, along=0.0, clicks=0.0), FRONT)
        joints, _ = forward_kinematics(pose[0][None], pose[1][None])
        knees.append(joints[0, SKELETON.index("leftLowerLeg")] - joints[0, 0])
        feet.append(joints[0, SKELETON.index("leftFoot")])
    assert body.contact.all()
    assert np.ptp(np.array(feet)[30:, ::2], axis=0).max() < 0.01
    assert np.ptp(np.array(knees)[30:, 2]) < 0.03
