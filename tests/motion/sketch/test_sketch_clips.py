"""Tests of building clips from sketches: properties of all steps, and exact motion in particular ones."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from live.motion import quaternion
from live.motion.quality.body_contact import trunk_scale
from live.motion.skeleton import SKELETON
from live.motion.sketch.sketch_clips import TAIL_SAMPLES, step_clip, step_clips
from live.motion.sketch.sketch_file import Key, Sketch, SketchError, parse_sketch
from live.motion.step_clip import DIRECTIONS
from tests.fixtures.mostly_long import mostly_long
from tests.motion.sketch.sketch_measure import SIDES, first_and_last, joints, slide, soles

STEP_TOUCH = """
name = "touch"
travels = true
short = 0.2
long = 0.5
[right_foot]
"1" = "out 14"
"4" = "in 10, touch"
[left_foot]
"2" = "in 10, touch"
"3" = "out 14"
"""


def sketch_of(text: str) -> Sketch:
    return parse_sketch('name = "test"\n' + text, "test.toml")


@pytest.mark.long
def test_traveling_sketch_gives_nine_directions_and_mirrors() -> None:
    steps = step_clips(parse_sketch(STEP_TOUCH, "touch.toml"))
    assert [step.direction for step in steps] == [*DIRECTIONS, *DIRECTIONS]
    assert [step.mirrored for step in steps] == [False] * 9 + [True] * 9


def test_step_in_place_has_optional_mirror() -> None:
    assert [step.mirrored for step in step_clips(sketch_of(""))] == [False, True]
    assert len(step_clips(sketch_of("mirror = false"))) == 1


def test_clip_has_expected_timing_and_layout() -> None:
    step = step_clip(sketch_of("beats = 6\nbeats_per_measure = 3\nbpm = 90"))
    assert (step.measures, step.beats_per_measure, step.samples_per_measure, step.first) == (2, 3, 96.0, 96.0)
    assert step.clip.sample_count == 3 * 96 + 1 + TAIL_SAMPLES
    assert step.clip.sample_rate == pytest.approx(32 * 1.5)
    assert step.bpm == 90.0
    assert step.clip.rotation.dtype == step.clip.root_position.dtype == np.float32
    assert step.clip.rotation.flags.c_contiguous
    assert np.allclose(np.linalg.norm(step.clip.rotation, axis=2), 1.0, atol=1e-6)
    assert np.allclose(step.clip.root_position[96, [0, 2]], 0.0)


@mostly_long("direction", DIRECTIONS, quick=[0, 3, 6])
def test_travel_follows_direction_without_sliding(direction: str) -> None:
    step = step_clip(parse_sketch(STEP_TOUCH, "touch.toml"), direction)
    first, last = first_and_last(step)
    length = {"in": 0.0, "short": 0.2, "long": 0.5}[direction.split()[0]]
    way = {"forward": (0, 1), "back": (0, -1), "left": (1, 0), "right": (-1, 0), "place": (0, 0)}[direction.split()[1]]
    moved = step.clip.root_position[last] - step.clip.root_position[first]
    assert np.allclose(moved, (length * way[0], 0.0, length * way[1]), atol=1e-5)
    assert slide(step) < 0.001


def test_left_travel_mirrors_right_travel() -> None:
    text = 'travels = true\n[right_foot]\n"1 3" = "home, lift 5"\n[left_foot]\n"2 4" = "home, lift 5"'
    position, _ = joints(step_clip(sketch_of(text), "long left"))
    other, _ = joints(step_clip(sketch_of(text), "long right"))
    # the same walk, a beat later and on the other foot
    hips = position[32:, 0] - position[32, 0]
    assert np.allclose(hips, (other[:-32, 0] - other[0, 0]) * (-1.0, 1.0, 1.0), atol=2e-3)


def test_legs_do_not_cross_in_sideways_travel() -> None:
    for direction in ("long left", "long right", "short left"):
        step = step_clip(parse_sketch(STEP_TOUCH, "touch.toml"), direction)
        left, right = soles(step, "left")[1], soles(step, "right")[1]
        assert (left[:, 0] - right[:, 0]).min() > 0.1


def test_foot_lands_on_count_after_swing() -> None:
    step = step_clip(sketch_of('swing = 0.5\n[right_foot]\n"2" = "forward 20"\n"4" = "home"'))
    standing = step.clip.contact[128:256, 1]
    steps = np.flatnonzero(np.diff(standing.astype(int)) != 0) / 32 + 1
    assert steps == pytest.approx([1.5, 2.0 - 1 / 32, 3.5, 4.0 - 1 / 32], abs=1e-6)
    ball = soles(step, "right")[1][128:256]
    assert np.ptp(ball[40:70], axis=0) == pytest.approx(np.zeros(3), abs=1e-4)
    assert ball[50, 2] - ball[5, 2] == pytest.approx(0.2, abs=1e-4)
    assert ball[24, 1] > 0.02, "the foot is carried, not dragged"
    assert step.clip.contact[:, 0].all()


def test_heel_and_toe_lifts_pivot_correctly() -> None:
    step = step_clip(sketch_of('[right_foot]\n"1" = "home"\n"2" = "home, heel 6"\n[left_foot]\n"1" = "home, toe 5"'))
    heel, ball, tip = soles(step, "right")
    assert heel[128 + 32, 1] == pytest.approx(0.06, abs=0.003)
    assert np.ptp(ball, axis=0) == pytest.approx(np.zeros(3), abs=1e-4)
    assert np.ptp(tip[:, 1]) < 1e-3
    heel, ball, _ = soles(step, "left")
    assert heel[:, 1] == pytest.approx(np.zeros(len(heel)), abs=1e-4)
    assert ball[:, 1] == pytest.approx(np.full(len(ball), 0.05), abs=0.005)


def test_pelvis_follows_keys() -> None:
    text = '[pelvis]\n"1" = "down 6, left 5"\n"2" = "up 1, right 5"\n"3" = "down 6"\n"4" = "up 1"'
    hips = joints(step_clip(sketch_of(text)))[0][128:257, 0]
    assert hips[0, 1] - hips[32, 1] == pytest.approx(-0.07, abs=0.01)
    assert hips[0, 0] - hips[32, 0] == pytest.approx(0.10, abs=0.01)


def test_weight_shifts_over_standing_foot() -> None:
    step = step_clip(sketch_of('[right_foot]\n"2" = "up 25, forward 20"\n"4" = "home"'))
    hips = joints(step)[0][128:257, 0]
    left = soles(step, "left")[0][128:257]
    assert hips[0, 0] < hips[48, 0] < left[48, 0] + 0.03
    assert abs(hips[40, 0] - left[40, 0]) < 0.06


def test_jump_flight_is_ballistic() -> None:
    step = step_clip(sketch_of('bpm = 120\n[feet]\n"1 2" = "home"\n"2&" = "up 20"\n"3" = "home"'))
    up = ~step.clip.contact[128:256].any(axis=1)
    flight = up.sum() / step.clip.sample_rate
    assert 0.35 < flight < 0.55
    height = step.clip.root_position[128:256, 1]
    in_flight = np.flatnonzero(up)[3:-3]
    fall = np.diff(height[in_flight], n=2) * step.clip.sample_rate**2
    assert np.allclose(fall, -9.81, atol=0.5)
    assert height.min() < height[0] - 0.05, "it bends its knees before and after"


def test_full_turn_returns_to_start_without_sliding() -> None:
    text = """
    [body]
    "4" = "turn left 360"
    [left_foot]
    "1" = "home, lift 3"
    [right_foot]
    "2&" = "up 20, in 4"
    "4" = "home"
    """
    step = step_clip(sketch_of(text))
    position, rotation = joints(step)
    assert np.allclose(position[256], position[128], atol=1e-4)
    facing = 2.0 * np.unwrap(2.0 * np.arctan2(rotation[:, 0, 2], rotation[:, 0, 0])) / 2.0
    assert facing[256] - facing[128] == pytest.approx(2.0 * np.pi, abs=1e-4)
    assert slide(step) < 0.001


def test_quarter_turn_ends_at_right_angle() -> None:
    step = step_clip(sketch_of('[body]\n"3" = "turn left 90"\n[feet]\n"2" = "home, lift 4"'))
    position, _ = joints(step)
    ahead = position[:, SKELETON.index("leftToes")] - position[:, SKELETON.index("leftFoot")]
    assert np.allclose(ahead[256] @ ahead[128], ahead[128, 1] ** 2, atol=1e-3), "a right angle but for the height"


@pytest.mark.parametrize(("words", "up"), [("", -0.46), ("turn out 90", 0.87), ("turn in 90", -0.87)])
def test_palm_turns_up_and_down_about_the_forearm(words: str, up: float) -> None:
    """Arms to the sides: the wrists stay, the palms turn alike on both sides, half of it in the forearm."""
    step = step_clip(sketch_of(f'[hands]\n"1" = "out 50, up 0{", " + words if words else ""}"'))
    position, rotation = joints(step)
    plain, plain_rotation = joints(step_clip(sketch_of('[hands]\n"1" = "out 50, up 0"')))
    assert np.allclose(position, plain, atol=1e-5)
    for side in SIDES:
        hand, forearm = SKELETON.index(f"{side}Hand"), SKELETON.index(f"{side}LowerArm")
        palm = quaternion.rotate(rotation[160, hand], np.array((0.0, -1.0, 0.0)))
        assert palm[1] == pytest.approx(up, abs=0.03)
        turned = [abs(np.sum(rotation[160, j] * plain_rotation[160, j])) for j in (forearm, hand)]
        angle = 2.0 * np.degrees(np.arccos(np.clip(turned, 0.0, 1.0)))
        assert angle == pytest.approx([45.0, 90.0] if words else [0.0, 0.0], abs=0.5)


def test_hand_goes_around_the_trunk() -> None:
    """From behind the body to in front of it, a hand passes the own side, without a jump and never inside."""
    step = step_clip(sketch_of('[left_hand]\n"1" = "in 10, down 30, back 25"\n"3" = "in 15, down 30, forward 25"'))
    position, _ = joints(step)
    hand = position[:, SKELETON.index("leftHand")]
    assert trunk_scale(position, hand[:, None]).min() > 1.0
    assert np.linalg.norm(np.diff(hand, axis=0), axis=1).max() * step.clip.sample_rate < 4.0


def test_non_cyclic_step_starts_and_ends_neutral() -> None:
    text = 'cyclic = false\n[chest]\n"2" = "lean forward 60"\n[right_foot]\n"2" = "back 20"\n[hands]\n"2" = "out 40"'
    step = step_clip(sketch_of(text))
    position, _ = joints(step)
    neutral, _ = joints(step_clip(sketch_of("bounce = 0")))
    for sample in (0, 100, 128, 256, 260):
        assert np.allclose(position[sample], neutral[128], atol=0.012)
    assert position[160, SKELETON.index("head"), 2] > 0.2


def test_step_beyond_leg_reach_is_refused_with_field() -> None:
    with pytest.raises(SketchError) as caught:
        step_clips(sketch_of('[left_foot]\n"1" = "home"\n"3" = "out 160"'))
    error = caught.value
    assert (error.field, error.line) == ("left_foot", 2)
    assert "beyond the leg's reach" in error.problem


@pytest.mark.parametrize("wide", [60, 90])
def test_wide_step_lowers_pelvis_without_sliding(wide: int) -> None:
    step = step_clip(sketch_of(f'[left_foot]\n"1" = "home"\n"3" = "out {wide}"'))
    hips = step.clip.root_position[128:256, 1]
    assert hips.min() < 0.87 - wide / 1000
    assert slide(step) < 0.001


beats = st.integers(1, 15).map(lambda quarter: quarter / 4)
small = st.integers(-30, 30).map(lambda centimetres: centimetres / 100)
angle = st.integers(-15, 15).map(lambda tenth: tenth / 10)


def keys_of(amounts: st.SearchStrategy[dict[str, float]]) -> st.SearchStrategy[tuple[Key, ...]]:
    pairs = st.dictionaries(beats, amounts, min_size=1, max_size=5)
    return pairs.map(lambda found: tuple(Key(beat, found[beat]) for beat in sorted(found)))


bend = st.integers(-8, 8).map(lambda tenth: tenth / 10)
# Hips flung about by 90 degrees in a quarter of a beat, at the edge of the legs' reach, drag a foot along: not these.
hips = keys_of(st.fixed_dictionaries({"up": small, "left": small, "turn": bend, "lean": bend, "tilt": bend}))
trunk = keys_of(st.fixed_dictionaries({"up": small, "left": small, "turn": angle, "lean": angle, "tilt": angle}))
where = {
    "out": st.integers(-10, 30).map(lambda n: n / 100),
    "forward": small,
    "turn": st.integers(-5, 8).map(lambda n: n / 10),
}
lift = st.integers(0, 40).map(lambda n: n / 100)
roll = st.integers(0, 10).map(lambda n: n / 100)
place = st.fixed_dictionaries(where, optional={"up": lift, "heel": roll}) | st.fixed_dictionaries(
    where, optional={"up": lift, "toe": roll}
)
reach = st.fixed_dictionaries(
    {"out": small, "up": small, "forward": small, "elbow up": small, "wrist": angle, "turn": angle}
)
parts = st.fixed_dictionaries(
    {},
    optional={
        "pelvis": hips,
        "chest": trunk,
        "head": trunk,
        "left_foot": keys_of(place),
        "right_foot": keys_of(place),
        "left_hand": keys_of(reach),
        "right_hand": keys_of(reach),
        "body": st.builds(
            lambda turn: (Key(0.0, {"turn": 0.0}), Key(2.0, {"turn": turn})), st.integers(-7, 7).map(float)
        ),
    },
)


@pytest.mark.long
@settings(max_examples=20, suppress_health_check=[HealthCheck.too_slow])
@given(parts, st.booleans())
def test_random_sketch_gives_valid_clip_or_refusal(written: dict[str, tuple[Key, ...]], cyclic: bool) -> None:
    sketch = Sketch("any", "any.toml", parts=written, cyclic=cyclic)
    step, refusal = None, ""
    try:
        step = step_clip(sketch)
    except SketchError as error:
        refusal = error.problem
    if step is None:
        assert "beyond the leg's reach" in refusal
        return
    position, _ = joints(step)
    bones = np.linalg.norm(position[:, 1:] - position[:, SKELETON.parents[1:]], axis=2)
    assert np.allclose(bones, np.linalg.norm(SKELETON.offsets[1:], axis=1), atol=1e-5)
    assert slide(step) < 0.001
    for side in SIDES:
        assert min(point[:, 1].min() for point in soles(step, side)) > -0.01
    if cyclic and "body" not in written:
        first, last = first_and_last(step)
        assert np.allclose(position[last], position[first], atol=1e-4)
        velocity = np.diff(position, axis=0) * step.clip.sample_rate
        assert np.allclose(velocity[last], velocity[first], atol=5e-3)
