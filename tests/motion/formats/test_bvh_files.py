"""Tests of BVH reading on real recordings: all facts of the index are found."""

from typing import Any

import numpy as np
import pytest

from live.motion.formats.bvh_reader import local_pose, parse_bvh
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_axes import find_unit, leg_length, standing_pose
from live.motion.formats.source_motion import world_pose
from live.motion.retarget.joint_mapping import find_body
from tests.fixtures.mocap import mocap_bvh, mocap_index, mocap_motion, mocap_text

pytestmark = pytest.mark.shared
ROWS = [row for row in mocap_index() if row.get("joints") is not None]
ROWS = [row for row in ROWS if row["family"] != "DAZ-43" or row["file"].endswith("_01.bvh")]  # one pair will do
BODIES = [row for row in ROWS if row["joints"] > 4]


def row_file(row: dict[str, Any]) -> str:
    return str(row["file"])


@pytest.mark.skipif(not ROWS, reason="needs ../shared/mocap")
def test_index_has_over_35_recordings() -> None:
    assert len(ROWS) > 35


@pytest.mark.parametrize("row", ROWS, ids=row_file)
def test_counts_and_rates_match_index(row: dict[str, Any]) -> None:
    motion = mocap_bvh(row["file"])
    assert (motion.joint_count, motion.end_parents.size) == (row["joints"], row["end_sites"])
    assert motion.values.shape[1] == row["channels"]
    assert motion.frames_declared == row["frames_declared"]
    assert motion.frame_count == row["frames"] + ("off_by_one" in row["file"])
    assert bool(motion.warnings) == bool(row["warnings"])
    assert motion.frame_time == pytest.approx(row["frame_time"], rel=1e-5)
    orders: dict[str, int] = {}
    for letters in motion.channels:
        if letters:
            orders[f"{len(letters)}:{letters}"] = orders.get(f"{len(letters)}:{letters}", 0) + 1
    assert orders == row["orders"]


@pytest.mark.parametrize("row", BODIES, ids=row_file)
def test_up_axis_unit_and_root_offset_match_index(row: dict[str, Any]) -> None:
    motion = mocap_motion(row["file"])
    body = find_body(motion)
    assert body.missing == ()
    world, up = standing_pose(motion, body, None)
    if row["up_axis"] is not None:
        assert up == row["up_axis"]
    if row["root_offset"] != "unclear":
        assert motion.root_offset == ("zero" if row["root_offset"] == "none" else row["root_offset"])
    if row["unit_cm"] is not None and row["unit_cm"] != 128:  # 1.28 m is not a common unit: it looks like 1 m
        assert find_unit(leg_length(body, world.positions)) == pytest.approx(row["unit_cm"] / 100.0, rel=1e-3)


def test_file_without_motion_is_refused() -> None:
    text = mocap_text("edge/hierarchy_only_no_motion.bvh")
    with pytest.raises(MotionFileError, match="no MOTION section") as caught:
        parse_bvh(text, "hierarchy_only_no_motion.bvh")
    assert caught.value.line == text.count("\n") + 1


def test_scaled_copy_has_same_motion() -> None:
    """salsa_60_05_scaled.bvh is salsa/60_05.bvh in units of 1.28 m without its first frame."""
    one, other = mocap_bvh("salsa/60_05.bvh"), mocap_bvh("edge/salsa_60_05_scaled.bvh")
    here, there = (world_pose(motion.parents, local_pose(motion)).positions for motion in (one, other))
    np.testing.assert_allclose(here[1:], there * 128.0, atol=0.02)


@pytest.mark.parametrize("name", ["salsa/60_01.bvh", "solo/rokoko_jesse_dance.bvh", "edge/crlf_tabs_mocapbank.bvh"])
def test_truncated_recording_is_shorter_or_error(name: str) -> None:
    text = mocap_text(name)
    whole = parse_bvh(text, name)
    for place in np.linspace(0, len(text) - 200, 23).astype(int):
        try:
            motion = parse_bvh(text[:place], name)
        except MotionFileError:
            continue
        assert motion.frame_count < whole.frame_count
        assert motion.warnings
        np.testing.assert_array_equal(motion.values[:-1], whole.values[: motion.frame_count - 1])
