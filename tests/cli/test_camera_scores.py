"""Measures of poses from cameras, against cases worked out by hand, and the camera of made films."""

from pathlib import Path

import numpy as np
import pytest

from bench._camera_dances import ShowPart, crossing_patch
from bench._camera_films import FilmCase, FilmTruth, Person, camera_matrix, load_truth, make_film, to_pixels
from bench._camera_scores import (
    ARMS_UP,
    CROUCH,
    JUMP,
    SEEN_JOINTS,
    Crossing,
    GestureEvent,
    Score,
    contact_score,
    event_score,
    find_crossings,
    find_gestures,
    foot_contacts,
    gesture_score,
    identities,
    identity_score,
    joint_error,
    motion_clip,
    pose_joints,
    root_error,
    step_share,
    tempo_error,
)
from bench._camera_sensor import IDEAL, Sensor, SensorPicture, moment_times, row_weights
from live.base.stage_snapshot import Camera
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.camera import project_points

REST = SKELETON.rest_positions().astype(np.float64)
STILL = np.zeros((1, JOINT_COUNT, 4))
STILL[..., 0] = 1.0


def standing(frames):
    return np.repeat(REST[None], frames, axis=0)


def walking(frames, rate, bpm):
    """Hips that bounce on every beat, feet in turns up and down: poses (F, 3) and (F, J, 4)."""
    beat = np.arange(frames) / rate * bpm / 60.0
    hips = np.repeat(REST[:1], frames, axis=0)
    hips[:, 1] -= 0.02 * (1.0 + np.cos(2.0 * np.pi * beat))
    rotation = np.repeat(STILL, frames, axis=0)
    for side, phase in (("left", 0.0), ("right", 1.0)):
        lift = 0.5 * np.maximum(np.sin(np.pi * (beat + phase)), 0.0) ** 2
        for joint, sign in (("UpperLeg", -1.0), ("LowerLeg", 2.0), ("Foot", -1.0)):
            rotation[:, SKELETON.index(side + joint), 0] = np.cos(0.5 * sign * lift)
            rotation[:, SKELETON.index(side + joint), 1] = np.sin(0.5 * sign * lift)
    return hips, rotation


def film_truth(hips, case=None):
    """The truth of dancers who stand at the hips' places (F, D, 3)."""
    case = case or FilmCase("hand", ShowPart("", ()), 1.0, ())
    frames, dancers = hips.shape[:2]
    joints = hips[:, :, None] + REST - REST[0]
    return FilmTruth(
        film=Path("hand.mp4"), name="hand", size=case.size, fps=30.0, time=np.arange(frames) / 30.0, joints=joints,
        rotation=np.zeros((frames, dancers, JOINT_COUNT, 4)), contact=np.zeros((frames, dancers, 2), bool),
        heel_ball=np.zeros((frames, dancers, 2, 2), bool), camera=camera_matrix(case), eye=np.array(case.eye),
        scale=1.0, in_picture=np.ones((frames, dancers, JOINT_COUNT), bool), bpm=None, lines=np.zeros(0), steps=(),
    )  # fmt: skip


def test_joint_error_is_free_of_place_and_counts_the_hips_only_as_root():
    truth = standing(4)
    assert joint_error(truth + np.array((3.0, -1.0, 2.0)), truth).mean == pytest.approx(0.0, abs=1e-12)
    hand = SKELETON.index("leftHand")
    moved = truth.copy()
    moved[:, hand, 2] += 0.21
    error = joint_error(moved, truth)
    assert error.mean == pytest.approx(0.21 / 21)
    assert error.seen == pytest.approx(0.21 / len(SEEN_JOINTS))
    assert error.each[hand] == pytest.approx(0.21)
    assert error.found == 1.0


def test_joint_error_of_a_larger_body_is_gone_after_scaling_and_turning_counts():
    truth = standing(3)
    larger = joint_error(1.1 * truth, truth)
    assert larger.size == pytest.approx(1.1)
    assert larger.scaled == pytest.approx(0.0, abs=1e-12)
    assert larger.mean == pytest.approx(0.1 * np.linalg.norm(REST[1:] - REST[0], axis=1).mean())
    assert joint_error(truth * (-1.0, 1.0, -1.0), truth).seen > 0.3


def test_joint_error_leaves_out_frames_without_a_pose_and_says_so():
    truth = standing(4)
    found = truth.copy()
    found[1:] = np.nan
    error = joint_error(found, truth)
    assert (error.mean, error.found) == (0.0, 0.25)
    nothing = joint_error(np.full_like(truth, np.nan), truth)
    assert np.isnan(nothing.mean)
    assert nothing.found == 0.0
    with pytest.raises(ValueError, match="differ in shape"):
        joint_error(truth[:2], truth)


def test_pose_joints_scale_the_body_about_its_hips_in_the_world():
    hips = np.array([[1.0, 1.87, 2.0], [np.nan] * 3])
    joints = pose_joints(hips, np.repeat(STILL, 2, axis=0), 2.0)
    np.testing.assert_allclose(joints[0], 2.0 * (REST - REST[0]) + hips[0], atol=1e-6)
    assert np.isnan(joints[1]).all()


def test_contacts_count_frames_and_feet():
    truth = np.array([[1, 0], [1, 1], [0, 0], [0, 1]], bool)
    found = np.array([[1, 1], [0, 1], [0, 0], [0, 0]], bool)
    score = contact_score(found, truth)
    assert score == Score(2, 1, 2)
    assert (score.precision, score.recall) == (pytest.approx(2 / 3), 0.5)
    assert score.f1 == pytest.approx(4 / 7)
    assert Score().f1 == 1.0
    assert Score(missed=3).f1 == 0.0


def test_feet_on_the_floor_are_found_but_for_frames_without_a_pose_and_raised_ones():
    joints = standing(60)
    joints[20:30] = np.nan
    joints[:, SKELETON.index("rightFoot"), 1] += 0.3
    joints[:, SKELETON.index("rightToes"), 1] += 0.3
    contact = foot_contacts(joints, 30.0)
    assert contact[:20, 0].all()
    assert contact[30:, 0].all()
    assert not contact[20:30].any()
    assert not contact[:, 1].any()


def test_tempo_of_the_same_motion_fits_and_of_a_faster_one_does_not():
    slow = motion_clip("slow", *walking(400, 30.0, 100.0), 30.0)
    fast = motion_clip("fast", *walking(400, 30.0, 110.0), 30.0)
    same, other = tempo_error(slow, slow), tempo_error(fast, slow)
    assert same.error == 0.0
    assert same.true_bpm == pytest.approx(100.0, rel=0.03)
    assert other.error == pytest.approx(0.1, abs=0.02)
    still = motion_clip("still", standing(400)[:, 0], np.repeat(STILL, 400, axis=0), 30.0)
    assert tempo_error(slow, still) is None
    assert tempo_error(still, slow).error == 1.0


def test_a_motion_with_gaps_holds_the_pose_before_them():
    hips, rotation = walking(10, 30.0, 100.0)
    whole = hips.copy()
    hips[0], hips[4:6] = np.nan, np.nan
    clip = motion_clip("gaps", hips, rotation, 30.0)
    np.testing.assert_allclose(clip.root_position[[0, 4, 5, 6]], whole[[1, 3, 3, 6]], atol=1e-6)
    with pytest.raises(ValueError, match="no pose"):
        motion_clip("none", np.full((3, 3), np.nan), np.repeat(STILL, 3, axis=0), 30.0)


def test_root_error_is_on_the_floor_and_height_apart():
    truth = np.zeros((4, 3))
    found = truth + np.array((0.3, 0.1, 0.4))
    found[3] = np.nan
    error = root_error(found, truth)
    assert (error.mean, error.p95) == (pytest.approx(0.5), pytest.approx(0.5))
    assert (error.height, error.found) == (pytest.approx(0.1), 0.75)


def test_identities_are_those_of_the_nearest_with_the_smallest_sum():
    hips = np.array([[[0.0, 0.9, 0.0], [0.5, 0.9, 0.0]]] * 3)
    people = [
        [(7, 0.3, 0.0), (8, -0.1, 0.0)],  # 7 is nearer to both, but 8 can only be the first
        [(8, 0.05, 0.0)],
        [(9, 3.0, 0.0)],
    ]
    np.testing.assert_array_equal(identities(people, hips), [[8, 7], [8, -1], [-1, -1]])


def test_crossings_are_where_bodies_overlap_in_the_picture():
    frames = 90
    hips = np.zeros((frames, 3, 3))
    hips[..., 1] = 0.9
    hips[:, 0, 0] = np.linspace(-1.5, 1.5, frames)
    hips[:, 1, 0] = -hips[:, 0, 0]
    hips[:, 1, 2] = -1.0  # behind the first
    hips[:, 2, 0] = 4.0
    (crossing,) = find_crossings(film_truth(hips))
    assert crossing.dancers == (0, 1)
    assert crossing.first < 44.5 < crossing.last
    # bodies are 0.45 m wide and come nearer by 2 x 3 m in 89 frames, those behind look smaller
    assert crossing.last - crossing.first == pytest.approx(0.45 * 2 / (6.0 / 89), abs=4)


def test_identity_is_kept_unless_it_is_swapped_lost_or_shared():
    crossing = Crossing((0, 1), 40, 50)
    kept = np.tile([3, 4], (90, 1))
    kept[40:51] = -1
    assert identity_score(kept, [crossing], 30.0).kept_share == 1.0
    swapped = kept.copy()
    swapped[51:] = (4, 3)
    score = identity_score(swapped, [crossing], 30.0)
    assert (score.kept, score.switches) == (0, 2)
    fresh = kept.copy()
    fresh[51:, 1] = 9
    assert identity_score(fresh, [crossing], 30.0).kept == 0
    lost = kept.copy()
    lost[51:, 1] = -1
    assert identity_score(lost, [crossing], 30.0).kept == 0
    shared = np.full_like(kept, 3)
    assert identity_score(shared, [crossing], 30.0).kept == 0
    assert identity_score(kept, [], 30.0).kept_share == 1.0


def test_gestures_are_found_where_they_begin_and_only_if_they_last():
    joints = standing(120)
    for side in ("left", "right"):
        joints[30:60, SKELETON.index(side + "Hand")] = (0.0, 1.9, 0.0)
        joints[61:64, SKELETON.index(side + "Hand")] = (0.0, 1.9, 0.0)  # too short
    joints[70:80, :, 1] += 0.2
    joints[90:110, 0, 1] = 0.5
    found = find_gestures(joints, 30.0)
    assert found == [GestureEvent(ARMS_UP, 1.0), GestureEvent(JUMP, 70 / 30), GestureEvent(CROUCH, 3.0)]
    assert find_gestures(1.2 * joints, 30.0, 1.2) == found
    joints[30:60, SKELETON.index("leftHand"), 1] = 1.0  # one arm is not both
    assert ARMS_UP not in {event.kind for event in find_gestures(joints, 30.0)}


def test_events_are_paired_once_within_the_tolerance():
    assert event_score([1.0, 1.1], [1.05], 0.2) == Score(1, 1, 0)
    assert event_score([1.25], [1.0, 2.0], 0.2) == Score(0, 1, 2)
    # the first could take the second true one and leave nothing for the other
    assert event_score([1.0, 1.3], [0.9, 1.1], 0.25) == Score(2, 0, 0)
    scores = gesture_score(
        [GestureEvent(JUMP, 1.0), GestureEvent(CROUCH, 2.0)], [GestureEvent(JUMP, 1.2), GestureEvent(JUMP, 4.0)]
    )
    assert scores == {JUMP: Score(1, 0, 1), CROUCH: Score(0, 1, 0)}
    assert sum(scores.values(), Score()).f1 == pytest.approx(0.5)


def test_steps_without_an_answer_are_not_recognised():
    assert step_share(["groove", None, "kick", "walk"], ["groove", "groove", "kick", "kick"]) == 0.5
    assert np.isnan(step_share([], []))
    with pytest.raises(ValueError, match="1 recognised"):
        step_share(["groove"], [])


def test_the_matrix_of_a_film_is_the_renderers_camera():
    case = FilmCase("c", ShowPart("", ()), 1.0, (), eye=(1.0, 1.6, 5.0), target=(0.2, 1.0, 0.3), size=(640, 360))
    points = np.random.default_rng(3).uniform(-1.0, 2.0, (20, 3))
    camera = Camera(case.eye, case.target, case.field_of_view_deg)
    np.testing.assert_allclose(
        to_pixels(camera_matrix(case), points), project_points(camera, case.size, points), atol=1e-9
    )


def test_rows_of_a_rolling_shutter_see_their_own_time():
    sensor = Sensor(shutter_s=0.01, readout_s=0.02, moments=6)
    weights, times = row_weights(sensor, 101), moment_times(sensor)
    np.testing.assert_allclose(weights.sum(axis=0), 1.0, atol=1e-6)
    np.testing.assert_allclose(times @ weights, (np.arange(101) / 101 - 50 / 101) * 0.02, atol=1e-6)
    np.testing.assert_allclose(row_weights(Sensor(shutter_s=0.01, readout_s=0.0, moments=4), 5), 0.25)


def test_noise_comes_from_the_seed_and_grows_in_the_dark():
    grey = np.full((40, 60, 3), 128, np.uint8)

    def picture(sensor, seed=1):
        made = SensorPicture(sensor, (60, 40), seed)
        for _ in range(sensor.moments):
            made.add(grey)
        return made.develop()

    np.testing.assert_allclose(picture(IDEAL), grey, atol=1)
    day, night = Sensor(), Sensor(electrons=150.0)
    np.testing.assert_array_equal(picture(day), picture(day))
    assert (picture(day) != picture(day, 2)).any()
    assert picture(day).mean() == pytest.approx(128.0, abs=1.0)
    assert picture(night).std() > 3.0 * picture(day).std() > 1.0


@pytest.mark.gl
@pytest.mark.long
def test_a_film_shows_its_dancers_where_the_truth_says(tmp_path):
    import av

    blue = Person("woman", "unitard", (0.02, 0.05, 0.9), (0.02, 0.05, 0.9))
    green = Person("man", "unitard", (0.02, 0.7, 0.02), (0.02, 0.7, 0.02))
    source = ShowPart(crossing_patch(("groove", "groove"), bpm=112, dancers=2, width=2.4, depth=0.8), (0, 1))
    case = FilmCase(
        "small", source, 0.3, (blue, green), size=(320, 240), sensor=IDEAL, cluttered=False, height=1.9, seed=2
    )
    truth = make_film(case, tmp_path)
    again = load_truth(tmp_path / "small.npz")
    assert truth.steps == again.steps
    np.testing.assert_array_equal(truth.joints, again.joints)
    np.testing.assert_allclose(pose_joints(truth.hips[:, 1], truth.rotation[:, 1], truth.scale), truth.joints[:, 1])
    with av.open(str(truth.film)) as film:
        pictures = [frame.to_ndarray(format="rgb24").astype(int) for frame in film.decode(video=0)]
    assert len(pictures) == len(truth.time) == 9
    for dancer, channel in ((0, 2), (1, 1)):
        picture, pixels = pictures[4], truth.pixels()[4, dancer]
        others = np.delete(picture, channel, axis=2).max(axis=2)
        rows, columns = np.nonzero(picture[..., channel] > 1.6 * others)
        knees = pixels[[SKELETON.index(side + "LowerLeg") for side in ("left", "right")]]
        shoulders = pixels[[SKELETON.index(side + "UpperArm") for side in ("left", "right")]]
        trunk = (rows > shoulders[:, 1].max()) & (rows < pixels[0, 1])
        assert np.median(columns[trunk]) == pytest.approx(0.5 * (pixels[0, 0] + shoulders[:, 0].mean()), abs=3.0)
        neck = pixels[SKELETON.index("neck"), 1]
        assert neck - 5.0 < rows.min() < shoulders[:, 1].min() + 3.0  # where the costume's collar is
        assert rows.max() > knees[:, 1].max()
