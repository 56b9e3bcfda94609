from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.editing.facing import HEAD_LIMIT, face_head, fill_gaps, head_turn, heading_of, turn_clip, wrap
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from tests.motion.editing.made_steps import random_clip, sketched_step

HEAD, NECK, CHEST = (SKELETON.index(name) for name in ("head", "neck", "upperChest"))


def turning_clip(headings: list[float] | np.ndarray) -> Clip:
    """A stiff body that faces `headings` [rad]."""
    yaw = np.asarray(headings, np.float64)
    rotation = np.zeros((len(yaw), SKELETON.joint_count, 4), np.float32)
    rotation[..., 0] = 1.0
    rotation[:, 0] = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), yaw)
    root = np.zeros((len(yaw), 3), np.float32)
    return Clip("turning", root, rotation, 60.0, np.zeros((len(yaw), 2), np.bool_))


def headings(clip: Clip, joint: int) -> np.ndarray:
    _, world = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    return heading_of(world[:, joint])


@pytest.mark.long
@given(st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_head_within_limit_faces_audience_and_body_stays(yaw: float, share: float) -> None:
    clip = turning_clip(np.full(40, yaw))
    faced = face_head(clip, neck_share=share)
    assert headings(faced, HEAD) == pytest.approx(np.zeros(40), abs=1e-5)
    assert headings(faced, NECK) == pytest.approx(np.full(40, (1.0 - share) * yaw), abs=1e-5)
    others = [joint for joint in range(SKELETON.joint_count) if joint not in (HEAD, NECK)]
    assert np.array_equal(faced.rotation[:, others], clip.rotation[:, others])


def test_head_turn_uses_correct_quadrant() -> None:
    # behind and slightly to one side, the arctangent of a ratio would give a small angle in the wrong direction
    assert head_turn(turning_clip(np.full(9, np.radians(170.0)))) == pytest.approx(np.zeros(9))
    assert head_turn(turning_clip(np.full(9, np.radians(50.0)))) == pytest.approx(
        np.full(9, -np.radians(50.0)), abs=1e-6
    )


def test_head_faces_given_target() -> None:
    faced = face_head(turning_clip(np.full(40, 2.0)), target=2.5)
    assert headings(faced, HEAD) == pytest.approx(np.full(40, 2.5), abs=1e-5)


def test_head_turn_is_linear_across_spin() -> None:
    spin = np.concatenate((np.full(30, 0.3), np.linspace(0.3, 0.3 + 2.0 * np.pi, 120), np.full(30, 0.3)))
    theta = head_turn(turning_clip(spin), sigma=0.0)
    beyond = np.abs(wrap(spin)) > HEAD_LIMIT
    assert beyond.sum() > 50
    first, last = np.flatnonzero(beyond)[[0, -1]]
    assert theta[first - 1 : last + 2] == pytest.approx(
        np.linspace(theta[first - 1], theta[last + 1], last - first + 3)
    )
    assert theta[first - 1] == pytest.approx(-HEAD_LIMIT, abs=0.06)
    assert theta[last + 1] == pytest.approx(HEAD_LIMIT, abs=0.06)
    smooth = head_turn(turning_clip(spin), sigma=0.1)
    assert np.abs(np.diff(smooth, 2)).max() < 0.25 * np.abs(np.diff(theta, 2)).max()


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 500), st.floats(-3.0, 3.0), st.floats(0.2, 1.5))
def test_head_stays_within_limit_from_chest(seed: int, yaw: float, limit: float) -> None:
    clip = turn_clip(sketched_step("turn").clip, yaw)
    chance = np.random.default_rng(seed)
    rotation = clip.rotation.copy()
    rotation[:, NECK] = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), chance.uniform(-0.4, 0.4, len(rotation)))
    clip = replace(clip, rotation=rotation)
    faced = face_head(clip, limit=limit)
    before, after = (np.abs(wrap(headings(each, HEAD) - headings(each, CHEST))) for each in (clip, faced))
    assert (after <= np.maximum(limit, before) + 1e-4).all()


@pytest.mark.long
@settings(max_examples=10, deadline=None)
@given(st.integers(0, 200))
def test_rotations_stay_unit_quaternions(seed: int) -> None:
    faced = face_head(random_clip(seed))
    assert np.isfinite(faced.rotation).all()
    assert np.allclose(np.linalg.norm(faced.rotation, axis=-1), 1.0, atol=1e-5)


def test_gaps_are_interpolated_and_empty_selection_gives_zero() -> None:
    kept = np.array((False, True, False, False, True, False))
    assert fill_gaps(np.array((9.0, 1.0, 9.0, 9.0, 4.0, 9.0)), kept) == pytest.approx([1, 1, 2, 3, 4, 4])
    assert fill_gaps(np.array((9.0, 9.0)), np.zeros(2, np.bool_)) == pytest.approx([0.0, 0.0])


@pytest.mark.parametrize("options", [{"limit": 0.0}, {"limit": 4.0}, {"sigma": -1.0}, {"sigma": float("nan")}])
def test_invalid_options_are_refused(options: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="limit"):
        head_turn(turning_clip([0.0]), **options)
