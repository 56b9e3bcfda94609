"""Tests of Acclaim files: an independent reader, the CMU BVH convention, and errors that name the line."""

import re

import numpy as np
import pytest

from live.bridges.acclaim.acclaim_motion import parse_amc
from live.bridges.acclaim.acclaim_skeleton import AcclaimSkeleton, parse_asf
from live.motion import quaternion
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_axes import body_height, find_unit, leg_length, standing_pose
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.joint_mapping import find_body, map_joints
from live.motion.retarget.retarget import retarget
from tests.fixtures.mocap import mocap_file, mocap_motion
from tests.fixtures.mostly_long import mostly_long

ASF = """# a comment
:version 1.10
:name TEST
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
   words: begin end
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name thigh
     direction 0 -1 0
     length 7
     axis 0 0 20  XYZ
     dof rx ry rz
     limits (-160.0 20.0)
            (-70.0 70.0)
            (-60.0 70.0)
  end
  begin
     name shin
     direction 0 -1 0
     length 8e0
     axis 0 0 20 XYZ
     dof rx
  end
  begin
     name stiff
     direction 1 0 0
     length 2
  end
:hierarchy
  begin
    root thigh stiff
    thigh shin
  end
"""
AMC = """#!OML:ASF test.ASF
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 0 90 0
thigh 10 0 0
shin 90
2
root 1 2 3 0 0 0
thigh 0 0 0
shin 0
"""
FILES = ("49_10", "49_11", "49_12", "49_14")
SIDES = ("l", "r")


def small_asf() -> AcclaimSkeleton:
    return parse_asf(ASF.encode(), "test.asf")


def cmu_motion(name: str) -> SourceMotion:
    skeleton = parse_asf(mocap_file("asfamc/49.asf").read_bytes(), "49.asf")
    return parse_amc(mocap_file(f"asfamc/{name}.amc").read_bytes(), f"{name}.amc", skeleton)


def test_skeleton_file_is_parsed() -> None:
    skeleton = small_asf()
    assert skeleton.names == ("root", "thigh", "shin", "stiff")
    assert skeleton.parents.tolist() == [-1, 0, 1, 0]
    assert skeleton.offsets.tolist() == [[0, 0, 0], [0, 0, 0], [0, -7, 0], [0, 0, 0]]
    assert skeleton.end_parents.tolist() == [2, 3]
    assert skeleton.end_offsets.tolist() == [[0, -8, 0], [2, 0, 0]]
    assert skeleton.channels == ("xyzXYZ", "XYZ", "X", "")
    assert skeleton.unit_m == pytest.approx(0.056444, abs=1e-6)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_motion_file_is_parsed_with_any_line_end(end: str) -> None:
    motion = parse_amc(AMC.replace("\n", end).encode(), "x.amc", small_asf())
    assert (motion.frame_count, motion.joint_count, motion.channel_count) == (2, 4, 10)
    assert motion.header_fps == 120.0
    assert "does not state its frame rate" in motion.warnings[0].what
    assert motion.translation[:, 0].tolist() == [[1, 2, 3], [1, 2, 3]]
    assert motion.root_offset == "zero"
    np.testing.assert_allclose(motion.rotation[1], [(1, 0, 0, 0)] * 4, atol=1e-15)
    np.testing.assert_allclose(motion.rotation[0, 0], (np.sqrt(0.5), 0, np.sqrt(0.5), 0), atol=1e-15)
    hinge = np.array((np.cos(np.radians(20)), np.sin(np.radians(20)), 0.0))
    np.testing.assert_allclose(motion.rotation[0, 2], [np.sqrt(0.5), *(np.sqrt(0.5) * hinge)], atol=1e-15)


def test_radians_and_frame_rate_are_read() -> None:
    text = AMC.replace(":DEGREES", ":RADIANS\n:SAMPLES-PER-SECOND 60").replace("90", str(np.pi / 2))
    text = text.replace("thigh 10", f"thigh {np.pi / 18}")
    motion = parse_amc(text.encode(), "x", small_asf())
    np.testing.assert_allclose(motion.rotation, parse_amc(AMC.encode(), "x", small_asf()).rotation, atol=1e-15)
    assert motion.header_fps == pytest.approx(60.0)
    assert motion.warnings == ()


def test_bone_order_within_frame_does_not_matter() -> None:
    text = AMC.replace("thigh 10 0 0\nshin 90\n", "shin 90\nthigh 10 0 0\n")
    np.testing.assert_array_equal(
        parse_amc(text.encode(), "x", small_asf()).rotation, parse_amc(AMC.encode(), "x", small_asf()).rotation
    )


def test_missing_frames_give_warning_with_line() -> None:
    warning = parse_amc(AMC.replace("\n2\n", "\n7\n").encode(), "x", small_asf()).warnings[0]
    assert (warning.what, warning.line) == ("frame 7 comes after 1: the frames between are missing", 8)


def rows_matrix(x: float, y: float, z: float) -> np.ndarray:
    """3x3 matrix for row vectors: v M turns v about x, then y, then z [degrees]."""
    (a, b, c), (d, e, f) = np.cos(np.radians((x, y, z))), np.sin(np.radians((x, y, z)))
    about_x = np.array(((1, 0, 0), (0, a, d), (0, -d, a)))
    about_y = np.array(((b, 0, -e), (0, 1, 0), (e, 0, b)))
    about_z = np.array(((c, f, 0), (-f, c, 0), (0, 0, 1)))
    return np.asarray(about_x @ about_y @ about_z)


def bone_ends_by_formula(asf: str, amc: str, frame: int) -> dict[str, np.ndarray]:
    """Bone end positions in one frame (from 0) by the CMU formula: L = C⁻¹ M C B in row vectors, root first."""
    bones, children = {}, {}
    for block in asf.split("begin")[1:]:
        words = {line.split()[0]: line.split()[1:] for line in block.splitlines() if line.split()}
        if "name" in words:
            direction = np.array([float(x) for x in words["direction"]]) * float(words["length"][0])
            bones[words["name"][0]] = (direction, [float(x) for x in words["axis"][:3]], words.get("dof", []))
        elif "root" in words:
            children = words
    lines = amc.split("\n")
    start = lines.index(str(frame + 1))
    data = {w[0]: [float(x) for x in w[1:]] for w in (line.split() for line in lines[start + 1 : start + 30])}
    ends: dict[str, np.ndarray] = {}

    def go(name: str, place: np.ndarray, above: np.ndarray) -> None:
        direction, axis, dof = bones[name]
        angles = dict(zip(dof, data.get(name, []), strict=True))
        c = rows_matrix(*axis)
        m = rows_matrix(*(angles.get(key, 0.0) for key in ("rx", "ry", "rz")))
        whole = np.linalg.inv(c) @ m @ c @ above
        ends[name] = place + direction @ whole
        for child in children.get(name, []):
            go(child, ends[name], whole)

    for child in children["root"]:
        go(child, np.array(data["root"][:3]), rows_matrix(*data["root"][3:]))
    return ends


@pytest.mark.shared
@mostly_long("name", FILES, quick=[3])
def test_bone_ends_match_cmu_formula(name: str) -> None:
    motion = cmu_motion(name)
    world, _ = standing_pose(motion, find_body(motion), None)
    asf, amc = (mocap_file(f"asfamc/{n}").read_text() for n in ("49.asf", f"{name}.amc"))
    for frame in (0, 1, motion.frame_count // 2, motion.frame_count - 1):
        ends = bone_ends_by_formula(asf, amc, frame)
        for joint in range(1, motion.joint_count):
            parent = motion.parents[joint]
            if parent > 0:
                np.testing.assert_allclose(world.positions[frame, joint], ends[motion.names[parent]], atol=1e-9)


@pytest.mark.shared
@mostly_long("name", FILES, quick=[3])
def test_body_of_subject_49_is_measured(name: str) -> None:
    motion = cmu_motion(name)
    text = mocap_file(f"asfamc/{name}.amc").read_text()
    assert motion.frame_count == len(re.findall(r"(?m)^\d+\s*$", text))
    assert (motion.joint_count, motion.end_parents.size, motion.channel_count) == (31, 7, 62)
    body = find_body(motion)
    assert body.missing == ()
    world, up = standing_pose(motion, body, None)
    leg = leg_length(body, world.positions)
    assert up == "Y"
    assert motion.unit_m is not None
    assert motion.unit_m == pytest.approx(find_unit(leg))
    assert 1.6 < body_height(leg) * motion.unit_m < 1.9
    lowest = world.positions[..., 1].min(axis=1) * motion.unit_m
    assert 0.02 < np.percentile(lowest, 5) < 0.04
    assert np.ptp(lowest) < 0.04
    clip = retarget(motion, name=name)
    assert clip.seconds == pytest.approx((motion.frame_count - 1) / 120.0, abs=0.02)
    assert clip.contact.any(axis=1).mean() > 0.9


@pytest.mark.shared
def test_acclaim_joints_are_mapped() -> None:
    found = map_joints(cmu_motion("49_14"))
    expected = "root lowerback upperback thorax lowerneck head"
    assert [found[name] for name in ("hips", "spine", "chest", "upperChest", "neck", "head")] == expected.split()
    limbs = ["Shoulder", "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toes"]
    for side in ("left", "right"):
        bones = ["clavicle", "humerus", "radius", "hand", "femur", "tibia", "foot", "toes"]
        assert [found[side + limb] for limb in limbs] == [side[0] + bone for bone in bones]


def turn_axes(rotation: np.ndarray, least: float) -> np.ndarray:
    """Unit axes, on the side of +x, of the rotations (T, 4) that exceed `least` degrees."""
    axes = rotation[:, 1:] * np.sign(rotation[:, :1])
    axes = axes[np.linalg.norm(axes, axis=-1) > np.sin(np.radians(least / 2))]
    return np.asarray(quaternion.unit(axes) * np.sign(axes[:, :1]))


@pytest.mark.shared
@mostly_long("file", ["walk/cmu_12_01_walk.bvh", "solo/modern05/05_09.bvh"], quick=[0])
def test_legs_match_cmu_bvh_files(file: str) -> None:
    """The same unit, rest directions and knee axes: a BVH joint's rotation is the C M C⁻¹ of the Acclaim bone."""
    ours, theirs = cmu_motion("49_10"), mocap_motion(file)
    for side, name in (("l", "Left"), ("r", "Right")):
        for bones, joints in ((("femur", "tibia"), ("UpLeg", "Leg")), (("tibia", "foot"), ("Leg", "Foot"))):
            here = ours.offsets[ours.names.index(side + bones[1])]
            there = theirs.offsets[theirs.names.index(name + joints[1])]
            np.testing.assert_allclose(quaternion.unit(here), quaternion.unit(there), atol=2e-4)
            assert np.linalg.norm(here) == pytest.approx(np.linalg.norm(there), rel=0.25)
        knees = [
            turn_axes(motion.rotation[:, motion.names.index(joint)], 10.0)
            for motion, joint in ((ours, side + "tibia"), (theirs, name + "Leg"))
        ]
        sign = 1.0 if side == "l" else -1.0
        for axes in knees:
            assert len(axes) > 20
            np.testing.assert_allclose(
                axes.mean(axis=0), (np.cos(np.radians(20)), sign * np.sin(np.radians(20)), 0), atol=0.01
            )


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("# a comment\n:version 1.10", "hello", 1, "an ASF file begins with :version"),
        (":units", ":root\n:root", 5, "a second :root"),
        ("length 0.45", "length 0", 6, "a scale over zero"),
        ("length 0.45", "length", 6, "0 numbers after 'length'; 1 expected"),
        ("angle deg", "angle grad", 7, "deg or rad"),
        ("order TX TY TZ", "order TX TX TZ", 11, "each once"),
        ("order TX TY TZ", "order QX TY TZ", 11, "tx ty tz rx ry rz"),
        ("   axis XYZ", "   axis XXZ", 12, "as in XYZ"),
        ("orientation 0 0 0", "orientation 0 0 nan", 14, "'nan' as orientation is not a number"),
        ("  begin\n     id 1", "     id 1", 16, "'begin' of a bone expected"),
        ("name shin", "name thigh", 28, "names no other bone"),
        ("     name shin\n", "", 32, "the bone begun in line 27 has no name"),
        ("length 8e0", "length 8e9", 30, "at most 1e7"),
        ("direction 1 0 0", "direction 1 0", 36, "2 numbers after 'direction'; 3 expected"),
        ("length 2\n  end", "length 2", 38, "within bone 'stiff'; 'end' expected"),
        ("length 2\n  end\n", "length 2\n  begin\n", 38, "'begin' was read within a bone"),
        ("thigh shin\n", "thigh shin knee\n", 42, "'knee' is no bone"),
        ("thigh shin\n", "thigh shin\n    stiff shin\n", 43, "'shin' has two parents"),
        ("    root thigh stiff\n", "    root thigh\n", 43, "'stiff' is not connected to the root"),
        ("    root thigh stiff\n    thigh shin", "    thigh shin\n    shin thigh", 43, "is not connected to the root"),
        (":hierarchy", ":anything", 43, "no :hierarchy up to the end"),
        ("  begin\n    root", "  start\n    root", 40, "'start' stands alone"),
    ],
)
def test_broken_skeleton_error_names_line(old: str, new: str, line: int, words: str) -> None:
    assert old in ASF
    with pytest.raises(MotionFileError, match=re.escape(words)) as caught:
        parse_asf(ASF.replace(old, new, 1).encode(), "test.asf")
    assert caught.value.line == line
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("1\nroot", "root", 4, "the number of the first frame expected"),
        ("1\nroot", "one\nroot", 4, "'one' was read"),
        ("shin 90\n2", "shin 90\n1", 8, "frame 1 after frame 1; 2 expected"),
        ("shin 90\n", "", 7, "frame 1 holds nothing for 'shin'"),
        ("shin 0\n", "", 10, "the file is cut off: frame 2 holds nothing for 'shin'"),
        ("shin 90\n", "shin 90\nshin 90\n", 8, "'shin' twice in frame 1"),
        ("shin 90", "shin 90 1", 7, "2 numbers for 'shin'; 1 (one per 'dof')"),
        ("shin 90", "shin x", 7, "'x' as an angle of shin is not a number"),
        ("shin 90", "shin nan", 7, "'nan' as an angle"),
        ("shin 90", "shin 1_0", 7, "'1_0' as an angle"),
        ("shin 90", "shin -2e7", 7, "at most 1e7"),
        ("shin 90", "knee 90", 7, "'knee' is no bone of the skeleton; root, thigh, shin, ... expected"),
        ("shin 90", "stiff 90", 7, "'stiff' cannot move"),
        ("shin 90", ":DEGREES", 7, "was read among the frames"),
        (":DEGREES", ":SAMPLES-PER-SECOND 0", 3, "0.1 to 10000 expected"),
        (AMC[AMC.index("1\n") :], "", 3, "no frames"),
    ],
)
def test_broken_motion_error_names_line(old: str, new: str, line: int, words: str) -> None:
    assert old in AMC
    with pytest.raises(MotionFileError, match=re.escape(words)) as caught:
        parse_amc(AMC.replace(old, new, 1).encode(), "test.amc", small_asf())
    assert caught.value.line == line


def test_skeleton_without_dof_and_overlong_line_are_refused() -> None:
    with pytest.raises(MotionFileError, match="no bone of the skeleton has 'dof'"):
        parse_amc(AMC.encode(), "x", parse_asf(re.sub(r"dof.*|order.*", "", ASF).encode(), "x"))
    with pytest.raises(MotionFileError, match="a line of 200001 letters"):
        parse_amc(b"1" * 200_001, "x", small_asf())
