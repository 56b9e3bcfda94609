"""Tests of gestures: known movements, examples, tempo; at every place, heading and pose rate."""

import math

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.recognition.body_stream import RATE, BodyStream
from live.motion.recognition.built_in_gestures import BuiltInGestures
from live.motion.recognition.example_follower import ExampleFollower
from live.motion.recognition.gesture_examples import ExampleBank, make_examples
from live.motion.recognition.movement import Movement
from live.motion.skeleton import JOINT_COUNT, SKELETON

LEFT, RIGHT = SKELETON.index("leftUpperArm"), SKELETON.index("rightUpperArm")
DOWN = -1.3


def turned(x=0.0, y=0.0, z=0.0):
    return quaternion.from_rotation_vector(np.array([x, y, z]))


def body(left=DOWN, right=DOWN, *, height=0.935, yaw=0.0, place=(0.0, 0.0), bend=0.0):
    """A pose with both arms raised by so many radians from the horizontal, and bent knees."""
    rotation = np.zeros((JOINT_COUNT, 4))
    rotation[:, 0] = 1.0
    rotation[LEFT], rotation[RIGHT], rotation[0] = turned(z=left), turned(z=-right), turned(y=yaw)
    for side in ("left", "right"):
        rotation[SKELETON.index(f"{side}UpperLeg")] = turned(x=-bend)
        rotation[SKELETON.index(f"{side}LowerLeg")] = turned(x=1.9 * bend)
        rotation[SKELETON.index(f"{side}Foot")] = turned(x=-0.9 * bend)
    return np.array([place[0], height, place[1]], np.float32), rotation.astype(np.float32)


def raised(time, begin, end=1.2):
    """An arm that is raised from `begin` [s] for a second: half a second up, and down again."""
    part = min(max((time - begin) / 0.5, 0.0), 1.0, max((begin + 1.5 - time) / 0.5, 0.0))
    return DOWN + (end - DOWN) * part * part * (3.0 - 2.0 * part)


def known(poses, rate=60.0):
    stream, gestures, made = BodyStream(), BuiltInGestures(), []
    for number, (hips, rotation) in enumerate(poses):
        for time in stream.feed(hips, rotation, number / rate):
            made += [(name, time) for name in gestures.follow(stream.measure)]
    return made


@pytest.mark.parametrize("rate", [25.0, 30.0, 64.0, 120.0])
@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_arms_up_is_told_once_each_time_at_any_rate_and_heading(rate, yaw):
    times = np.arange(0.0, 6.0, 1.0 / rate)
    poses = [body(*[max(raised(t, 1.0), raised(t, 3.5))] * 2, yaw=yaw, place=(3.0, -2.0)) for t in times]
    made = known(poses, rate)
    assert [name for name, _ in made] == ["both arms up"] * 2
    assert 1.3 < made[0][1] < 1.8


def test_left_and_right_are_the_performers_own():
    times = np.arange(0.0, 4.0, 1.0 / 60.0)
    assert [name for name, _ in known([body(raised(t, 1.0), DOWN, yaw=3.0) for t in times])] == ["left arm up"]
    assert [name for name, _ in known([body(DOWN, raised(t, 1.0), yaw=3.0) for t in times])] == ["right arm up"]


def test_an_arm_that_trembles_at_the_limit_tells_one_gesture():
    times = np.arange(0.0, 5.0, 1.0 / 60.0)
    poses = [body(*[min(raised(min(t, 1.5), 1.0), 0.72 + 0.03 * math.sin(20.0 * t))] * 2) for t in times]
    assert len(known(poses)) <= 1


def test_a_jump_is_a_jump_and_standing_up_from_a_crouch_is_none():
    times = np.arange(0.0, 4.0, 1.0 / 60.0)
    jump = [body(height=0.935 + max(0.0, 4.9 * (t - 2.0) * (2.45 - t))) for t in times]
    assert [name for name, _ in known(jump)] == ["jump"]
    bend = [1.2 * math.sin(math.pi * min(max(t - 1.0, 0.0), 2.0) / 2.0) for t in times]
    crouch = [body(height=0.935 - 0.415 * (1 - math.cos(b)) - 0.39 * (1 - math.cos(0.9 * b)), bend=b) for b in bend]
    assert [name for name, _ in known(crouch)] == ["crouch"]


def test_a_full_turn_is_a_turn_and_half_a_turn_is_none():
    times = np.arange(0.0, 4.0, 1.0 / 60.0)
    part = np.clip((times - 1.0) / 1.2, 0.0, 1.0)
    assert [name for name, _ in known([body(yaw=2.0 * math.pi * p) for p in part])] == ["turn"]
    assert known([body(yaw=math.pi * p) for p in part]) == []


def wave(time, begin, speed=1.0, amount=1.0):
    """A figure of the right arm, two seconds long at speed 1."""
    part = min(max((time - begin) * speed / 2.0, 0.0), 1.0)
    return DOWN + amount * (1.0 * math.sin(math.pi * part) + 0.6 * math.sin(3.0 * math.pi * part) ** 2)


def features(poses, rate=32.0):
    stream, rows = BodyStream(), []
    for number, (hips, rotation) in enumerate(poses):
        for _ in stream.feed(hips, rotation, number / rate):
            if stream.count % 2 == 0:
                rows.append(stream.feature.copy())
    return np.array(rows)


def found(examples, motion):
    follower = ExampleFollower(ExampleBank.of(examples), [0] * len(examples))
    return [number for number, row in enumerate(motion) if follower.step(row)]


@pytest.mark.parametrize("speed", [0.7, 1.0, 1.5])
def test_an_example_is_found_faster_and_slower_elsewhere_and_turned(speed):
    times = np.arange(0.0, 9.0, 1.0 / 32.0)
    example = features([body(DOWN, wave(t, 0.0)) for t in np.arange(0.0, 2.0, 1.0 / 32.0)])
    motion = features([body(DOWN, wave(t, 4.0, speed, 1.1), yaw=2.2, place=(2.0, 3.0)) for t in times])
    made = found(make_examples([example]), motion)
    assert len(made) == 1
    assert 4.5 < made[0] / 16.0 < 4.0 + 2.0 / speed + 0.6


def test_the_other_arm_and_standing_are_not_the_example():
    times = np.arange(0.0, 9.0, 1.0 / 32.0)
    example = features([body(DOWN, wave(t, 0.0)) for t in np.arange(0.0, 2.0, 1.0 / 32.0)])
    examples = make_examples([example])
    assert found(examples, features([body(wave(t, 4.0), DOWN) for t in times])) == []
    assert found(examples, features([body() for _ in times])) == []


def test_an_example_that_is_too_short_is_refused_in_words():
    with pytest.raises(ValueError, match=r"0\.12 s; an example has 0\.38 to 16 s"):
        make_examples([np.zeros((2, 29))])


def test_background_lowers_a_threshold_and_never_raises_it():
    example = features([body(DOWN, wave(t, 0.0)) for t in np.arange(0.0, 2.0, 1.0 / 32.0)])
    near = features([body(DOWN, wave(t, 1.0, 1.0, 0.85)) for t in np.arange(0.0, 4.0, 1.0 / 32.0)])
    (alone,), (beside,) = make_examples([example]), make_examples([example], [near])
    assert 0.5 * alone.threshold < beside.threshold < alone.threshold


def test_a_step_of_the_library_that_is_near_lowers_a_threshold_and_the_gesture_itself_does_not():
    times = np.arange(0.0, 2.0, 1.0 / 32.0)
    example = features([body(DOWN, wave(t, 0.0)) for t in times])
    own = features([body(DOWN, wave(t, 0.0, 1.0, 1.05)) for t in times])
    far = features([body(wave(t, 0.0), DOWN) for t in times])
    (alone,), (itself,), (apart,) = (make_examples([example], [], steps) for steps in ([], [own], [own, far]))
    assert itself.threshold == alone.threshold
    assert apart.threshold > 1.2 * alone.threshold
    near = [features([body(DOWN, wave(t, 0.0, 1.0, amount)) for t in times]) for amount in (0.55, 0.5)]
    (beside,) = make_examples([example], [], [*near, far])
    assert 0.85 * alone.threshold < beside.threshold < 0.8 * apart.threshold


def noisy(motion, seed, size=0.05):
    return motion + np.random.default_rng(seed).normal(0.0, size, motion.shape)


def test_a_limit_follows_how_near_the_performers_own_dance_comes():
    times = np.arange(0.0, 2.0, 1.0 / 32.0)
    (example,) = make_examples([features([body(DOWN, wave(t, 0.0)) for t in times])])
    long = np.arange(0.0, 40.0, 1.0 / 32.0)
    limits = []
    for left, right in ((0.0, 0.9), (1.2, 0.0)):  # the same arm, and the other one
        swing = [body(*(DOWN + amount * math.sin(3.0 * t) ** 2 for amount in (left, right))) for t in long]
        follower = ExampleFollower(ExampleBank.of([example]), [0])
        for row in features(swing):
            follower.step(row)
        limits.append(follower.limit[0])
    assert 0.5 <= limits[0] < 0.8 * limits[1] <= 2.0


def test_a_performer_who_stands_does_not_change_what_is_usual():
    times = np.arange(0.0, 2.0, 1.0 / 32.0)
    (example,) = make_examples([features([body(DOWN, wave(t, 0.0)) for t in times])])
    follower = ExampleFollower(ExampleBank.of([example]), [0])
    for row in features([body() for _ in np.arange(0.0, 30.0, 1.0 / 32.0)]):
        follower.step(row)
    assert follower.limit[0] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_another_example_of_a_gesture_loses_none_that_one_finds(seed):
    times, chance = np.arange(0.0, 2.0, 1.0 / 32.0), np.random.default_rng(seed)
    takes = [features([body(DOWN, wave(t, 0.0, 1.0, amount)) for t in times]) for amount in chance.uniform(0.9, 1.1, 3)]
    long = np.arange(0.0, 16.0, 1.0 / 32.0)
    waves = [max(wave(t, begin, speed, 1.05) for begin, speed in ((2.0, 0.9), (6.0, 1.2), (11.0, 1.0))) for t in long]
    motion = noisy(features([body(DOWN, angle) for angle in waves]), seed, 0.02)
    one, three = (found(make_examples(takes[:count]), motion) for count in (1, 3))
    assert len(one) == len(three) == 3
    assert make_examples(takes)[0].threshold == make_examples(takes[:1])[0].threshold


@pytest.mark.parametrize("bpm", [84.0, 110.0, 138.0])
def test_tempo_follows_a_dance_within_three_percent(bpm):
    stream, movement = BodyStream(), Movement()
    for number in range(round(16.0 * 30.0)):
        beat = number / 30.0 * bpm / 60.0
        swing = 0.5 * abs(math.sin(math.pi * beat)) + 0.3 * math.sin(0.5 * math.pi * beat) ** 2
        hips, rotation = body(DOWN + swing, DOWN + 0.5 * swing, height=0.935 - 0.04 * abs(math.sin(math.pi * beat)))
        for _ in stream.feed(hips, rotation, number / 30.0):
            movement.follow(stream.measure, 1.08 * bpm)
    assert movement.tempo == pytest.approx(bpm, rel=0.03)


def dances(movement, stream, seconds, begin, angle, likely=120.0):
    """Let a body dance with an arm at `angle`(time), 30 poses a second; return the tempo after each half second."""
    told = []
    for number in range(round(30.0 * seconds)):
        time = begin + number / 30.0
        arm = DOWN + angle(time)
        for _ in stream.feed(*body(arm, arm), time):
            movement.follow(stream.measure, likely)
        if number % 15 == 0:
            told.append(movement.tempo)
    return told


def test_a_tempo_that_is_not_sure_is_not_told_and_the_last_sure_one_is_kept():
    chance = np.random.default_rng(4)
    corners = np.where(np.arange(200) % 2, 0.0, 1.8) + chance.uniform(0.0, 0.4, 200)
    free = np.cumsum(chance.uniform(0.15, 0.9, 200))
    stream, movement = BodyStream(), Movement()
    first = dances(movement, stream, 7.0, 0.0, lambda time: np.interp(time, free, corners))
    assert first == [0.0] * len(first)
    sure = dances(movement, stream, 20.0, 7.0, lambda time: 0.6 * math.sin(math.pi * time * 2.0) ** 2)[-1]
    assert sure == pytest.approx(120.0, rel=0.03)
    after = dances(movement, stream, 3.0, 27.0, lambda time: np.interp(time, free, corners))
    assert min(after) > 116.0


def test_tempo_follows_a_change_and_standing_has_none():
    stream, movement = BodyStream(), Movement()
    dances(movement, stream, 20.0, 0.0, lambda time: 0.6 * math.sin(math.pi * time * 100.0 / 60.0) ** 2, 106.0)
    assert movement.tempo == pytest.approx(100.0, rel=0.03)
    dances(movement, stream, 50.0, 20.0, lambda time: 0.6 * math.sin(math.pi * time * 130.0 / 60.0) ** 2, 130.0)
    assert movement.tempo == pytest.approx(130.0, rel=0.03)
    dances(movement, stream, 6.0, 70.0, lambda time: 0.3)
    assert movement.tempo == 0.0


def test_moments_are_the_same_whatever_was_before_a_gap():
    first, second = BodyStream(), BodyStream()
    for number in range(20):
        list(first.feed(*body(yaw=1.0), 1.0 + number / RATE))
    for stream in (first, second):
        for number in range(40):
            list(stream.feed(*body(DOWN, wave(number / 32.0, 0.2)), 5.0 + number / 32.0))
    np.testing.assert_array_equal(first.measure, second.measure)
    np.testing.assert_array_equal(first.feature, second.feature)
