"""Tests of texture synthesis on synthetic dances: arms follow the legs, feet stand, and wrong settings are reported."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.errors import PersonError
from live.motion.cleanup.calibration_poses import trim_calibration_poses
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quality.metrics import contact_slide_speeds
from live.motion.texture.foot_constraints import texture_weights
from live.motion.texture.frequency_bands import RATE, columns_of, sample_clip, split_bands, tracks_of
from live.motion.texture.texture_corpus import make_corpus
from live.motion.texture.texture_report import make_report
from live.motion.texture.texture_settings import (
    LEGS,
    UPPER,
    TextureSettings,
    parse_bands,
    parse_column,
    parse_drive,
    parse_joints,
)
from live.motion.texture.texture_synthesis import TexturedSketch, prepare_sketch, texture_sketch
from tests.motion.editing.made_steps import sketched_step
from tests.motion.texture.made_dance import dance, without_arms

DATA = [dance(20.0, seed).clip for seed in (1, 2, 3)]
REAL = dance(8.0, 9).clip
SKETCH = without_arms(REAL)
MATERIAL = make_corpus(DATA, [sample_clip(SKETCH)])


def upper_positions(clip: Clip) -> np.ndarray:
    position, _ = forward_kinematics(np.zeros((clip.sample_count, 3)), clip.rotation.astype(np.float64))
    return position[:, list(UPPER)]


def test_synthesized_arms_follow_legs() -> None:
    made = texture_sketch(SKETCH, MATERIAL, TextureSettings(texture=()))[0]
    real, still = upper_positions(REAL), upper_positions(SKETCH)
    mean = np.broadcast_to(np.concatenate([upper_positions(clip) for clip in DATA]).mean(axis=0), real.shape)
    errors = [float(np.linalg.norm(one - real, axis=-1).mean()) for one in (upper_positions(made.clip), mean, still)]
    assert errors[0] < 0.6 * errors[1] < errors[2]
    assert np.array_equal(made.clip.rotation[:, [0, *LEGS]], SKETCH.rotation[:, [0, *LEGS]])
    assert np.array_equal(made.clip.root_position, SKETCH.root_position)


def test_recording_is_matched_to_itself() -> None:
    """If the sketch's legs are from a recording, that recording's fragments are found in order, with its arms."""
    own = make_corpus([*DATA, REAL], [sample_clip(SKETCH)])
    made = texture_sketch(SKETCH, own, TextureSettings(texture=(), bands=(1, 3)))[0]
    assert made.consecutive_joins == made.fragments.count - 1
    assert np.unique(own.starts.searchsorted(made.data_fragments.begin[made.sources], side="right")).tolist() == [4]
    assert np.abs(upper_positions(made.clip) - upper_positions(REAL)).max() < 2e-3


def test_distinct_paths_share_no_fragments() -> None:
    found = texture_sketch(SKETCH, MATERIAL, TextureSettings(texture=(), paths=3, distinct_paths=True))
    assert len(found) == 3
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert not np.any(found[one].sources == found[other].sources)
    best = texture_sketch(SKETCH, MATERIAL, TextureSettings(texture=(), paths=3))
    assert best[0].consecutive_joins >= best[1].consecutive_joins >= best[2].consecutive_joins
    assert np.array_equal(best[0].sources, found[0].sources)


def test_texture_changes_only_selected_bands() -> None:
    arms = parse_joints("arms", "--texture")
    made = texture_sketch(REAL, MATERIAL, TextureSettings(synthesize=(), texture=arms, bands=(2, 3)))[0]
    columns = columns_of(arms)
    before, after = (
        split_bands(tracks_of(sample_clip(clip), MATERIAL.charts)[:, columns], 6) for clip in (REAL, made.clip)
    )
    change = np.abs(after - before).max(axis=(1, 2))
    assert change[1:3].max() > 0.02  # the selected bands changed
    assert change[4:].max() < 0.25 * change[1:3].max()  # filtering again leaks into adjacent bands
    assert np.abs(after.sum(axis=0) - before.sum(axis=0)).max() < 1.0


def test_standing_feet_stay_while_hips_change() -> None:
    step = sketched_step("walk", "long forward").clip
    made = texture_sketch(step, make_corpus(DATA, [sample_clip(step)]), TextureSettings())[0].clip
    places = [
        forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))[0]
        for clip in (step, made)
    ]
    feet = [n for n in LEGS if n in (LEGS[2], LEGS[3], LEGS[6], LEGS[7])]
    moved = np.linalg.norm(places[1] - places[0], axis=-1)
    for foot in range(2):
        standing = step.contact[:, foot]
        assert moved[standing][:, feet[2 * foot : 2 * foot + 2]].max() < 2e-3
    assert np.abs(made.rotation - step.rotation).max() > 0.01
    slide = [float(contact_slide_speeds(one, step.contact, step.sample_rate).mean()) for one in places]
    assert slide[1] < slide[0] + 0.005


def test_standing_legs_have_zero_texture_weight() -> None:
    contact = np.zeros((100, 2), np.bool_)
    contact[40:60, 0] = True
    free = texture_weights(contact, np.full((100, 2), 0.2), 60.0)
    assert not free[40:60, 0].any()
    assert free[[0, 99], 0].tolist() == [1.0, 1.0]
    assert np.all(free[:, 1] == 1.0)
    assert np.abs(np.diff(free[:, 0])).max() < 0.3
    assert not texture_weights(contact, np.full((100, 2), 0.04), 60.0).any()  # a low foot would skate


def test_report_lists_source_fragments() -> None:
    found: list[TexturedSketch] = texture_sketch(SKETCH, MATERIAL, TextureSettings(paths=2))
    values = make_report(SKETCH, MATERIAL, TextureSettings(paths=2), found)
    assert len(values["paths"]) == 2
    assert len(values["paths"][0]["fragments"]) == found[0].fragments.count
    assert sum(one["fragments"] for one in values["recordings"]) == found[0].data_fragments.count
    assert values["candidates"] == round(0.1 * found[0].data_fragments.count)
    assert values["paths"][0]["kink_rad_s"]["after"] <= values["paths"][0]["kink_rad_s"]["before"]


def test_held_t_pose_at_end_is_trimmed() -> None:
    clip = DATA[0]
    posed = np.zeros_like(clip.rotation)
    posed[..., 0] = 1.0
    held = replace(
        clip,
        root_position=np.concatenate((clip.root_position[:60], clip.root_position)),
        rotation=np.concatenate((posed[:60], clip.rotation)),
        contact=np.concatenate((clip.contact[:60], clip.contact)),
    )
    assert trim_calibration_poses(clip) is clip
    assert abs(trim_calibration_poses(held).sample_count - (clip.sample_count - 30)) <= 2  # including the transition


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"bands": (3, 2)}, "bands 3-2"),
        ({"bands": (2, 99)}, "bands 2-99"),
        ({"match_band": 0}, "band 0"),
        ({"drive": ()}, "no driving joint"),
        ({"synthesize": (), "texture": ()}, "no joint is textured"),
        ({"synthesize": UPPER, "texture": UPPER}, "cannot be textured and synthesised"),
        ({"synthesize": LEGS, "texture": ()}, "feet would slide"),
        ({"paths": 0}, "0 paths"),
        ({"keep": 0.0}, "K = 0"),
    ],
)
def test_invalid_settings_are_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(PersonError, match=words):
        TextureSettings(**change)  # type: ignore[arg-type]


def test_command_line_values_are_parsed() -> None:
    assert set(parse_joints("hips,knees", "--drive")) == set(TextureSettings().drive)
    assert parse_joints("none", "x") == ()
    assert parse_bands("2-6", "--bands") == (2, 6)
    assert parse_column("auto", "--cut", TextureSettings().drive) is None
    drive = parse_joints("hips", "--drive")
    assert parse_column("leftUpperLeg.x", "--cut", drive) == 3 * drive[0]
    for wrong in ("tail", "hips,wings"):
        with pytest.raises(PersonError, match="no joint is called"):
            parse_joints(wrong, "--drive")
    for wrong in ("0-2", "6-2", "x", "2-99", ""):
        with pytest.raises(PersonError, match="--bands"):
            parse_bands(wrong, "--bands")
    with pytest.raises(PersonError, match="--cut"):
        parse_column("leftHand.x", "--cut", drive)


def test_short_clips_are_refused() -> None:
    short = Clip("blink", SKETCH.root_position[:20], SKETCH.rotation[:20], 60.0, SKETCH.contact[:20])
    with pytest.raises(PersonError, match=r"blink: 0\.32 s are too short"):
        make_corpus([short])
    with pytest.raises(PersonError, match=r"blink: 0\.32 s are too short"):
        texture_sketch(short, MATERIAL, TextureSettings())
    with pytest.raises(PersonError, match="no motion capture"):
        make_corpus([])


def test_driving_joints_change_over_time() -> None:
    first, changes = parse_drive("hips @4 knees", "--drive")
    hips, knees = parse_joints("hips", "x"), parse_joints("knees", "x")
    assert (first, changes) == (hips, ((4.0, knees),))
    both = tuple(sorted((*hips, *knees)))
    wish = TextureSettings(drive=both, initial_drive=first, drive_changes=changes, cut=3 * hips[0], texture=())
    by = [wish, *(replace(wish, initial_drive=one, drive_changes=((100.0, knees),)) for one in (hips, knees))]
    changing, of_hips, of_knees = (prepare_sketch(SKETCH, MATERIAL, one) for one in by)
    middle = 0.5 * (changing.fragments.begin + changing.fragments.end) / RATE
    assert 2 < np.count_nonzero(middle < 4.0) < len(middle) - 2
    for n, time in enumerate(middle):
        source = (of_hips if time < 4.0 else of_knees).matches
        assert set(changing.matches.candidates[n]) == set(source.candidates[n])  # some are equally near
        assert np.allclose(changing.matches.distances[n], source.distances[n])
    alone = prepare_sketch(SKETCH, MATERIAL, TextureSettings(drive=hips, cut=3 * hips[0], texture=()))
    assert alone.matches.candidates[0][0] == of_hips.matches.candidates[0][0]
    made = texture_sketch(SKETCH, MATERIAL, wish)[0]
    assert make_report(SKETCH, MATERIAL, wish, [made])["drive_changes"] == [[4.0, ["leftLowerLeg", "rightLowerLeg"]]]
    for wrong in ("hips @x knees", "hips @2", "hips @-1 knees", "hips @2 nose"):
        with pytest.raises(PersonError, match="--drive"):
            parse_drive(wrong, "--drive")
    with pytest.raises(PersonError, match="ascending times"):
        TextureSettings(drive_changes=((4.0, knees), (2.0, hips)))
