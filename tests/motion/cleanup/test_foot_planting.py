"""Tests of foot planting: made faults go away, and what was right stays; on real recordings where they are present."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.cleanup.foot_planting import GLIDE_SPEED, SWING_CLEARANCE, foot_faults, plant_feet
from live.motion.clip import Clip
from live.motion.editing.foot_correction import ANKLES, BALLS, find_feet
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quality.metrics import contact_slide_speeds, skating_frames, velocity_changes
from live.motion.retarget.retarget import retarget
from live.motion.sketch.sketch_clips import step_clip
from live.motion.sketch.sketch_file import parse_sketch
from tests.fixtures.mocap import mocap_motion
from tests.fixtures.mostly_long import mostly_long
from tests.places import ROOT

WALK = ROOT / "patches" / "steps" / "walk.toml"


def walk():
    return step_clip(parse_sketch(WALK.read_text(encoding="utf-8"), "walk.toml"), "long forward").clip


def joints(clip):
    return forward_kinematics(clip.root_position.astype(float), clip.rotation.astype(float))[0]


def drifting(clip, speed):
    """The clip with everything carried along x at `speed` [m/s]: every standing foot slides so."""
    root = clip.root_position.astype(np.float64)
    root[:, 0] += speed * np.arange(len(root)) / clip.sample_rate
    return replace(clip, root_position=root.astype(np.float32))


def test_planted_sketch_hardly_changes():
    clip = walk()
    planted = plant_feet(clip)
    np.testing.assert_array_equal(planted.clip.contact, clip.contact)
    assert np.abs(joints(planted.clip) - joints(clip))[:, 1:].max() < 0.04
    assert planted.largest_shift < 0.01
    assert planted.before.slide == pytest.approx(planted.after.slide, abs=0.005)


def test_sliding_feet_stand_and_the_body_keeps_its_way():
    clip = drifting(walk(), 0.15)
    planted = plant_feet(clip)
    rate = clip.sample_rate
    assert planted.before.slide == pytest.approx(0.15, abs=0.03)
    assert contact_slide_speeds(joints(planted.clip), planted.clip.contact, rate).mean() < 0.01
    np.testing.assert_allclose(planted.clip.root_position[:, ::2], clip.root_position[:, ::2], atol=1e-6)
    assert (np.abs(planted.clip.root_position[:, 1] - clip.root_position[:, 1]) < 0.05).all()
    upper = joints(clip)[:, 1:10] - clip.root_position[:, None]
    np.testing.assert_allclose(joints(planted.clip)[:, 1:10] - planted.clip.root_position[:, None], upper, atol=1e-4)


def test_glide_is_no_stance_and_stays_a_glide():
    clip = drifting(walk(), 2.0 * GLIDE_SPEED)
    assert plant_feet(clip).clip is clip
    root = walk().root_position.astype(np.float64)  # glides from 0.6 of the clip on
    root[:, 0] += 2.0 * GLIDE_SPEED * np.maximum(np.arange(len(root)) - 0.6 * len(root), 0.0) / clip.sample_rate
    planted = plant_feet(replace(walk(), root_position=root.astype(np.float32)))
    glides = np.arange(clip.sample_count) > 0.6 * clip.sample_count + 20
    assert not planted.clip.contact[glides].any()
    assert planted.clip.contact[~glides].any()


def test_dragged_foot_is_lifted_clear_of_the_floor():
    """A straight-legged dancer whose left foot is drawn forward a centimetre over the floor."""
    clip = walk()
    swings = ~clip.contact[:, 0]
    flat = replace(clip, rotation=_lowered(clip, swings))
    planted = plant_feet(flat)
    assert planted.before.low_swing > 2.0 * planted.after.low_swing
    height = find_feet(planted.clip).ball[:, 0, 1] - TOES_OVER_SOLE
    speed = np.hypot(*np.gradient(find_feet(planted.clip).ball[:, 0, ::2], axis=0).T) * clip.sample_rate
    middle = swings & ~np.convolve(~swings, np.ones(13), "same").astype(bool)
    assert height[middle & (speed > 0.6)].min() > SWING_CLEARANCE - 0.01


def _lowered(clip, swings):
    """Rotations with the left foot 4 cm lower wherever it swings higher than that."""
    from live.motion.editing.foot_correction import solve_legs

    root, rotation = clip.root_position.astype(float), clip.rotation.astype(float)
    position, world = forward_kinematics(root, rotation)
    ankles = position[:, ANKLES].copy()
    room = np.maximum(find_feet(clip).height[:, 0] - 0.01, 0.0)
    ankles[:, 0, 1] -= np.where(swings, room, 0.0)
    return quaternion.align_signs(solve_legs(root, rotation, ankles, world[:, ANKLES])).astype(np.float32)


def test_short_and_standing_clips_are_taken():
    clip = walk()
    for part in (slice(0, 1), slice(0, 2), slice(0, 5)):
        small = Clip("small", clip.root_position[part], clip.rotation[part], clip.sample_rate, clip.contact[part])
        assert plant_feet(small).clip.sample_count == small.sample_count
    still = Clip(
        "still", np.tile(clip.root_position[:1], (90, 1)), np.tile(clip.rotation[:1], (90, 1, 1)), 60.0,
        np.ones((90, 2), np.bool_),
    )  # fmt: skip
    assert foot_faults(plant_feet(still).clip).slide == pytest.approx(0.0, abs=1e-6)


@pytest.mark.shared
@mostly_long(("name", "fps"), [("salsa/60_01.bvh", 60.0), ("group/perfume_aachan.bvh", None)], quick=[0])
def test_recorded_dance_stands_and_steps(name, fps):
    """By positions alone, as any other reader sees it; and no joint gets jerkier."""
    clip = retarget(mocap_motion(name), name="recording", fps=fps, drop_frames=6)
    planted = plant_feet(clip)
    before, after = joints(clip), joints(planted.clip)
    rate = clip.sample_rate
    assert contact_slide_speeds(after, planted.clip.contact, rate).mean() < 0.005
    assert contact_slide_speeds(before, planted.clip.contact, rate).mean() > 0.03
    assert skating_frames(after, rate).mean() < 0.1 * skating_frames(before, rate).mean()
    usual = np.percentile(velocity_changes(before, rate), 99.5, axis=0)
    jerks = np.percentile(velocity_changes(after, rate), 99.5, axis=0)
    assert (jerks < 1.8 * usual + 0.1).all()
    np.testing.assert_allclose(after[:, BALLS, ::2], before[:, BALLS, ::2], atol=0.3)
