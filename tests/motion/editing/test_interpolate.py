from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from live.motion.editing.interpolate import follow_arc, interpolate
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import mirror_step
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip, corresponding_samples, foot_slide, travel
from tests.fixtures.mostly_long import mostly_long
from tests.motion.editing.made_steps import random_step, sketched_step

WEIGHTS = st.floats(0.0, 1.0)


def perturbed_step(step: StepClip, seed: int) -> StepClip:
    """The step with every joint rotated by about a radian at most, and the root shifted by 0.3 m."""
    chance = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(chance.uniform(-0.6, 0.6, (step.clip.rotation.shape[1], 3)))
    turned = [
        (Rotation.from_quat(joint, scalar_first=True) * turn[j]).as_quat(scalar_first=True)
        for j, joint in enumerate(step.clip.rotation.transpose(1, 0, 2))
    ]
    rotation = np.ascontiguousarray(np.array(turned).transpose(1, 0, 2), np.float32)
    root = step.clip.root_position + np.float32(0.3)
    return replace(step, clip=replace(step.clip, rotation=rotation, root_position=root))


@pytest.mark.parametrize("hold_feet", [True, False])
def test_weights_0_and_1_give_original_clips(hold_feet: bool) -> None:
    a, b = sketched_step("walk", "long forward"), sketched_step("walk", "long left")
    for weight, clip in ((0.0, a), (1.0, b), (1e-9, a), (1.0 - 1e-9, b)):
        mixed = interpolate(a, b, weight, hold_feet=hold_feet).clip
        dots = np.abs(np.sum(mixed.rotation * clip.clip.rotation, axis=-1))
        assert dots.min() > 1.0 - 1e-5
        assert np.allclose(mixed.root_position, clip.clip.root_position, atol=1e-5)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 100), WEIGHTS)
def test_rotations_match_scipy_slerp_and_root_is_linear(seed: int, weight: float) -> None:
    a = random_step(seed)
    b = perturbed_step(a, seed + 1)
    mixed = interpolate(a, b, weight, hold_feet=False)
    for joint in (0, 5, 21):
        for sample in (0, 33):
            ends = Rotation.from_quat(np.stack([c.clip.rotation[sample, joint] for c in (a, b)]), scalar_first=True)
            expected = Slerp([0.0, 1.0], ends)([weight]).as_quat(scalar_first=True)[0]
            assert abs(expected @ mixed.clip.rotation[sample, joint]) == pytest.approx(1.0, abs=1e-6)
    assert np.allclose(mixed.clip.root_position, a.clip.root_position + weight * 0.3, atol=1e-6)


@pytest.mark.long
@settings(max_examples=10, deadline=None)
@given(st.integers(0, 100), WEIGHTS, st.booleans())
def test_quaternions_stay_unit_and_bone_lengths_stay(seed: int, weight: float, hold_feet: bool) -> None:
    a = random_step(seed)
    mixed = interpolate(a, random_step(seed + 1000), weight, hold_feet=hold_feet).clip
    assert np.allclose(np.linalg.norm(mixed.rotation, axis=-1), 1.0, atol=1e-5)
    position, _ = forward_kinematics(mixed.root_position.astype(np.float64), mixed.rotation.astype(np.float64))
    for joint, parent in enumerate(SKELETON.parents):
        if parent >= 0:
            length = np.linalg.norm(position[:, joint] - position[:, parent], axis=-1)
            assert length == pytest.approx(np.linalg.norm(SKELETON.offsets[joint]), abs=1e-5)


@mostly_long("other", ["long left", "short forward", "long back", "in place"], quick=[0, 1])
def test_blended_directions_do_not_slide_and_travel_between(other: str) -> None:
    a, b = sketched_step("walk", "long forward"), sketched_step("walk", other)
    mixed = interpolate(a, b, 0.4)
    slides = [foot_slide(step) for step in (a, b, mixed)]
    assert slides[0] is not None
    assert slides[2] == pytest.approx(max(slides[0], slides[1] or 0.0), abs=0.002)
    assert travel(mixed) == pytest.approx(0.6 * travel(a) + 0.4 * travel(b), abs=1e-5)
    assert mixed.distance_m == pytest.approx(float(np.hypot(*travel(mixed))))


def test_foot_holding_changes_legs_only() -> None:
    a, b = sketched_step("walk", "long forward"), sketched_step("walk", "long left")
    plain, held = (interpolate(a, b, 0.5, hold_feet=hold).clip for hold in (False, True))
    upper = [j for j, name in enumerate(SKELETON.names) if not name.endswith(("Leg", "Foot"))]
    assert np.array_equal(plain.rotation[:, upper], held.rotation[:, upper])
    assert np.array_equal(plain.root_position, held.root_position)
    assert not np.allclose(plain.rotation, held.rotation, atol=1e-3)


def test_contact_requires_contact_in_both_clips() -> None:
    a, b = sketched_step("kick"), sketched_step("kick", "long forward")
    mixed = interpolate(a, replace(b, clip=replace(b.clip, contact=np.zeros_like(b.clip.contact))), 0.5)
    assert a.clip.contact.any()
    assert not mixed.clip.contact.any()
    assert np.array_equal(interpolate(a, b, 0.5).clip.contact, a.clip.contact & b.clip.contact)


def test_clips_are_aligned_by_fraction_of_measure() -> None:
    a = sketched_step("walk")
    half = StepClip(
        step=a.step,
        clip=replace(
            a.clip,
            rotation=np.ascontiguousarray(a.clip.rotation[::2]),
            root_position=np.ascontiguousarray(a.clip.root_position[::2]),
            contact=np.ascontiguousarray(a.clip.contact[::2]),
        ),
        first=a.first / 2.0,
        samples_per_measure=a.samples_per_measure / 2.0,
        leading_foot=a.leading_foot,
        begin_pose=a.begin_pose,
        end_pose=a.end_pose,
        weight_transfer=a.weight_transfer,
    )
    assert corresponding_samples(half, a)[:4] == pytest.approx([0.0, 0.5, 1.0, 1.5])
    mixed = interpolate(a, half, 0.5).clip
    assert np.abs(np.sum(mixed.rotation * a.clip.rotation, axis=-1)).min() > 0.9999


def test_arc_is_followed_past_half_turn_without_jump() -> None:
    yaw = np.linspace(0.0, np.radians(250.0), 50)
    a = np.stack((np.cos(0.25 * yaw), 0 * yaw, np.sin(0.25 * yaw), 0 * yaw), axis=-1)
    b = a * (1.0, 1.0, -1.0, 1.0) * np.where(np.arange(50) % 3 == 0, -1.0, 1.0)[:, None]
    assert np.allclose(np.abs(follow_arc(a, b, 0.5, 0)[:, 0]), 1.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"step": "other"}, "different steps"),
        ({"mirrored": True}, "differ in structure: mirrored"),
        ({"begin_pose": "low"}, "differ in structure: begin pose"),
        ({"end_pose": "low"}, "differ in structure: end pose"),
        ({"beats_per_measure": 3}, "4 and 3 beats in a measure"),
    ],
)
def test_different_steps_and_structures_are_refused(change: dict[str, object], words: str) -> None:
    a = random_step(1)
    with pytest.raises(ValueError, match=words):
        interpolate(a, replace(a, **change), 0.5)  # type: ignore[arg-type]


def test_different_leading_feet_are_refused() -> None:
    a = replace(random_step(1), leading_foot="left")
    with pytest.raises(ValueError, match="leading foot is 'left' and 'right'"):
        interpolate(a, mirror_step(a), 0.5)
    right = replace(random_step(2), leading_foot="right")
    assert interpolate(a, mirror_step(right), 0.5).clip.sample_count == a.clip.sample_count


@pytest.mark.parametrize("weight", [-0.1, 1.1, float("nan")])
def test_weight_outside_0_to_1_is_refused(weight: float) -> None:
    with pytest.raises(ValueError, match="weight"):
        interpolate(random_step(1), random_step(2), weight)
