"""Tests of distributing trunks and necks of any length over the engine's joints."""

from itertools import pairwise

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.retarget.rest_pose_alignment import SourcePoints
from live.motion.retarget.retarget import SPINE, SPINE_FRACTIONS, neck_rotation, source_spine_fractions, spine_rotations
from live.motion.retarget.source_body import SourceBody
from live.motion.skeleton import SKELETON

X = np.array((1.0, 0.0, 0.0))


def bend_rotation(degrees: float) -> np.ndarray:
    return quaternion.from_axis_angle(X, np.radians([degrees]))


def angle(rotation: np.ndarray) -> float:
    return float(np.degrees(2.0 * np.arctan2(rotation[0, 1], rotation[0, 0])))


def trunk(*heights: float, neck: float = 1.0) -> SourcePoints:
    """A rest pose with trunk joints at these heights over the hips, and the neck at `neck`."""
    count = len(heights)
    positions = np.zeros((1, count + 2, 3))
    positions[0, :, 1] = (0.0, *heights, neck)
    joints: dict[str, int | None] = dict.fromkeys(SKELETON.names)
    joints["hips"] = 0
    body = SourceBody(joints, tuple(range(1, count + 1)), (count + 1,))
    rotations = np.zeros((1, count + 2, 4))
    rotations[..., 0] = 1.0
    return SourcePoints(body, positions, rotations, {})


def test_spine_fractions_match_skeleton() -> None:
    heights = [SKELETON.rest_positions()[SKELETON.index(n), 1] for n in ("hips", *SPINE, "neck")]
    middles = [(a + b) / 2 for a, b in pairwise(heights[1:])]
    expected = [(m - heights[0]) / (heights[-1] - heights[0]) for m in middles]
    np.testing.assert_allclose(SPINE_FRACTIONS, expected, atol=0.005)


def test_source_spine_fractions_are_computed() -> None:
    np.testing.assert_allclose(source_spine_fractions(trunk(0.2, 0.6)), (0.1, 0.4, 0.8))
    np.testing.assert_allclose(
        source_spine_fractions(trunk(0.0, 0.5, 1.0)), (0.0, 0.25, 0.75, 1.0)
    )  # hips and neck on joints
    np.testing.assert_allclose(source_spine_fractions(trunk(neck=0.0)), (0.0,))


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7])
def test_even_bend_stays_even(count: int) -> None:
    """A trunk bent like an arc: each engine joint gets the share of its height."""
    heights = [(n + 0.5) / (count + 0.5) for n in range(count)]
    rest = trunk(*heights)
    places = source_spine_fractions(rest)
    rotations = spine_rotations(
        rest, bend_rotation(90.0 * places[0]), [bend_rotation(90.0 * place) for place in places[1:]]
    )
    for name, place in zip(SPINE, SPINE_FRACTIONS, strict=True):
        assert angle(rotations[name]) == pytest.approx(90.0 * float(np.clip(place, places[0], places[-1])), abs=1e-6)


def test_engine_spine_stays_unchanged() -> None:
    heights = np.cumsum([np.linalg.norm(SKELETON.offsets[SKELETON.index(name)]) for name in (*SPINE, "neck")])
    rest = trunk(*heights[:3], neck=float(heights[3]))
    chain = [bend_rotation(10.0), bend_rotation(35.0), bend_rotation(20.0)]
    rotations = spine_rotations(rest, bend_rotation(-5.0), chain)
    for name, expected in zip(SPINE, chain, strict=True):
        assert angle(rotations[name]) == pytest.approx(angle(expected), abs=1e-4)


def test_missing_trunk_takes_hip_rotation() -> None:
    rotations = spine_rotations(trunk(), bend_rotation(30.0), [])
    assert [angle(rotations[name]) for name in SPINE] == pytest.approx([30.0] * 3)


@pytest.mark.parametrize(
    ("chain", "expected"), [([], 20.0), ([15.0], 15.0), ([10.0, 30.0], 20.0), ([10.0, 12.0, 30.0], 12.0)]
)
def test_neck_rotation_follows_chain(chain: list[float], expected: float) -> None:
    rotation = neck_rotation([bend_rotation(a) for a in chain], bend_rotation(0.0), bend_rotation(40.0))
    assert angle(rotation) == pytest.approx(expected, abs=1e-6)
