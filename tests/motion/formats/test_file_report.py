"""Tests of the `live bvh` report: recordings against the index, and generated bodies against their parameters."""

import json
from functools import cache
from typing import Any

import numpy as np
import pytest

from live.library.motion_file import read_motion
from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.file_report import MotionReport, SourceTracks, analyze_motion
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.joint_mapping import find_body
from tests.fixtures.mocap import MOCAP, mocap_file, mocap_index
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_bvh import body_bvh, column, dance_values, still

ROWS = [row for row in mocap_index() if row.get("joints") is not None]
UNCLEAR = "edge/makehuman_benchmark_6and3.bvh"
"""One frame, whose lowest point the index takes with another reading of its position channels."""
SCALED = "edge/salsa_60_05_scaled.bvh"
"""In units of 1.28 m: nothing tells them from metres."""


def row_file(row: dict[str, Any]) -> str:
    return str(row["file"])


@cache
def read(name: str) -> SourceMotion:
    return read_motion(mocap_file(name))


@cache
def report_of(name: str) -> tuple[MotionReport, SourceTracks]:
    row = next((row for row in ROWS if row["file"] == name), {})
    return analyze_motion(read(name), fps=row.get("true_fps"))


@pytest.mark.shared
@mostly_long("row", ROWS, quick=range(0, len(ROWS), 3), ids=row_file)
def test_counts_match_index(row: dict[str, Any]) -> None:
    facts, tracks = report_of(row["file"])
    assert (facts.joints, facts.end_sites, facts.channels) == (row["joints"], row["end_sites"], row["channels"])
    assert facts.frames_declared == row["frames_declared"]
    assert facts.frames == row["frames"] + ("off_by_one" in row["file"])
    assert facts.header_fps == pytest.approx(row["header_fps"], rel=1e-3)
    assert facts.fps == pytest.approx(row.get("true_fps") or row["header_fps"], rel=1e-3)
    added = row["tpose_first_frame"] is True
    assert facts.seconds == pytest.approx(row["seconds"] + added / facts.fps, abs=0.02)
    assert tracks.positions.shape == (facts.frames, facts.joints, 3)
    assert np.isfinite(tracks.positions).all()


@pytest.mark.shared
@pytest.mark.parametrize("row", ROWS, ids=row_file)
def test_axes_unit_offset_and_t_pose_match_index(row: dict[str, Any]) -> None:
    facts, _ = report_of(row["file"])
    if row["joints"] > 4:
        assert facts.up == row["up_axis"] or row["up_axis"] is None
    if row["root_offset"] == "unclear":
        assert facts.root_offset is None
    elif row["joints"] > 4:
        assert facts.root_offset == {"none": "zero"}.get(row["root_offset"], row["root_offset"])
    assert facts.tpose_first == bool(row["tpose_first_frame"])
    if row["unit_cm"] is not None and row["file"] != SCALED:
        assert facts.unit_m == pytest.approx(row["unit_cm"] / 100.0, rel=1e-3)


@pytest.mark.shared
@pytest.mark.parametrize("row", [row for row in ROWS if row["file"] != UNCLEAR], ids=row_file)
def test_floor_height_matches_index(row: dict[str, Any]) -> None:
    facts, _ = report_of(row["file"])
    if facts.unit_m is None:
        assert facts.floor_m is None
        return
    expected = row["lowest_point"]["p5"] * facts.unit_m
    assert facts.floor_m == pytest.approx(expected, abs=0.001)


@pytest.mark.shared
@pytest.mark.parametrize("row", [row for row in ROWS if row.get("mean_speed_m_s")], ids=row_file)
def test_hip_travel_matches_mean_speed(row: dict[str, Any]) -> None:
    """The index has the smoothed mean speed to 0.01 m/s: the hips of a standing dancer tremble."""
    facts, _ = report_of(row["file"])
    assert facts.travel_m is not None
    scale = 1.28 if row["file"] == SCALED else 1.0
    expected = row["mean_speed_m_s"] * row["seconds"]
    assert expected * 0.98 - 0.005 * row["seconds"] < facts.travel_m * scale < expected * 1.03 + 0.04 * row["seconds"]


@pytest.mark.shared
@pytest.mark.parametrize("row", [row for row in ROWS if row["joints"] > 4], ids=row_file)
def test_body_heights_are_human(row: dict[str, Any]) -> None:
    facts, tracks = report_of(row["file"])
    if facts.unit_m is None:
        assert facts.height_m is None
        return
    assert facts.height_m is not None
    assert 1.3 < facts.height_m < 2.0
    drawn = np.ptp(tracks.positions[:, :, 1], axis=1)
    if row["frames"] > 50:
        assert 0.7 * facts.height_m < np.percentile(drawn, 95) < 1.1 * facts.height_m


@pytest.mark.shared
def test_initial_transition_of_salsa_is_reported() -> None:
    facts, _ = report_of("salsa/60_01.bvh")
    assert any("frames 1 to 5 a transition" in one.what and "drop_frames = 6" in one.what for one in facts.warnings)
    assert facts.travel_m == pytest.approx(14.4, abs=0.2)


@pytest.mark.shared
def test_equal_motions_match_across_units() -> None:
    """salsa_60_05_scaled is 60_05 in units of 1.28 m without its first frame; 131_01 exists in 5.644 cm and in m."""
    _, here = analyze_motion(read("salsa/60_05.bvh"), fps=60.0)
    _, there = analyze_motion(read(SCALED), fps=60.0, unit_m=1.28)
    assert here.names == there.names
    np.testing.assert_allclose(here.positions[1:], there.positions, atol=2e-4)
    one, two = report_of("walk/131_01_styled.bvh")[1], report_of("walk/131_01_styled_metres.bvh")[1]
    np.testing.assert_allclose(one.positions, two.positions[: len(one.positions)], atol=2e-4)


@pytest.mark.shared
def test_gltf_export_matches_bvh_of_dancer() -> None:
    """Blender's export: meters, the same keys at 30 instead of 40 frames per second."""
    bvh, gltf = report_of("group/perfume_aachan.bvh"), analyze_motion(read("group/perfume_aachan.glb"))
    assert (bvh[0].frames, bvh[0].fps) == (gltf[0].frames, pytest.approx(40.0, rel=1e-3))
    assert gltf[0].fps == pytest.approx(30.0, rel=1e-3)
    assert bvh[0].mapped == gltf[0].mapped
    order = [gltf[1].names.index(name) for name in bvh[1].names]
    np.testing.assert_allclose(gltf[1].positions[:, order], bvh[1].positions, atol=1e-4)
    assert (gltf[0].up, gltf[0].tpose_first) == (bvh[0].up, bvh[0].tpose_first)
    assert (gltf[0].height_m, gltf[0].travel_m) == pytest.approx((bvh[0].height_m, bvh[0].travel_m), rel=1e-3)


@pytest.mark.shared
def test_six_and_three_channels_give_same_motion() -> None:
    """Position channels that repeat OFFSET (six on every joint) change nothing: the same file with three each."""
    text = mocap_file("edge/six_channels_everywhere_geno_bind.bvh").read_text()
    motion = parse_bvh(text, "six")
    head, numbers = text.split("MOTION", 1)
    first, place = head.index("CHANNELS 6"), head.index("CHANNELS 6") + 10
    three = head[:place] + head[place:].replace("CHANNELS 6 Xposition Yposition Zposition", "CHANNELS 3")
    assert three.count("CHANNELS 3") == motion.joint_count - 1
    assert first > 0
    keep = [0, 1, 2] + [n for n in range(motion.values.shape[1]) if n % 6 > 2]
    rows = "\n".join(" ".join(map(repr, row)) for row in motion.values[:, keep].tolist())
    lines = numbers.splitlines()
    other = parse_bvh(f"{three}MOTION\n{lines[1]}\n{lines[2]}\n{rows}\n", "three")
    one, two = (analyze_motion(bvh_to_source_motion(each))[1].positions for each in (motion, other))
    np.testing.assert_allclose(one, two, atol=1e-5)


def parse_values(values: np.ndarray, **how: object) -> SourceMotion:
    return bvh_to_source_motion(parse_bvh(body_bvh(values, **how), "made.bvh"))  # type: ignore[arg-type]


def test_straight_walk_has_known_path_floor_and_height() -> None:
    """1.5 m to the left in a straight line at 94 cm: path, floor and height are the given ones."""
    values = still(91)
    values[:, 0] = np.linspace(0.0, 150.0, 91)
    for scale, unit in ((1.0, 0.01), (0.01, 1.0)):
        facts, tracks = analyze_motion(parse_values(values, scale=scale))
        assert (facts.joints, facts.end_sites, facts.channels, facts.frames) == (21, 5, 66, 91)
        assert facts.unit_m == pytest.approx(unit)
        assert facts.seconds == pytest.approx(91 / 60)
        assert facts.travel_m == pytest.approx(1.5)
        assert facts.floor_m == pytest.approx(0.94 - 0.04 - 0.82 - 0.06 - 0.3 * 0.06, abs=1e-6)
        assert facts.height_m == pytest.approx(0.82 / 0.805 * 1.7)
        assert facts.warnings == ()
        np.testing.assert_allclose(tracks.positions[-1, 0], (1.5, 0.94, 0.0), atol=1e-6)


def test_line_ends_and_axes_keep_positions() -> None:
    text = body_bvh(dance_values(120))
    lf, crlf = (bvh_to_source_motion(parse_bvh(each.encode(), "x")) for each in (text, text.replace("\n", "\r\n")))
    np.testing.assert_array_equal(analyze_motion(lf)[1].positions, analyze_motion(crlf)[1].positions)
    facts, tracks = analyze_motion(lf, fps=30.0)
    assert (facts.header_fps, facts.fps, facts.seconds) == (pytest.approx(60.0), 30.0, 4.0)
    standing = analyze_motion(parse_values(dance_values(120), z_up=True))
    assert standing[0].up == "Z"
    np.testing.assert_allclose(standing[1].positions, tracks.positions, atol=1e-4)


def test_unknown_facts_are_null_and_reported() -> None:
    text = "HIERARCHY\nROOT base { OFFSET 0 5 0 CHANNELS 4 Xposition Yposition Zposition Xrotation }\n"
    motion = bvh_to_source_motion(parse_bvh(f"{text}MOTION\nFrames: 1\nFrame Time: 1\n1 2 3 4\n", "x"))
    facts, tracks = analyze_motion(motion)
    assert (facts.unit_m, facts.up, facts.root_offset) == (None, None, None)
    assert (facts.floor_m, facts.height_m, facts.travel_m) == (None, None, None)
    assert set(facts.mapped.values()) == {None}
    words = " ".join(one.what for one in facts.warnings)
    for part in ("no body", "OFFSET", "up axis is unknown", "length of a unit"):
        assert part in words
    assert tracks.positions.tolist() == [[[1.0, 7.0, 3.0]]]
    given, tracks = analyze_motion(
        bvh_to_source_motion(parse_bvh(f"{text}MOTION\nFrames: 1\nFrame Time: 1\n1 2 3 4\n", "x")), unit_m=0.1
    )
    assert given.floor_m == pytest.approx(0.7)
    np.testing.assert_allclose(tracks.positions, [[[0.1, 0.7, 0.3]]])


def test_unit_that_gives_giant_is_reported() -> None:
    facts, _ = analyze_motion(parse_values(still(3)), unit_m=1.0)
    assert facts.unit_m == 1.0
    assert any("the dancer is 173 m tall" in one.what for one in facts.warnings)


def test_motionless_root_is_reported() -> None:
    text = body_bvh(still(20)).replace("ROOT Hips", "ROOT World\n{\nOFFSET 0 0 0\nCHANNELS 0\nJOINT Hips")
    text = text.replace("\nMOTION", "\n}\nMOTION")
    head, numbers = text.split("Frame Time", 1)
    rows = numbers.splitlines()[1:]
    moved = [f"{n} " + row.split(" ", 1)[1] for n, row in enumerate(rows)]
    motion = bvh_to_source_motion(parse_bvh(f"{head}Frame Time: 0.1\n" + "\n".join(moved), "x"))
    facts, _ = analyze_motion(motion)
    assert any("the root World does not move; Hips below it travels" in one.what for one in facts.warnings)
    assert facts.travel_m == pytest.approx(0.19)


def test_floating_body_is_reported() -> None:
    """Half of the time 20 cm above the initial height, as recordings from video drift."""
    drifting = still(200)
    drifting[60:, 1] += 20.0
    facts, _ = analyze_motion(parse_values(drifting))
    assert any("0.20 m over the floor half of the time" in one.what for one in facts.warnings)
    facts, _ = analyze_motion(parse_values(still(200)))
    assert not any("over the floor" in one.what for one in facts.warnings)


def test_glitches_give_warnings_with_frame() -> None:
    values = dance_values(240)
    values[100, column("LeftArm", "Z")] += 90.0
    facts, _ = analyze_motion(parse_values(values))
    assert any(one.frame in (99, 100) and "LeftForeArm" in one.what for one in facts.warnings)


@pytest.mark.shared
def test_files_without_motion_are_refused() -> None:
    with pytest.raises(MotionFileError):
        read_motion(mocap_file("edge/hierarchy_only_no_motion.bvh"))
    assert (MOCAP / "index.json").is_file()
    assert json.loads((MOCAP / "index.json").read_text())
    assert find_body(read("salsa/60_01.bvh")).missing == ()
