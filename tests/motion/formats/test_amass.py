"""Tests of AMASS archives: known rotations, all layouts, errors that name the problem, and zip bombs."""

import io
import random
import time
import tracemalloc
import zipfile

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from live.motion.formats.amass import NAMES, STATURE, parse_amass
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_motion import LocalPose, world_pose
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.joint_mapping import map_joints
from live.motion.retarget.retarget import retarget
from live.motion.skeleton import SKELETON
from tests.motion.formats.test_bvh_fuzz import attempt


def pack_npz(*, compress: bool = False, **arrays: object) -> bytes:
    stream = io.BytesIO()
    (np.savez_compressed if compress else np.savez)(stream, **arrays)
    return stream.getvalue()


def upright_arrays(frames: int, width: int = 156, dtype: type = np.float64) -> dict[str, object]:
    """A body upright in the T-pose, facing -y of the Z-up world, pelvis 0.98 m high."""
    poses, trans = np.zeros((frames, width), dtype), np.zeros((frames, 3), dtype)
    poses[:, 0] = np.pi / 2
    trans[:, 2] = 0.98
    return {"poses": poses, "trans": trans, "mocap_framerate": 120.0, "gender": "female", "betas": np.zeros(16)}


def test_known_rotations_are_read_back() -> None:
    rng = np.random.default_rng(1)
    arrays = upright_arrays(20)
    arrays["poses"] = 2.0 * rng.normal(size=(20, 156))
    arrays["trans"] = rng.normal(size=(20, 3))
    motion = parse_amass(pack_npz(**arrays), "made.npz")
    assert (motion.joint_count, motion.frame_count, motion.header_fps) == (22, 20, 120.0)
    assert (motion.unit_m, motion.up, motion.warnings) == (1.0, "Z", ())
    expected = Rotation.from_rotvec(arrays["poses"][:, :66].reshape(-1, 3))
    got = Rotation.from_quat(motion.rotation.reshape(-1, 4)[:, [1, 2, 3, 0]])
    assert (got * expected.inv()).magnitude().max() < 1e-7
    np.testing.assert_array_equal(motion.translation[:, 0], arrays["trans"])


def test_offset_table_is_upright_adult_in_t_pose() -> None:
    motion = parse_amass(pack_npz(**upright_arrays(1)), "made.npz")
    at = world_pose(motion.parents, LocalPose(motion.translation, motion.rotation)).positions[0]
    place = dict(zip(NAMES, at, strict=True))
    assert place["left_wrist"][0] > 0.6  # left at +x, facing -y, z up
    assert place["left_foot"][1] < -0.1
    ankle = place["left_ankle"][2]
    assert 0.02 * STATURE < ankle < 0.07 * STATURE
    assert 0.88 * STATURE < place["head"][2] - ankle + 0.039 * STATURE < 0.96 * STATURE
    for name in NAMES:
        if name.startswith("left"):
            np.testing.assert_allclose(place[name.replace("left", "right")], place[name] * (-1, 1, 1), atol=1e-12)
    rest = world_pose(motion.parents, LocalPose(motion.offsets[None], motion.rest_rotation[None])).positions[0]
    np.testing.assert_allclose(rest - rest[0], at - at[0], atol=1e-9)


def test_all_joints_are_mapped_and_motion_is_retargeted() -> None:
    arrays = upright_arrays(240)
    swing = 0.8 * np.sin(np.linspace(0.0, 4.0 * np.pi, 240))
    column = 3 * NAMES.index("left_elbow") + 1
    arrays["poses"][:, column] = swing - 0.8
    arrays["trans"][:, 1] = -np.linspace(0.0, 1.0, 240)
    motion = parse_amass(pack_npz(**arrays), "made.npz")
    assert None not in map_joints(motion).values()
    clip = retarget(motion, name="made")
    positions, _ = forward_kinematics(clip.root_position, clip.rotation)
    bend = Rotation.from_quat(clip.rotation[:, SKELETON.index("leftLowerArm")][:, [1, 2, 3, 0]]).magnitude()
    np.testing.assert_allclose(bend, np.abs(swing[::2] - 0.8), atol=1e-3)
    travelled = positions[-1, 0] - positions[0, 0]
    assert travelled[2] == pytest.approx(1.0, abs=0.1)  # -y is ahead, and ahead is +z here; legs are nearly as long
    assert np.abs(travelled[:2]).max() < 1e-3
    assert positions[0, SKELETON.index("leftHand"), 0] > 0.5


@pytest.mark.parametrize("width", [66, 72, 156, 165])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("compress", [False, True])
def test_all_pose_layouts_give_same_body(width: int, dtype: type, compress: bool) -> None:
    arrays = upright_arrays(6, width, dtype)
    arrays["mocap_frame_rate"] = np.array(arrays.pop("mocap_framerate"))
    motion = parse_amass(pack_npz(compress=compress, **arrays), "made.npz")
    assert motion.header_fps == 120.0
    np.testing.assert_allclose(motion.rotation[3, 0], (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0), atol=1e-7)


def test_smplx_parts_and_missing_translation_are_accepted() -> None:
    arrays = upright_arrays(6)
    whole = parse_amass(pack_npz(**arrays), "made.npz")
    poses = arrays.pop("poses")
    parts = {"root_orient": poses[:, :3], "pose_body": poses[:, 3:66]}
    np.testing.assert_array_equal(parse_amass(pack_npz(**arrays, **parts), "made.npz").rotation, whole.rotation)
    del arrays["trans"]
    motion = parse_amass(pack_npz(**arrays, **parts), "made.npz")
    assert "stays in place" in motion.warnings[0].what


def member(name: str, content: bytes, *, claims: int | None = None) -> bytes:
    """An archive of one member, whose directory may state a wrong size."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
    data = bytearray(stream.getvalue())
    if claims is not None:
        entry = data.index(b"PK\1\2")
        data[entry + 24 : entry + 28] = claims.to_bytes(4, "little")
    return bytes(data)


def header(text: str) -> bytes:
    return b"\x93NUMPY\1\0" + len(text).to_bytes(2, "little") + text.encode()


def changed_npz(**changes: object) -> bytes:
    return pack_npz(**{**upright_arrays(4), **changes})


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "no zip archive"),
        (b"PK\3\4" + bytes(50), "no zip archive"),
        (changed_npz()[:-100], "no zip archive"),
        (pack_npz(a=np.zeros(3)), "no array 'poses' among a"),
        (changed_npz(poses=np.zeros((4, 100))), r"poses has the shape \(4, 100\); \(frames, 66 or 72"),
        (changed_npz(poses=np.zeros(4)), r"poses has the shape \(4,\)"),
        (changed_npz(poses=np.zeros((0, 156)), trans=np.zeros((0, 3))), "no frames"),
        (changed_npz(poses=np.array([["x"] * 156])), "poses has the type '<U1'; an array of numbers"),
        (changed_npz(poses=np.array([{}], object)), "type 'object'"),
        (changed_npz(poses=np.zeros((4, 156), complex)), "type 'complex128'"),
        (changed_npz(poses=np.full((4, 156), np.nan)), "frame 0 of poses"),
        (changed_npz(trans=np.full((4, 3), np.inf)), "frame 0 of trans"),
        (changed_npz(trans=np.zeros((3, 3))), r"trans has the shape \(3, 3\); \(4, 3\) expected"),
        (changed_npz(mocap_framerate=np.zeros(2)), "one number expected"),
        (changed_npz(mocap_framerate=0.0), "mocap_framerate is 0"),
        (changed_npz(mocap_framerate=np.nan), "mocap_framerate is nan"),
        (
            pack_npz(poses=np.zeros((4, 156)), trans=np.zeros((4, 3))),
            "no frame rate; one number called mocap_framerate",
        ),
        (member("poses.npy", b"nothing"), "poses is no NumPy array"),
        (member("poses.npy", header("{'descr': '<f8', 'shape': (1000000000000, 156)}\n")), "poses is no NumPy array"),
        (
            member("poses.npy", header("{'descr': '<f8', 'fortran_order': False, 'shape': (10**12, 156)}\n")),
            "poses is no NumPy array",
        ),
        (
            member("poses.npy", header("{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 156), }\n")),
            "says 156000000000000 numbers of 8 bytes and holds 0 bytes",
        ),
        (
            member("poses.npy", header("{'descr': '<f8', 'fortran_order': False, 'shape': (-1, -156), }\n") + bytes(8)),
            "says 156 numbers",
        ),
        (member("poses.npy", bytes(100_000_000)), "100000000 bytes unpacked; at most"),
        (member("poses.npy", bytes(1000), claims=900_000_000), "900000000 bytes unpacked"),
    ],
)
def test_broken_archive_error_names_problem(data: bytes, message: str) -> None:
    with pytest.raises(MotionFileError, match=message) as raised:
        parse_amass(data, "broken.npz")
    assert str(raised.value).startswith("broken.npz: ")
    assert len(str(raised.value).splitlines()) == 1


@pytest.mark.parametrize(("frames", "width"), [(12_000, 66), (60_000, 66), (12_000, 165)])
def test_zip_bomb_of_zeros_takes_little_memory(frames: int, width: int) -> None:
    data = pack_npz(compress=True, **upright_arrays(frames, width, np.float32))
    assert len(data) < 200_000
    tracemalloc.start()
    start = time.process_time()
    motion, problem = attempt(lambda: parse_amass(data, "bomb.npz"))
    seconds, peak = time.process_time() - start, tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert motion is not None or isinstance(problem, MotionFileError)
    assert peak < 64e6 + 20 * len(data)
    assert seconds < 10.0


def test_valid_ten_minute_archive_stays_within_memory_limit() -> None:
    data = pack_npz(**upright_arrays(72_000, 66, np.float32))
    tracemalloc.start()
    motion = parse_amass(data, "long.npz")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert motion.frame_count == 72_000
    assert peak < 64e6 + 20 * len(data)


@pytest.mark.parametrize("seed", range(4))
def test_mutated_archive_gives_motion_or_error(seed: int) -> None:
    rng = random.Random(seed)
    whole = pack_npz(compress=seed % 2 == 1, **upright_arrays(5))
    outcomes = {"motion": 0, "error": 0}
    for _ in range(150):
        data = bytearray(whole)
        for _ in range(rng.randint(1, 4)):
            # half of the blows fall on the names, sizes and headers
            place = rng.randrange(len(data)) if rng.random() < 0.5 else data.find(b"PK", rng.randrange(len(data)))
            data[min(max(place, 0) + rng.randrange(60), len(data) - 1)] = rng.randrange(256)
        if rng.random() < 0.2:
            del data[rng.randrange(len(data)) :]
        motion, problem = attempt(lambda data=data: parse_amass(bytes(data), "fuzz.npz"))
        if motion is None:
            outcomes["error"] += 1
            assert isinstance(problem, MotionFileError)
            assert len(str(problem).splitlines()) == 1
        else:
            outcomes["motion"] += 1
            assert np.isfinite(motion.translation).all()
            np.testing.assert_allclose(np.linalg.norm(motion.rotation, axis=-1), 1.0, atol=1e-9)
    assert min(outcomes.values()) > 5, outcomes
