from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion.clip import Clip
from live.motion.editing.foot_correction import correct_floor, find_feet, smooth_upper_bound
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from tests.motion.editing.made_steps import sketched_step

LEG = {side + joint for side in ("left", "right") for joint in ("UpperLeg", "LowerLeg", "Foot")}


def sunken_clip(name: str, depth: float, samples: slice = slice(None)) -> Clip:
    clip = sketched_step(name).clip
    root = clip.root_position.copy()
    root[samples, 1] -= np.float32(depth)
    return replace(clip, root_position=root)


def test_clip_above_floor_is_returned_unchanged() -> None:
    clip = sunken_clip("walk", -0.02)
    corrected = correct_floor(clip)
    assert corrected.clip is clip
    assert not corrected.lift.any()


@pytest.mark.long
@settings(max_examples=15, deadline=None)
@given(st.sampled_from(("walk", "samba", "kick", "jump")), st.floats(0.001, 0.06), st.integers(0, 150))
def test_soles_stay_above_floor_and_only_legs_bend(name: str, depth: float, start: int) -> None:
    clip = sunken_clip(name, depth, slice(start, start + 40))
    corrected = correct_floor(clip)
    assert find_feet(corrected.clip).height.min() > -2e-6
    assert corrected.lift.max() >= depth - 0.003
    others = [j for j, joint in enumerate(SKELETON.names) if joint not in LEG]
    assert np.array_equal(corrected.clip.rotation[:, others], clip.rotation[:, others])
    assert np.array_equal(corrected.clip.root_position, clip.root_position)
    assert np.allclose(np.linalg.norm(corrected.clip.rotation, axis=-1), 1.0, atol=1e-5)


def test_feet_keep_floor_positions_and_rotations() -> None:
    clip = sunken_clip("walk", 0.03, slice(100, 150))
    corrected = correct_floor(clip)
    before, after = find_feet(clip), find_feet(corrected.clip)
    for one, other in ((before.ankle, after.ankle), (before.ball, after.ball)):
        assert np.abs(one - other)[..., (0, 2)].max() < 1e-5
        assert np.allclose(other[..., 1] - one[..., 1], corrected.lift, atol=1e-5)
    rotations = [
        forward_kinematics(c.root_position, c.rotation)[1][:, SKELETON.index("leftToes")]
        for c in (clip, corrected.clip)
    ]
    assert np.abs(np.sum(rotations[0] * rotations[1], axis=-1)).min() > 1.0 - 1e-5


def test_lift_rises_and_falls_smoothly() -> None:
    clip = sunken_clip("walk", 0.04, slice(100, 150))
    lift = correct_floor(clip).lift
    assert lift[:70].max() < 1e-3
    assert np.abs(np.diff(lift, axis=0)).max() < 0.012  # 4 cm over a tenth of a second, where the root jumps in one
    assert lift[120].max() == pytest.approx(0.04, abs=2e-3)


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=60), st.integers(1, 8))
def test_upper_bound_covers_depth_and_vanishes_far_away(depths: list[float], half: int) -> None:
    depth = np.array(depths)[:, None]
    lift = smooth_upper_bound(depth, half)
    assert lift.shape == depth.shape
    assert (lift >= depth - 1e-12).all()
    assert lift.max() <= depth.max() + 1e-12
    for n in range(len(depths)):
        if depth[max(0, n - 2 * half) : n + 2 * half + 1].max() == 0.0:
            assert lift[n] == pytest.approx(0.0, abs=1e-12)
