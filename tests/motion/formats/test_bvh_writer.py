"""Tests of the BVH writer: read back by pybvh and by the engine, and checked against Blender's importer rules."""

import warnings
from pathlib import Path

import numpy as np
import pybvh
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from live.motion.clip import Clip
from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.bvh_writer import smooth_angles, write_bvh, zxy_angles
from live.motion.formats.source_motion import LocalPose, world_pose
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.retarget import retarget
from live.motion.skeleton import BODY_HEIGHT, BONE_TIPS, JOINT_COUNT, SKELETON
from tests.fixtures.mocap import mocap_motion
from tests.motion.test_clip import made_clip

ANGLES = st.floats(-7.0, 7.0)


def positions(clip: Clip) -> np.ndarray:
    return forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))[0]


def read_with_pybvh(text: str, folder: Path) -> tuple[pybvh.Bvh, np.ndarray]:
    path = folder / "written.bvh"
    path.write_text(text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # it wonders which way is up where a random pose stands
        motion = pybvh.read_bvh_file(path)
    return motion, 0.01 * np.asarray(motion.joint_positions())


def test_pybvh_reads_joints_within_hundredth_of_millimeter(tmp_path: Path) -> None:
    clip = made_clip(40, 60.0)
    motion, found = read_with_pybvh(write_bvh(clip), tmp_path)
    assert tuple(motion.joint_names) == SKELETON.names
    assert motion.frame_time == pytest.approx(1 / 60, abs=1e-9)
    np.testing.assert_allclose(found, positions(clip), atol=1e-5)


def test_engine_reads_clip_back_unchanged() -> None:
    clip = made_clip(40, 60.0)
    text = write_bvh(clip)
    parsed = parse_bvh(text.encode(), "written.bvh")
    assert set(parsed.channels[1:]) == {"ZXY"}
    assert parsed.channels[0] == "xyzZXY"
    motion = bvh_to_source_motion(parsed, None)
    assert (motion.names, motion.frame_count, motion.frames_declared) == (SKELETON.names, 40, 40)
    assert motion.root_offset == "zero"
    found = world_pose(motion.parents, LocalPose(motion.translation, motion.rotation)).positions
    np.testing.assert_allclose(0.01 * found, positions(clip), atol=1e-5)


@pytest.mark.shared
def test_recording_survives_round_trip() -> None:
    clip = retarget(mocap_motion("salsa/60_01.bvh"), name="salsa", fps=60.0)
    motion = bvh_to_source_motion(parse_bvh(write_bvh(clip).encode(), "written.bvh"), None)
    np.testing.assert_allclose(positions(retarget(motion, name="again")), positions(clip), atol=1e-5)


def test_rate_is_sixty_or_clip_rate() -> None:
    clip = made_clip(121, 120.0)
    sixty = write_bvh(clip).splitlines()
    assert "Frames: 61" in sixty
    own = write_bvh(clip, rate=None).splitlines()
    assert "Frames: 121" in own
    assert "Frame Time: 0.008333333333" in own
    assert sixty[-1].split()[:3] == own[-1].split()[:3]


def test_bones_have_length_and_root_offset_is_zero() -> None:
    """Blender's importer drops bones under 1e-3 units; a bone ends at the mean of the joint's children or End Site."""
    parsed = parse_bvh(write_bvh(made_clip(2, 60.0)).encode(), "written.bvh")
    assert not parsed.offsets[0].any()
    for joint in range(JOINT_COUNT):
        children = [parsed.offsets[n] for n in np.flatnonzero(parsed.parents == joint)]
        ends = [parsed.end_offsets[n] for n in np.flatnonzero(parsed.end_parents == joint)]
        assert len(ends) == (0 if children else 1)
        assert np.linalg.norm(np.mean(children + ends, axis=0)) > 0.1
        assert joint == 0 or np.linalg.norm(parsed.offsets[joint]) > 1.0
    assert all(" " not in name for name in parsed.names)


def test_bone_tips_end_at_body_surface() -> None:
    rest = SKELETON.rest_positions()
    ends = {SKELETON.names[joint]: rest[joint] + tip for joint, tip in BONE_TIPS.items()}
    assert ends["head"][1] == pytest.approx(BODY_HEIGHT, abs=1e-5)
    assert all(0.0 <= ends[side + "Toes"][1] < 0.03 for side in ("left", "right"))
    np.testing.assert_allclose(ends["leftHand"] * (-1, 1, 1), ends["rightHand"], atol=1e-6)
    assert set(BONE_TIPS) == set(range(JOINT_COUNT)) - set(SKELETON.parents.tolist())


@given(ANGLES, ANGLES, ANGLES)
def test_angles_match_matrix_product(z: float, x: float, y: float) -> None:
    turn = Rotation.from_euler("ZXY", (z, x, y))
    found = zxy_angles(turn.as_quat()[[3, 0, 1, 2]])
    assert abs(found[1]) <= np.pi / 2 + 1e-9
    assert (Rotation.from_euler("ZXY", found) * turn.inv()).magnitude() < 1e-6


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_angles_at_gimbal_lock_keep_rotation(sign: float) -> None:
    for z, y in ((0.3, 1.1), (-2.0, 0.4), (3.0, 3.0)):
        turn = Rotation.from_euler("ZXY", (z, sign * np.pi / 2, y))
        found = zxy_angles(turn.as_quat()[[3, 0, 1, 2]])
        assert (Rotation.from_euler("ZXY", found) * turn.inv()).magnitude() < 1e-6


@given(st.lists(st.tuples(ANGLES, ANGLES, ANGLES), min_size=1, max_size=12))
def test_smoothing_keeps_rotations_and_bounds_steps(triples: list[tuple[float, float, float]]) -> None:
    turns = Rotation.from_euler("ZXY", np.array(triples))
    plain = zxy_angles(turns.as_quat()[:, [3, 0, 1, 2]])
    smooth = smooth_angles(plain[:, None])[:, 0]
    assert (Rotation.from_euler("ZXY", smooth) * turns.inv()).magnitude().max() < 1e-6
    assert (np.abs(np.diff(smooth, axis=0)) <= np.pi + 1e-9).all()


def test_spins_and_full_bends_give_smooth_channels() -> None:
    """Through whole turns, and through straight down, the channels change evenly."""
    way = np.linspace(0.0, 6.0 * np.pi, 200)
    still = np.full(200, 0.1)
    for angles in ((still, 0.3 * np.sin(way), way), (still, way, still), (way, still, 0.0 * still)):
        turns = Rotation.from_euler("ZXY", np.stack(angles, axis=1))
        smooth = smooth_angles(zxy_angles(turns.as_quat()[:, [3, 0, 1, 2]])[:, None])
        assert np.abs(np.diff(smooth, axis=0)).max() < 0.2
