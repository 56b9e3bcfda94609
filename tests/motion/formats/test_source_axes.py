"""Tests of properties missing from a file (unit, up axis, root offset), on generated bodies."""

import numpy as np
import pytest

from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.source_axes import (
    ENGINE_LEG,
    body_height,
    find_unit,
    find_up,
    leg_length,
    standing_pose,
)
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.joint_mapping import find_body
from live.motion.retarget.source_body import SourceBody
from tests.motion.formats.made_bvh import STANDING_CM, body_bvh, column, dance_values, still


def read(values: np.ndarray, **how: object) -> tuple[SourceMotion, SourceBody, np.ndarray]:
    motion = bvh_to_source_motion(parse_bvh(body_bvh(values, **how), "made"))  # type: ignore[arg-type]
    body = find_body(motion)
    return motion, body, standing_pose(motion, body, None)[0].positions


def test_engine_leg_is_805_mm_and_body_170_cm() -> None:
    assert pytest.approx(0.805) == ENGINE_LEG
    assert body_height(ENGINE_LEG) == pytest.approx(1.7)


def test_leg_length_is_found_in_motion() -> None:
    _, body, positions = read(dance_values())
    assert leg_length(body, positions) == pytest.approx(82.0, abs=1e-6)


@pytest.mark.parametrize("unit", [1.0, 0.1, 0.01, 0.001, 0.0254, 0.3048, 0.056444])
def test_common_units_are_found(unit: float) -> None:
    assert find_unit(0.82 / unit) == pytest.approx(unit, rel=1e-4)


def test_implausible_body_size_gives_no_unit() -> None:
    for leg in (0.0, -1.0, float("nan"), 0.02, 300.0, 1e6):
        assert find_unit(leg) is None


@pytest.mark.parametrize("z_up", [False, True])
def test_up_axis_points_toward_shoulders(z_up: bool) -> None:
    _, body, positions = read(dance_values(), z_up=z_up)
    assert find_up(body, positions) == ("Z" if z_up else "Y")


def test_lying_body_gives_no_up_axis() -> None:
    values = still(5)
    values[:, column("Hips", "Z")] = 90.0
    _, body, positions = read(values)
    assert find_up(body, positions) is None


@pytest.mark.parametrize("z_up", [False, True])
@pytest.mark.parametrize("use", ["add", "replace"])
def test_root_offset_use_is_add_or_replace(use: str, z_up: bool) -> None:
    values = dance_values()
    if use == "add":
        values[:, 1] -= STANDING_CM
    motion, body, _ = read(values, offsets={"Hips": (3.0, STANDING_CM, 7.0)}, z_up=z_up)
    assert motion.root_offset == use
    world, up = standing_pose(motion, body, None)
    assert up == ("Z" if z_up else "Y")
    lowest = world.positions[..., 2 if z_up else 1].min(axis=1)
    assert abs(np.median(lowest)) < 30.0


def test_root_offset_is_zero_or_unknown() -> None:
    assert read(dance_values())[0].root_offset == "zero"
    assert read(still(1), offsets={"Hips": (0.0, STANDING_CM, 0.0)})[0].root_offset is None
    assert read(dance_values(), offsets={"Hips": (50.0, 0.0, 0.0)})[0].root_offset is None
