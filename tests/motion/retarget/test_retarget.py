"""Tests of retargeting: bones keep their directions, feet their positions, in any form of source file."""

import re

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_axes import standing_pose
from live.motion.formats.source_motion import SourceMotion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.joint_mapping import find_body
from live.motion.retarget.retarget import retarget
from live.motion.skeleton import SKELETON
from tests.fixtures.mocap import mocap_motion
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_bvh import STANDING_CM, body_bvh, column, dance_values, still

LIMBS = [
    (side + joint, side + child)
    for side in ("left", "right")
    for joint, child in (
        ("UpperLeg", "LowerLeg"),
        ("LowerLeg", "Foot"),
        ("UpperArm", "LowerArm"),
        ("LowerArm", "Hand"),
    )
]
REAL = {
    "salsa/60_01.bvh": {"fps": 60.0, "drop_frames": 6},
    "salsa/61_01.bvh": {"fps": 60.0, "drop_frames": 6},
    "group/perfume_aachan.bvh": {},
    "solo/modern05/05_09.bvh": {"drop_frames": 1},
    "walk/figure8_MS2_8Walk_M.bvh": {},
    "walk/131_01_styled.bvh": {},
    "edge/mixed_rotation_orders.bvh": {},
    "edge/blender_export_24fps_walk01.bvh": {},
    "edge/frame_count_off_by_one_boxing.bvh": {},
    "edge/xyz_with_yxz_joints_dab.bvh": {},
    "edge/mixamo_prefix_freebvh.bvh": {},
}


def parse_values(values: np.ndarray, **how: object) -> SourceMotion:
    return bvh_to_source_motion(parse_bvh(body_bvh(values, **how), "made.bvh"))  # type: ignore[arg-type]


def positions_of(clip: Clip) -> np.ndarray:
    return forward_kinematics(clip.root_position.astype(float), clip.rotation.astype(float))[0]


def bone_directions(positions: np.ndarray, joint: int, child: int) -> np.ndarray:
    return quaternion.unit(positions[:, child] - positions[:, joint])


def test_standing_body_gives_engine_rest_pose() -> None:
    clip = retarget(parse_values(still(3)), name="still")
    np.testing.assert_allclose(np.abs(clip.rotation[..., 0]), 1.0, atol=1e-6)
    np.testing.assert_allclose(clip.root_position[:, [0, 2]], 0.0, atol=1e-6)
    np.testing.assert_allclose(positions_of(clip)[0], SKELETON.rest_positions(), atol=0.002)
    assert clip.contact.all()


def test_whole_body_turn_rotates_hips_alone() -> None:
    values = still(2)
    values[:, column("Hips", "Y")] = 70.0
    clip = retarget(parse_values(values), name="turned")
    forward = quaternion.rotate(clip.rotation[0, 0], np.array((0.0, 0.0, 1.0)))
    np.testing.assert_allclose(forward, (np.sin(np.radians(70)), 0.0, np.cos(np.radians(70))), atol=1e-5)
    np.testing.assert_allclose(np.abs(clip.rotation[:, 1:, 0]), 1.0, atol=1e-6)


@mostly_long(
    "how",
    [{}, {"scale": 0.01}, {"scale": 1 / 2.54}, {"z_up": True}, {"z_up": True, "scale": 10.0}],
    quick=[0, 3, 4],
    ids=["cm", "m", "inch", "z up", "z up mm"],
)
def test_file_units_and_axes_give_same_clip(how: dict[str, object]) -> None:
    """The same dance in another unit or with Z up gives the same clip."""
    expected = positions_of(retarget(parse_values(dance_values()), name="dance"))
    clip = retarget(parse_values(dance_values(), **how), name="dance")
    np.testing.assert_allclose(positions_of(clip), expected, atol=1e-4)


@pytest.mark.parametrize("arms", ["hanging", "half", "forward in rest"])
def test_rest_pose_of_arms_does_not_matter(arms: str) -> None:
    """The same motion on a skeleton with a different rest pose of the arms: the bones have the same directions."""
    angle = {"hanging": -90.0, "half": -45.0, "forward in rest": -10.0}[arms]
    offsets, values, other = {}, still(60), still(60)
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        for joint, length in (("ForeArm", 27.0), ("Hand", 24.0)):
            offsets[side + joint] = (sign * length * c, length * s, 0.0)
        swing = np.linspace(-60.0, 60.0, 60)
        values[:, column(side + "Arm", "Z")] = sign * swing  # arms from the T-pose up and down
        other[:, column(side + "Arm", "Z")] = sign * (swing - angle)
    first = positions_of(retarget(parse_values(values), name="t"))
    second = positions_of(retarget(parse_values(other, offsets=offsets), name="a"))
    np.testing.assert_allclose(second, first, atol=1e-4)


def scrambled_motion(text_values: np.ndarray) -> SourceMotion:
    """The same dance of a body with a meaningless rest pose (all bones along x, as some programs write).

    Every joint gets its own random rotation in the rest pose, undone in the motion.
    """
    motion = parse_values(text_values)
    rng = np.random.default_rng(2)
    turns = quaternion.unit(rng.normal(size=(motion.joint_count, 4)))
    world, _ = standing_pose(motion, find_body(motion), None)
    rotations = quaternion.mul(world.rotations, turns)  # world rotations of the new joints' axes
    offsets = motion.offsets.copy()
    values = np.empty((motion.frame_count, 3 + 3 * motion.joint_count))
    values[:, :3] = world.positions[:, 0]
    for joint, parent in enumerate(motion.parents):
        local = rotations[:, joint]
        if parent >= 0:
            offsets[joint] = quaternion.rotate(quaternion.inverse(turns[parent]), motion.offsets[joint])
            local = quaternion.mul(quaternion.inverse(rotations[:, parent]), local)
        w, x, y, z = local.T
        values[:, 3 + 3 * joint] = np.degrees(np.arctan2(2 * (w * z - x * y), 1 - 2 * (x * x + z * z)))
        values[:, 4 + 3 * joint] = np.degrees(np.arcsin(np.clip(2 * (w * x + y * z), -1, 1)))
        values[:, 5 + 3 * joint] = np.degrees(np.arctan2(2 * (w * y - x * z), 1 - 2 * (x * x + y * y)))
    names = {name: tuple(offset) for name, offset in zip(motion.names, offsets, strict=True)}
    return parse_values(values, offsets=names)


def test_meaningless_rest_pose_gives_same_limbs() -> None:
    values = dance_values()
    values[0] = still(1)[0]
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        values[0, column(side + "Arm", "Z")] = -sign * 70.0  # the moment of plain standing that it is found by
    expected = positions_of(retarget(parse_values(values), name="plain"))
    clip = retarget(scrambled_motion(values), name="scrambled")
    found = positions_of(clip)
    for joint, child in LIMBS:
        j, c = SKELETON.index(joint), SKELETON.index(child)
        np.testing.assert_allclose(bone_directions(found, j, c), bone_directions(expected, j, c), atol=1e-3)
    np.testing.assert_allclose(found[:, :6], expected[:, :6], atol=0.03)  # hips to head


def test_knees_bend_about_hinges_without_usable_rest_pose() -> None:
    clip = retarget(scrambled_motion(dance_values()), name="scrambled")
    positions, rotations = forward_kinematics(clip.root_position.astype(float), clip.rotation.astype(float))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        hip, knee, ankle = (SKELETON.index(side + name) for name in ("UpperLeg", "LowerLeg", "Foot"))
        hinge = quaternion.rotate(rotations[:, hip], np.array((1.0, 0.0, 0.0)))
        bend = np.cross(bone_directions(positions, hip, knee), bone_directions(positions, knee, ankle))
        sine = np.linalg.norm(bend, axis=-1)
        along = np.sum(hinge * bend, axis=-1)[sine > 0.4] / sine[sine > 0.4]
        assert np.median(along) > 0.9, (side, sign)


@pytest.mark.long
def test_clip_times_follow_given_frame_rate() -> None:
    motion = parse_values(dance_values(121), fps=120.0)
    assert retarget(motion, name="x").seconds == pytest.approx(1.0)
    assert retarget(motion, name="x", fps=60.0).seconds == pytest.approx(2.0)
    assert retarget(motion, name="x", fps=60.0, drop_frames=60).seconds == pytest.approx(1.0)
    assert retarget(motion, name="x", sample_rate=30.0).sample_count == 31
    early, late = retarget(motion, name="x", fps=60.0), retarget(motion, name="x", fps=60.0, drop_frames=60)
    np.testing.assert_allclose(np.abs(np.sum(early.rotation[60:] * late.rotation, axis=-1)), 1.0, atol=1e-5)


def test_frames_are_slerped_at_euler_singularity() -> None:
    """At the Euler singularity (X = 90 degrees) two equal poses may have angles 180 degrees apart (T045)."""
    values = still(2)
    values[:, column("Spine", "X")] = 90.0
    values[0, [column("Spine", "Z"), column("Spine", "Y")]] = 0.0
    values[1, [column("Spine", "Z"), column("Spine", "Y")]] = 170.0, -170.0  # the same rotation
    clip = retarget(parse_values(values, fps=10.0), name="singular")
    assert clip.sample_count == 7
    for sample in clip.rotation:
        np.testing.assert_allclose(np.abs(np.sum(sample * clip.rotation[0], axis=-1)), 1.0, atol=1e-6)


def test_rotation_between_frames_is_even() -> None:
    values = still(2)
    values[1, column("Hips", "Y")] = 90.0
    clip = retarget(parse_values(values, fps=6.0), name="turn")
    forward = quaternion.rotate(clip.rotation[:, 0], np.array((0.0, 0.0, 1.0)))
    headings = np.degrees(np.arctan2(forward[:, 0], forward[:, 2]))
    np.testing.assert_allclose(np.diff(headings), 9.0, atol=1e-3)


def test_hip_travel_is_scaled_by_leg_length() -> None:
    values = still(61)
    values[:, 0] = np.linspace(0.0, 82.0, 61)  # one leg's length to the left
    clip = retarget(parse_values(values), name="aside")
    assert clip.root_position[-1, 0] == pytest.approx(0.805, abs=1e-3)
    assert clip.root_position[0].tolist() == pytest.approx([0.0, clip.root_position[0, 1], 0.0])


def test_floor_is_moved_to_zero() -> None:
    values = dance_values()
    here = retarget(parse_values(values), name="x")
    values[:, 1] += 500.0
    there = retarget(parse_values(values), name="x")
    np.testing.assert_allclose(there.root_position, here.root_position, atol=1e-4)
    positions = positions_of(here)
    soles = positions[:, SKELETON.index("leftFoot"), 1] - 0.085, positions[:, SKELETON.index("rightFoot"), 1] - 0.085
    assert np.percentile(np.minimum(*soles), 5) > -0.06


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"fps": 0.0}, "fps 0.0: 1 to 10000 expected"),
        ({"fps": float("nan")}, "fps nan"),
        ({"drop_frames": 5}, "drop_frames 5: 0 to 4 expected"),
        ({"drop_frames": -1}, "drop_frames -1"),
        ({"unit_m": 1.0}, "would be 173 m tall; 1.2 to 2.2 m is plausible, that is unit_m 0.006"),
        ({"sample_rate": 0.0}, "sample rate 0.0 Hz"),
    ],
)
def test_arguments_out_of_range_are_refused(arguments: dict[str, float], words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        retarget(parse_values(still(5)), name="x", **arguments)  # type: ignore[arg-type]


def test_plausible_unit_is_accepted() -> None:
    assert retarget(parse_values(still(2)), name="x", unit_m=0.01).sample_count == 2


def test_motion_without_body_is_refused() -> None:
    text = "HIERARCHY\nROOT base { OFFSET 0 0 0 CHANNELS 1 Xrotation }\nMOTION\nFrames: 1\nFrame Time: 1\n0\n"
    with pytest.raises(MotionFileError, match=r"no joints found for leftUpperLeg, .* among base"):
        retarget(bvh_to_source_motion(parse_bvh(text, "x.bvh")), name="x")


def test_legs_without_length_are_refused() -> None:
    none = {side + joint: (0.0, 0.0, 0.0) for side in ("Left", "Right") for joint in ("Leg", "Foot")}
    with pytest.raises(MotionFileError, match="the legs have no length"):
        retarget(parse_values(still(2), offsets=none), name="x")


@pytest.mark.long
def test_unusual_skeletons_give_finite_clips_or_errors() -> None:
    rng = np.random.default_rng(9)
    clips = 0
    for _ in range(30):
        motion = parse_values(dance_values(4, seed=int(rng.integers(99))))
        names = rng.choice(motion.names, size=rng.integers(1, 12), replace=False)
        offsets = {str(name): tuple(rng.choice((0.0, 1e-9, 1.0, -40.0, 1e6), 3)) for name in names}
        values = dance_values(4) * rng.choice((0.0, 1.0, 1e4))
        try:
            clip = retarget(parse_values(values, offsets=offsets), name="strange")
        except ValueError:
            continue
        clips += 1
        assert np.isfinite(clip.root_position).all()
        np.testing.assert_allclose(np.linalg.norm(clip.rotation, axis=-1), 1.0, atol=1e-5)
    assert clips > 10


def test_adjacent_quaternions_have_equal_signs() -> None:
    clip = retarget(parse_values(dance_values(600)), name="dance")
    assert (np.sum(clip.rotation[1:] * clip.rotation[:-1], axis=-1) > 0.0).all()
    assert not clip.rotation.flags.writeable


@pytest.mark.shared
@mostly_long("name", REAL, quick=[0, 8])
def test_limb_directions_match_recordings(name: str) -> None:
    motion, how = mocap_motion(name), REAL[name]
    rate = float(how.get("fps", motion.header_fps))
    clip = retarget(motion, name=name, sample_rate=rate, **how)  # type: ignore[arg-type]
    body = find_body(motion)
    world, up = standing_pose(motion, body, None)
    source = world.positions[int(how.get("drop_frames", 0)) :]
    if up == "Z":
        source = np.stack((source[..., 0], source[..., 2], -source[..., 1]), axis=-1)
    ours = positions_of(clip)
    for joint, child in LIMBS:
        if body.joints[child] is not None:
            expected = bone_directions(source, body.joint(joint), body.joint(child))
            found = bone_directions(ours, SKELETON.index(joint), SKELETON.index(child))
            np.testing.assert_allclose(found, expected[: len(found)], atol=1e-3)


@pytest.mark.shared
@mostly_long("name", [name for name in REAL if "styled" not in name], quick=[0, 7])
def test_feet_stand_on_floor_without_added_slide(name: str) -> None:
    motion, how = mocap_motion(name), REAL[name]
    rate = float(how.get("fps", motion.header_fps))
    clip = retarget(motion, name=name, sample_rate=rate, **how)  # type: ignore[arg-type]
    positions = positions_of(clip)
    world, up = standing_pose(motion, body := find_body(motion), None)
    source = world.positions[int(how.get("drop_frames", 0)) :]
    if up == "Z":
        source = np.stack((source[..., 0], source[..., 2], -source[..., 1]), axis=-1)
    scale = 0.805 / np.mean([
        np.linalg.norm(source[0, body.joint("left" + b)] - source[0, body.joint("left" + a)])
        + np.linalg.norm(source[0, body.joint("left" + c)] - source[0, body.joint("left" + b)])
        for a, b, c in [("UpperLeg", "LowerLeg", "Foot")]
    ])  # fmt: skip
    ankles, toes = (positions[:, [SKELETON.index(s + j) for s in ("left", "right")]] for j in ("Foot", "Toes"))
    soles = np.minimum(ankles[..., 1] - 0.085, toes[..., 1] - 0.02)[clip.contact]
    assert 0.2 < clip.contact.mean() < 1.0
    assert abs(np.median(soles)) < 0.035
    assert np.percentile(soles, 95) < 0.06
    both = clip.contact[1:] & clip.contact[:-1]
    recorded = scale * source[:, [body.joint(s + "Foot") for s in ("left", "right")]]
    slides = [np.linalg.norm(np.diff(p, axis=0)[..., [0, 2]], axis=-1)[both].mean() * rate for p in (ankles, recorded)]
    assert slides[0] < slides[1] + 0.06


@pytest.mark.shared
def test_same_motion_in_two_files_gives_same_clip() -> None:
    """131_01 in the CMU unit and in meters (one frame longer at the end)."""
    one = retarget(mocap_motion("walk/131_01_styled.bvh"), name="a", fps=120.0)
    two = retarget(mocap_motion("walk/131_01_styled_metres.bvh"), name="b", fps=120.0)
    count = min(one.sample_count, two.sample_count)
    np.testing.assert_allclose(positions_of(one)[:count], positions_of(two)[:count], atol=0.003)


@pytest.mark.shared
def test_drifting_recording_is_lowered_to_floor() -> None:
    clip = retarget(mocap_motion("solo/rokoko_jesse_dance.bvh"), name="jesse")
    positions = positions_of(clip)
    soles = positions[:, [SKELETON.index("leftFoot"), SKELETON.index("rightFoot")], 1].min(axis=1) - 0.085
    assert np.median(soles) < 0.16


def test_standing_hip_height_matches_engine_legs() -> None:
    clip = retarget(parse_values(still(2)), name="still")
    assert clip.root_position[0, 1] == pytest.approx(0.935, abs=0.002)
    assert pytest.approx(94.0) == STANDING_CM
